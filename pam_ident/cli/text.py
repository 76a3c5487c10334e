"""Numbers and tables as they are printed."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from ..fitting import Fit
    from ..fitting.fit import Estimate
    from ..model import Model
    from ..records import Record

INDENT = "  "


def say(*lines: str) -> None:
    """Print lines."""
    for line in lines:
        typer.echo(line)


def number(value: float | None, digits: int = 4) -> str:
    """Significant digits, without a power of ten for everyday sizes; a dash for no value."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    return f"{value:.{max(digits - 1 - size, 0)}f}" if -4 <= size <= 6 else f"{value:.{digits - 1}e}"


def newtons(value: float | None) -> str:
    """A force in N with three digits, and as zero what is below a millionth of a newton."""
    if value is not None and abs(value) < 1e-6:
        return "0 N"
    return f"{number(value, 3)} N"


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int] = (0,)) -> list[str]:
    """Aligned columns under their heads; columns in `left` stand left, the others right."""
    if not rows:
        return []
    cells = [list(head), *map(list, rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(head))]
    return [
        INDENT
        + "  ".join(
            cell.ljust(width) if k in left else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in cells
    ]


def value_of(estimate: "Estimate") -> str:
    """A parameter's value with the digits that its standard error leaves, four at least and eight at most."""
    value, error = estimate.value, estimate.stderr
    digits = 6
    if estimate.identified and not estimate.at_bound and error > 0 and value != 0 and math.isfinite(error):
        digits = min(max(math.floor(math.log10(abs(value))) - math.floor(math.log10(error)) + 2, 4), 8)
    return number(value, digits)


def error_of(estimate: "Estimate") -> str:
    """± the standard error, or in words why there is none that means anything."""
    if not estimate.identified:
        return "not identified, at bound" if estimate.at_bound else "not identified"
    if estimate.at_bound:
        return "at bound"
    return f"± {number(estimate.stderr, 2)}" if math.isfinite(estimate.stderr) else "no error known"


def parameters(fit: "Fit") -> list[str]:
    """A table of every parameter with standard error and unit."""
    rows = [(e.name, value_of(e), error_of(e), "" if e.unit == "1" else e.unit, e.doc) for e in in_order(fit.estimates)]
    return table(("parameter", "value", "std. error", "unit", "meaning"), rows, left=(0, 3, 4))


def in_order(estimates: "Sequence[Estimate]") -> "list[Estimate]":
    """The law's parameters by name, then the effects' as they come."""
    return sorted(estimates, key=lambda e: (1, "") if "." in e.name else (0, e.name))


def quality(fit: "Fit") -> str:
    """The fit's errors in one line."""
    return (
        f"rmse {newtons(fit.rmse)}, largest error {newtons(fit.max_error)}, R² {number(fit.r2, 6)}, "
        f"n {int(fit.rows.sum())}"
    )


def equation(model: "Model") -> list[str]:
    """The law's formula, and a line an effect."""
    lines = [f"{model.law.name}: {model.law.formula}"]
    return lines + [f"+ {term.label}: {term.form.formula}" for term in model.terms]


def title(path: str, record: "Record") -> str:
    """One line that says what record this is."""
    levels = record.levels
    span = f"{levels[0]:g} MPa" if len(levels) == 1 else f"{len(levels)} pressures, {levels[0]:g} to {levels[-1]:g} MPa"
    masked = f" ({record.masked} more masked)" if record.masked else ""
    return f"{path} ({record.name}): {len(record)} samples{masked}, {span}"


def percent(share: float | None) -> str:
    """A share in per cent."""
    return "-" if share is None or not math.isfinite(share) else f"{max(100 * share, 0.0):.0f} %"
