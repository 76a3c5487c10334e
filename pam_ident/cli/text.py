"""Numbers and tables as they are printed."""

import math
import os
import shutil
import sys
import textwrap
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import TYPE_CHECKING, TextIO

import typer

from ..schema.fit import in_order

if TYPE_CHECKING:
    from ..core import Param
    from ..diagnosis.nouns import Bin
    from ..fitting import Fit
    from ..fitting.fit import Estimate
    from ..model import Model
    from ..records import Record
    from ..records.doubt import Doubt
    from ..tasks.fit import Checks
    from ..tasks.law_choice import LawChoice

INDENT = "  "
LITTLE = 1.02
"""Error over what repeated strokes differ by, up to which it is hardly more, whatever a test makes of many samples."""
silent: ContextVar[bool] = ContextVar("silent", default=False)
"""Whether nothing is to be printed but errors."""
unfinished: Callable[[], None] | None = None
"""Takes a line of progress away that stands on the terminal."""


def say(*lines: str) -> None:
    """Print lines, unless silent; on a terminal broken between words where they are wider than that."""
    _echo(() if silent.get() else lines, columns())


def say_table(table: str) -> None:
    """Print a table for other programs as it is, unless silent."""
    if not silent.get():
        typer.echo(table, nl=False)


def warn(message: str) -> None:
    """Say on stderr what is doubtful or wrong; on a terminal broken as `say` does."""
    _echo(message.splitlines(), _width(sys.stderr), err=True)


def _echo(lines: Sequence[str], width: int | None, err: bool = False) -> None:
    if unfinished is not None:
        unfinished()
    for line in lines:
        typer.echo(line if width is None or len(line) <= width else _broken(line, width), err=err)


def columns() -> int | None:
    """Width of the terminal in characters, or COLUMNS; None where the output goes elsewhere, for a program to read."""
    return _width(sys.stdout)


def _width(stream: TextIO) -> int | None:
    return shutil.get_terminal_size().columns if stream.isatty() or "COLUMNS" in os.environ else None


def _broken(line: str, width: int) -> str:
    head = line[: len(line) - len(line.lstrip())]
    wrapper = textwrap.TextWrapper(width, head, head + INDENT, break_long_words=False, break_on_hyphens=False)
    return "\n".join(wrapper.wrap(line.strip()))


def _later(name: str) -> Callable[..., str]:
    """A function of `core.digits`, which waits for the first number: `--help` needs none."""

    def told(*given: float | None) -> str:
        from ..core import digits

        return getattr(digits, name)(*given)

    return told


number, newtons, millimetres = _later("number"), _later("newtons"), _later("millimetres")
percent, probability = _later("percent"), _later("probability")


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int] = (0,)) -> list[str]:
    """Aligned columns under their heads; columns in `left` stand left, the others right.

    On a narrow terminal the columns that stand left are broken between words, and what then is too wide comes in
    parts, the first column in front of each.
    """
    if not rows:
        return []
    cells = [list(head), *map(list, rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(head))]
    room = columns()
    if room is not None:
        least = {k: max(len(word) for row in cells for word in ["", *row[k].split()]) for k in left if k > 0}
        while _total(widths) > room and (wide := [k for k in least if widths[k] > least[k]]):
            widths[max(wide, key=lambda k: widths[k])] -= 1
        if _total(widths) > room and len(head) > 2:
            return _in_parts(head, rows, left, widths, room)
    return [line for row in cells for line in _lines(row, widths, left)]


def _total(widths: Sequence[int]) -> int:
    return len(INDENT) + sum(widths) + 2 * (len(widths) - 1)


def _in_parts(
    head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int], widths: list[int], room: int
) -> list[str]:
    count = 2
    while count < len(head) and _total(widths[: count + 1]) <= room:
        count += 1
    if count == len(head):
        return [line for row in (head, *rows) for line in _lines(row, widths, left)]
    rest = [0, *range(count, len(head))]
    parts = []
    for picked in (list(range(count)), rest):
        kept = tuple(i for i, k in enumerate(picked) if k in left)
        parts.append(table([head[k] for k in picked], [[row[k] for k in picked] for row in rows], kept))
    return [*parts[0], "", *parts[1]]


def _lines(row: Sequence[str], widths: Sequence[int], left: Sequence[int]) -> list[str]:
    """A row of a table, in several lines where words of it must be broken."""
    broken = [
        (textwrap.wrap(cell, width) or [""]) if len(cell) > width else [cell]
        for cell, width in zip(row, widths, strict=True)
    ]
    lines = []
    for i in range(max(map(len, broken))):
        parts = [
            (cell[i] if i < len(cell) else "").ljust(width)
            if k in left
            else (cell[i] if i < len(cell) else "").rjust(width)
            for k, (cell, width) in enumerate(zip(broken, widths, strict=True))
        ]
        lines.append((INDENT + "  ".join(parts)).rstrip())
    return lines


def value_of(estimate: "Estimate") -> str:
    """A parameter's value with the digits that its standard error leaves."""
    from ..core.digits import known_to

    return known_to(estimate.value, math.nan if estimate.at_bound else estimate.stderr)


def error_of(estimate: "Estimate") -> str:
    """± the standard error, or in words why there is none that means anything."""
    words = {"flat": "not identified", "dead": "not identified", "at_bound": "at bound", "held": "held"}
    if estimate.verdict.kind in words:
        return words[estimate.verdict.kind]
    return f"± {number(estimate.stderr, 2)}" if math.isfinite(estimate.stderr) else "no error known"


def interval_of(estimate: "Estimate") -> str:
    """The 95 % interval, with an open end where the data do not close it."""
    from ..core.digits import interval

    return interval(estimate.low, estimate.high, estimate.stderr) if math.isfinite(estimate.stderr) else ""


def named(param: "Param") -> str:
    """A parameter by the name it has in every answer, and by its symbol where a formula has another."""
    return f"{param.name} ({param.symbol})" if param.symbol else param.name


def bounds(param: "Param") -> str:
    """The values that a parameter may take."""
    low, high = (f"{end:g}" if math.isfinite(end) else "" for end in (param.lower, param.upper))
    return f"{low} to {high}" if low and high else f"{low} or more" if low else f"{high} or less" if high else "any"


def meanings(params: "Sequence[Param]") -> list[str]:
    """A table of what parameters mean, with their bounds, and where nature ends."""
    rows = [(named(p), p.unit, bounds(p), p.doc) for p in params]
    ends = [(p.name, p.range) for p in params if p.range is not None]
    said = [f"{INDENT}{name}: possible {end.low:g} to {end.high:g}, by {end.source}" for name, end in ends]
    return [*table(("parameter", "unit", "bounds", "meaning"), rows, left=(0, 1, 2, 3)), *said]


def parameters(fit: "Fit", shared: bool | None = None) -> list[str]:
    """A table of every parameter with standard error, interval and unit, and a line for each that is not pinned; of a
    fit to several records those that are `shared`, or those that are not."""
    ordered = [e for e in in_order(fit.estimates) if shared is None or shared == (e.name in fit.shared)]
    rows = [(e.name, value_of(e), error_of(e), interval_of(e), "" if e.unit == "1" else e.unit, e.doc) for e in ordered]
    head = ("parameter", "value", "std. error", "95 % interval", "unit", "meaning")
    notes = [f"{INDENT}{e.name}: {e.verdict.text}" for e in ordered if e.verdict.kind not in ("pinned", "held")]
    if not shared:
        from ..effects import in_words

        own, shares = fit.model.own, fit.shares
        notes += [f"{INDENT}{in_words(name, own)}: {newtons(share)} rms of the force" for name, share in shares.items()]
        free = [in_words(term.effect.name, own) for term in fit.model.terms if term.form.free]
        notes += [f"{INDENT}{name}: the numbers of a free form draw a curve and are no constants" for name in free]
    return table(head, rows, left=(0, 4, 5)) + notes


def quality(fit: "Fit") -> str:
    """The fit's errors in one line; where the length answered, those of the length first."""
    length = fit.length_errors
    if length is not None:
        return (
            f"length: rmse {millimetres(length.rmse)}, largest error {millimetres(length.largest)}, R² "
            f"{number(fit.r2, 6)}, n {fit.n}; the force at the measured length: rmse {newtons(fit.rmse)}"
        )
    return f"rmse {newtons(fit.rmse)}, largest error {newtons(fit.max_error)}, R² {number(fit.r2, 6)}, n {fit.n}"


def equation(model: "Model") -> list[str]:
    """The law's formula, and a line an effect."""
    return str(model).splitlines()


def title(path: str, record: "Record") -> str:
    """One line that says what record this is."""
    levels, pressure = record.levels, record.inputs.pressure
    if record.inputs.pressure_rate is not None:
        span = f"{pressure.min():.4g} to {pressure.max():.4g} MPa"
    elif len(levels) == 1:
        span = f"{levels[0]:g} MPa"
    else:
        span = f"{len(levels)} pressures, {levels[0]:g} to {levels[-1]:g} MPa"
    masked = f" ({record.masked} more are marked as slack)" if record.masked else ""
    name = "" if record.name == path else f" ({record.name})"
    return f"{path}{name}: {len(record)} samples{masked}, {span}"


def banner(doubts: "Sequence[Doubt]") -> list[str]:
    """A line for each doubt, above the verdict."""
    return [str(doubt) for doubt in doubts]


def mean(one: "Bin") -> str:
    """The mean error of a bin with the digits that its standard error leaves."""
    from ..core.digits import known_to

    return known_to(one.mean, one.rms / math.sqrt(one.n))


def verdict(name: str) -> str:
    """A verdict of the contract in words."""
    return name.replace("_", " ")


def chosen(choice: "LawChoice | None") -> list[str]:
    """Which law was taken and why, where none was named."""
    if choice is None:
        return []
    odd = sum(bool(trial.problem) for trial in choice.trials)
    were = "was" if odd == 1 else "were"
    more = f"; {odd} of them {were} left out, which this record does not determine" if odd else ""
    return [f"law: {choice.why} (of {len(choice.trials)} laws compared{more})"]


def branch(name: str) -> str:
    """A branch in words."""
    return "both branches together" if name == "together" else name


def checks(found: "Checks", one: "Fit") -> list[str]:
    """What a fit is held against, a line each; strokes differ in force, or in mm of the length."""
    lines, size = [], newtons if one.lengths is None else millimetres
    if found.repeats is not None:
        memory = f", {number(found.repeats.memory, 2)} samples count as one" if found.repeats.memory > 1.5 else ""
        lines.append(f"{INDENT}{found.repeats.strokes} repeated strokes differ by {size(found.repeats.sigma)}{memory}")
    if found.lack is not None:
        little = found.repeats is not None and one.rmse < LITTLE * found.repeats.sigma
        more = "hardly more than noise" if little else "more than noise; see `pam-ident diagnose`"
        verdict = "nothing but noise is left" if found.lack.adequate else f"the model leaves {more}"
        lines.append(
            f"{INDENT}lack of fit: {verdict} (F {number(found.lack.statistic, 3)}, p {found.lack.p_value:.2g})"
        )
    twins: dict[str, list[str]] = {}
    for twin in found.stand_ins:
        twins.setdefault(twin.calibration, []).append(" and ".join(twin.parameters))
    if twins:
        lines.append(f"{INDENT}faults of the sensors that the parameters take up without trace:")
        lines += [f"{INDENT * 2}{name.replace('_', ' ')}: by {' or '.join(how)}" for name, how in twins.items()]
    return lines
