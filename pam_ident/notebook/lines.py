"""Results in a line or two of text."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..core.digits import millimetres
from ..core.prose import capital
from ..diagnosis.sentence import not_told_apart
from ..effects import named
from ..report.words import newtons

if TYPE_CHECKING:
    from ..core import Specimen
    from ..diagnosis.nouns import Ladder
    from ..fitting import Fit
    from ..leg.track import Track
    from ..records import Record


def line(result: Any) -> str:
    """A result as text."""
    return LINES[kind_of(result)](result)


def kind_of(result: Any) -> str:
    """The name of the class that is shown: the result's own, or the nearest above it that is."""
    return next(one.__name__ for one in type(result).__mro__ if one.__name__ in LINES)


def _specimen(one: "Specimen") -> str:
    return f"Specimen {one.name}: {one.geometry}"


def _record(one: "Record") -> str:
    levels = ", ".join(f"{p:g}" for p in one.levels[:12]) + (", …" if len(one.levels) > 12 else "")
    return f"Record {one.name}: {len(one)} samples at {levels} MPa"


def fit(one: "Fit") -> str:
    """What was fitted to what, and how well."""
    length = one.length_errors
    off = f"{newtons(one.rmse)} rms, {newtons(one.max_error)} at most"
    if length:
        off = f"length {millimetres(length.rmse)} rms, {millimetres(length.largest)} at most"
    quality = f"{off}, R² {one.r2:.6g}, {int(one.rows.sum())} samples"
    return "; ".join([f"{capital(one.model.words)} fitted to {one.record.name}: {quality}", *one.problems])


def ladder(one: "Ladder") -> str:
    """Where it began and where it ended."""
    first, last = one.rungs[0].fit, one.rungs[-1]
    added = ", ".join(named(label, last.fit.model.own) for label in last.effects) or "nothing"
    found = (
        f"{capital(first.model.law.title)}: {newtons(first.rmse)} rms; with {added}: {newtons(last.fit.rmse)} rms; "
        f"noise {newtons(one.noise_floor)}"
    )
    return ". ".join([found, *not_told_apart(one.groups, last.fit.model.own)])


def track(one: "Track") -> str:
    """Tracking errors of plain PID and of the last rung."""
    rungs = f", with the last model ahead {one.rungs[-1].tracking.rms_deg:.3g}° rms" if one.rungs else ""
    return f"Knee tracking: PID {one.pid.rms_deg:.3g}° rms{rungs}"


LINES: dict[str, Callable[[Any], str]] = {
    "Specimen": _specimen,
    "Record": _record,
    "Model": str,
    "Fit": fit,
    "Comparison": lambda one: one.sentence,
    "Diagnosis": lambda one: one.sentence,
    "Ladder": ladder,
    "Track": track,
}
"""By the name of the result's type."""
