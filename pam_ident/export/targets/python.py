"""A fitted model as a Python function that needs NumPy alone."""

import keyword

from ..fitted import Fitted
from ..graph import MEANING
from ..program import Block, Program, program
from ..target import Target, Written
from ..writer import COMPARE, INFIX, Dialect, Names, check_name, constants, heading, statements

_TWO = {"atan2", "pow", "max", "min", "rem", "and", "or"}
PYTHON = Dialect(
    infix=INFIX | COMPARE | {"ne": ("!=", 4)},
    calls={
        op: f"np.{function.__name__}({'{0}, {1}' if op in _TWO else '{0}'})"
        for op, function in MEANING.items()
        if op not in {*INFIX, *COMPARE, "ne", "neg", "select"}
    }
    | {"select": "np.where({0}, {1}, {2})"},
    statement="{0} = {1}",
    logical="{0} = {1}",
    remark="#",
    truth=("False", "True"),
    words=frozenset([*keyword.kwlist, *keyword.softkwlist, "np", "print", "tuple"]),
)


def python_function(fitted: Fitted, name: str) -> str:
    """The text of NAME.py: `NAME(…)` is the force, or where the model remembers, the force and the next `state`.

    Arguments are numbers or arrays. Raises UsageError for a name that Python does not take, or a model that cannot be
    exported.
    """
    check_name(name, PYTHON)
    made = program(fitted)
    names = Names.choose(PYTHON, made, name, "memory[{}]")
    arguments = ", ".join(made.arguments)
    use = f"{name}({arguments})"
    if made.later is not None:
        arguments, use = f"{arguments}, state=None", f"force, state = {name}({arguments}, state), state None at first"
    lines = heading(PYTHON, fitted, made, [f"Force of a pneumatic artificial muscle, for Python with NumPy: {use}"])
    lines += ["", "import numpy as np", "", "", f"def {name}({arguments}):"]
    lines += [f"    {line}" for line in constants(PYTHON, fitted, made, names)]
    if made.later is None:
        lines += _block(made, made.first, names, "    ")
    else:
        lines += ["    if state is None:", *_block(made, made.first, names, " " * 8)]
        lines += ["    memory = state", *_block(made, made.later, names, "    ")]
    return "\n".join([*lines, ""])


def _block(made: Program, block: Block, names: Names, indent: str) -> list[str]:
    body, (force, *after) = statements(PYTHON, made.graph, block, names)
    answer = force if made.later is None else f"{force}, ({', '.join(after)},)"
    return [indent + line for line in [*body, f"return {answer}"]]


TARGET = Target(".py", lambda fitted, name: Written(python_function(fitted, name)))
