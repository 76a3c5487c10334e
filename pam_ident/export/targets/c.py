"""A fitted model as a C99 header."""

from ..fitted import Fitted
from ..program import Program, program
from ..target import Target, Written
from ..writer import COMPARE, INFIX, Dialect, Names, check_name, constants, heading, statements

PLAIN = "exp expm1 log log1p sin cos tan asin acos atan atan2 sinh cosh tanh sqrt cbrt pow floor ceil abs max min rem"
OTHER_NAME = {"abs": "fabs", "max": "fmax", "min": "fmin", "rem": "fmod"}
TWO = {"atan2", "pow", "max", "min", "rem"}
WORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long register "
    "restrict return short signed sizeof static struct switch typedef union unsigned void volatile while main "
    "y0 y1 yn j0 j1 jn gamma"
)
C = Dialect(
    infix=INFIX | COMPARE | {"ne": ("!=", 4), "and": ("&&", 2), "or": ("||", 1)},
    calls={op: f"{OTHER_NAME.get(op, op)}({'{0}, {1}' if op in TWO else '{0}'})" for op in PLAIN.split()}
    | {"not": "(!({0}))", "select": "(({0}) ? {1} : {2})"},
    statement="const double {0} = {1};",
    logical="const int {0} = {1};",
    remark="//",
    truth=("0", "1"),
    words=frozenset([*WORDS.split(), *PLAIN.split(), *OTHER_NAME.values()]),
)


def c_header(fitted: Fitted, name: str, made: Program | None = None) -> str:
    """The text of NAME.h: `NAME_force(…)`, or of a model that remembers `NAME_init(&state)` and
    `NAME_step(&state, …)`. `made` is the model's program, where it is there already.

    Raises UsageError for a name that C does not take, or a model that cannot be exported.
    """
    check_name(name, C)
    made = program(fitted) if made is None else made
    names = Names.choose(C, made, name, "state->memory[{}]")
    arguments = ", ".join(f"double {argument}" for argument in made.arguments)
    use = f"{name}_force({', '.join(made.arguments)})"
    if made.later is not None:
        use = f"{name}_init(&state), then {name}_step(&state, {', '.join(made.arguments)}) sample by sample"
    lines = heading(C, fitted, made, [f"Force of a pneumatic artificial muscle, C99: {use}"])
    guard = f"{name.upper()}_H"
    lines += ["", f"#ifndef {guard}", f"#define {guard}", "", "#include <math.h>", ""]
    given = [f"    {line}" for line in constants(C, fitted, made, names)]
    if made.later is None:
        body, ends = statements(C, made.graph, made.first, names)
        lines += [f"static inline double {name}_force({arguments})", "{", *given, *_unused(made)]
        lines += [*(f"    {line}" for line in body), f"    return {ends[0]};", "}"]
    else:
        lines += _state(name, len(made.memory))
        lines += [f"static inline double {name}_step({name}_state *state, {arguments})", "{", *given, *_unused(made)]
        lines += ["    if (!state->started) {", *_block(made, names, first=True), "    }"]
        lines += [*_block(made, names, first=False), "}"]
    return "\n".join([*lines, "", f"#endif  // {guard}", ""])


def _state(name: str, size: int) -> list[str]:
    return [
        "// What the muscle remembers of the last sample.",
        f"typedef struct {{ int started; double memory[{size}]; }} {name}_state;",
        "",
        "// The muscle at rest, before its first sample.",
        f"static inline void {name}_init({name}_state *state)",
        "{",
        f"    *state = ({name}_state){{0}};",
        "}",
        "",
        "// Force at the next sample.",
    ]


def _block(made: Program, names: Names, first: bool) -> list[str]:
    block, indent = (made.first, " " * 8) if first else (made.later, " " * 4)
    assert block is not None
    body, (force, *after) = statements(C, made.graph, block, names)
    lines = [*body, f"const double force = {force};"]
    lines += ["state->started = 1;"] if first else []
    lines += [f"{names.given[slot]} = {end};" for slot, end in zip(made.memory, after, strict=True)]
    return [indent + line for line in [*lines, "return force;"]]


def _unused(made: Program) -> list[str]:
    """Arguments and parameters that a part of the program leaves alone, so that no compiler warns."""
    blocks = [made.first] if made.later is None else [made.first, made.later]
    used = {made.graph.nodes[n].leaf for block in blocks for n in made.graph.reached(block.ends)}
    return [f"    (void){argument};" for argument in made.arguments if argument not in used]


TARGET = Target(".h", lambda fitted, name: Written(c_header(fitted, name)))
