"""A program as statements of a language: what all languages share."""

import math
import re
import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .. import __version__
from ..core import UsageError
from .fitted import Fitted, Parameter
from .graph import Graph
from .program import ARGUMENTS, Block, Program, named_parameters

INFIX = {"add": ("+", 5), "sub": ("-", 5), "mul": ("*", 6), "div": ("/", 6)}
COMPARE = {"lt": ("<", 4), "le": ("<=", 4), "gt": (">", 4), "ge": (">=", 4), "eq": ("==", 4)}
NEGATIVE, ATOM = 7, 9
"""How tightly a sign and a call bind; larger binds tighter."""
LONGEST = 72
"""Characters of an expression that is still written where it is used."""


@dataclass(frozen=True)
class Dialect:
    """A language: `calls` and `infix` (with how tightly they bind) write operations, `words` cannot be names.

    `statement` and `logical` write `name = expression` for a number and for yes or no. `remark` begins a comment.
    """

    infix: Mapping[str, tuple[str, int]]
    calls: Mapping[str, str]
    statement: str
    logical: str
    remark: str
    truth: tuple[str, str]
    words: frozenset[str]


@dataclass(frozen=True)
class Names:
    """Names in the text of what has a name in the program, and of what is computed on the way."""

    given: Mapping[str, str]
    memory: tuple[str, ...]

    @classmethod
    def choose(cls, dialect: Dialect, program: Program, name: str, memory: str, base: int = 0) -> "Names":
        """Of arguments their own; of parameters theirs, changed where the language or an argument has the name.

        `memory` writes a remembered number by its place, counted from `base`.
        """
        taken = {*dialect.words, *ARGUMENTS, name, "state", "force", "memory", "self", "started", "next"}
        given = {argument: argument for argument in ARGUMENTS}
        given |= {slot: memory.format(k) for k, slot in enumerate(program.memory, base)}
        for constant in program.constants:
            word = re.sub(r"\W", "_", constant[1:], flags=re.ASCII)
            word = word if word[:1].isalpha() else f"p_{word}"
            while word in taken or word.startswith("t_"):
                word = f"p_{word}"
            taken.add(word)
            given[constant] = word
        return cls(given, program.memory)


def check_name(name: str, dialect: Dialect) -> str:
    """A name for a function. Raises UsageError for what no language takes as one."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,47}", name) or name in dialect.words:
        raise UsageError(
            f"{name!r} names the function in the file; expected a file name of letters, digits and _ that begins with "
            "a letter and is no word of the language"
        )
    return name


def statements(dialect: Dialect, graph: Graph, block: Block, names: Names) -> tuple[list[str], list[str]]:
    """Lines that compute a block, then the expressions of its ends: the force, and what is remembered.

    What is remembered has been computed by then, so that it can be put away in any order.
    """
    needed = graph.reached(block.ends)
    uses = Counter(argument for node in needed for argument in graph.nodes[node].args)
    put_away = {end for end in block.memory if graph.nodes[end].args or graph.nodes[end].leaf in names.memory}
    texts: dict[int, tuple[str, int]] = {}
    lines: list[str] = []
    for node in needed:
        text, binding = _expression(dialect, graph, node, texts, names)
        leaf = not graph.nodes[node].args
        if node in put_away or (not leaf and node != block.force and (uses[node] > 1 or len(text) > LONGEST)):
            word = f"t_{len(lines) + 1}"
            form = dialect.logical if graph.answers(node) else dialect.statement
            lines.append(form.format(word, text))
            text, binding = word, ATOM
        texts[node] = text, binding
    return lines, [texts[end][0] for end in block.ends]


def _expression(
    dialect: Dialect, graph: Graph, node: int, texts: Mapping[int, tuple[str, int]], names: Names
) -> tuple[str, int]:
    one = graph.nodes[node]
    if one.op == "name":
        return names.given[str(one.leaf)], ATOM
    if one.op == "number":
        if isinstance(one.leaf, bool):
            return dialect.truth[one.leaf], ATOM
        return repr(one.leaf), ATOM if math.copysign(1.0, float(one.leaf)) > 0 else NEGATIVE
    if one.op == "neg":
        text, binding = texts[one.args[0]]
        return f"-{text}" if binding > NEGATIVE else f"-({text})", NEGATIVE
    if one.op in dialect.infix:
        sign, own = dialect.infix[one.op]
        (left, binding), (right, other) = (texts[a] for a in one.args)
        left = left if (binding >= own and own != COMPARE["lt"][1]) or binding > own else f"({left})"
        return f"{left} {sign} {right if other > own else f'({right})'}", own
    return dialect.calls[one.op].format(*(texts[a][0] for a in one.args)), ATOM


def heading(dialect: Dialect, fitted: Fitted, program: Program, about: Sequence[str]) -> list[str]:
    """Comment lines: `about` the file, the equation, where it is from, what it holds for, arguments and parameters."""
    lines = [*about, "", *str(fitted.model).splitlines(), ""]
    one = fitted.specimen
    lines.append(
        f"Muscle {one.name}: initial length {one.initial_length_mm:g} mm, radius {one.initial_radius_mm:g} mm, "
        f"braid angle {one.braid_angle_deg:g} degrees to the axis."
    )
    lines.append(f"Fitted to {fitted.record or 'an unnamed record'}, written by pam-ident {__version__}.")
    lines += [f"Error left, {branch}: {value:.3g} N rms." for branch, value in fitted.rmse_N.items()]
    lines += [f"{fitted.caution}."] if fitted.caution else []
    if fitted.span is None:
        lines.append("The range of the record is not known: do not trust it far from the data.")
    else:
        (p_low, p_high), (e_low, e_high) = fitted.span
        lines.append(
            f"Valid where it was fitted: {p_low:.4g} to {p_high:.4g} MPa, contraction {e_low:.4g} to {e_high:.4g}."
        )
    lines += [f"Warning: {problem}." for problem in fitted.problems]
    lines += ["", "Result: force in N, positive where the muscle pulls. Arguments:"]
    lines += [f"  {name}: {ARGUMENTS[name]}" for name in program.arguments]
    unused = [p for name, p in named_parameters(fitted) if name not in program.constants]
    if unused:
        lines += ["Parameters that stand in no formula below: they are part of its numbers."]
        lines += [f"  {p.name} = {p.value!r} {told(p)}" for p in dict.fromkeys(unused)]
    return remarks(dialect, lines)


def remarks(dialect: Dialect, lines: Sequence[str]) -> list[str]:
    """Lines as comments, wrapped; nothing in them can end the comment or join the next line."""
    wrapped = [part for line in lines for part in (textwrap.wrap(harmless(line), 110, subsequent_indent="  ") or [""])]
    return [f"{dialect.remark} {line}".rstrip() for line in wrapped]


def constants(dialect: Dialect, fitted: Fitted, program: Program, names: Names) -> list[str]:
    """A statement for each parameter, with unit, standard error and meaning."""
    lines = []
    for name, p in named_parameters(fitted):
        if name in program.constants:
            line = dialect.statement.format(names.given[name], repr(p.value))
            lines.append(f"{line}  {dialect.remark} {harmless(told(p))}")
    return lines


def told(p: Parameter) -> str:
    """Unit, standard error and meaning."""
    error = f" ± {p.stderr:.2g}" if math.isfinite(p.stderr) else ""
    return f"[{p.unit}]{error}: {p.doc}"


def harmless(text: str) -> str:
    """Text of one line without signs that mean something in a comment."""
    return re.sub(r"\?\?|\\", "/", "".join(c if c.isprintable() else " " for c in text))
