"""A fitted model as a MATLAB function, which runs in Octave too."""

from ..fitted import Fitted
from ..program import Block, Program, program
from ..target import Target, Written
from ..writer import COMPARE, INFIX, Dialect, Names, check_name, constants, heading, statements

_SAME = "exp expm1 log log1p sin cos tan asin acos atan atan2 sinh cosh tanh sqrt floor ceil abs max min rem"
_TWO = {"atan2", "max", "min", "rem"}
_WORDS = (
    "break case catch classdef continue else elseif end for function global if otherwise parfor persistent return spmd "
    "switch try while unwind_protect do until end_try_catch endfunction endif endwhile endfor pick zeros size nargin "
    "isempty logical power nthroot"
)
MATLAB = Dialect(
    infix=INFIX | COMPARE | {"mul": (".*", 6), "div": ("./", 6), "ne": ("~=", 4), "and": ("&", 2), "or": ("|", 1)},
    calls={op: f"{op}({'{0}, {1}' if op in _TWO else '{0}'})" for op in _SAME.split()}
    | {"cbrt": "nthroot({0}, 3)", "pow": "power({0}, {1})"}
    | {"not": "(~({0}))", "select": "pick({0}, {1}, {2})"},
    statement="{0} = {1};",
    logical="{0} = {1};",
    remark="%",
    truth=("false", "true"),
    words=frozenset([*_WORDS.split(), *_SAME.split()]),
)
PICK = """
function chosen = pick(test, yes, no)
    same = zeros(size(test)) + zeros(size(yes)) + zeros(size(no));
    yes = yes + same;
    chosen = no + same;
    test = logical(test + same);
    chosen(test) = yes(test);
end
"""


def matlab_function(fitted: Fitted, name: str) -> str:
    """The text of NAME.m: `force = NAME(…)`, or where the model remembers, `[force, state] = NAME(…, state)`.

    Arguments are numbers or arrays of one size. Raises UsageError for a name that MATLAB does not take, or a model that
    cannot be exported.
    """
    check_name(name, MATLAB)
    made = program(fitted)
    names = Names.choose(MATLAB, made, name, "state{{{}}}", 1)
    arguments = ", ".join(made.arguments)
    results = "force"
    use = f"force = {name}({arguments})"
    if made.later is not None:
        arguments, results = f"{arguments}, state", "[force, state]"
        use = f"[force, state] = {name}({arguments}), state [] at first"
    lines = [f"function {results} = {name}({arguments})"]
    lines += heading(MATLAB, fitted, made, [f"{name.upper()}  Force of a pneumatic artificial muscle: {use}"])
    lines += [f"    {line}" for line in constants(MATLAB, fitted, made, names)]
    if made.later is None:
        lines += _block(made, made.first, names, "    ")
    else:
        lines += [f"    if nargin < {len(made.arguments) + 1} || isempty(state)"]
        lines += [*_block(made, made.first, names, " " * 8), "        return", "    end"]
        lines += _block(made, made.later, names, "    ")
    return "\n".join([*lines, "end", PICK])


def _block(made: Program, block: Block, names: Names, indent: str) -> list[str]:
    body, (force, *after) = statements(MATLAB, made.graph, block, names)
    lines = [*body, f"force = {force};"]
    if made.later is not None:
        lines.append(f"state = {{{', '.join(after)}}};")
    return [indent + line for line in lines]


TARGET = Target(".m", lambda fitted, name: Written(matlab_function(fitted, name)))
