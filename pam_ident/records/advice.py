"""Simple checks of a record, each with what to change on the rig."""

from collections.abc import Iterator

import numpy as np

from .plausible import doubt_clock, doubt_units
from .record import Record


def advise(record: Record, speeds: tuple[float, ...]) -> tuple[str, ...]:
    """What the record cannot show and what looks wrong in it, in plain words; empty when nothing is amiss."""
    return (*_doubts(record), *doubt_units(record), *doubt_clock(record), *_gaps(record, speeds))


def _doubts(record: Record) -> Iterator[str]:
    """What looks wrong."""
    contraction = record.inputs.contraction
    if contraction.max() > 0.35:
        yield (
            f"contraction reaches {contraction.max():.3f}: a braided muscle seldom goes beyond 0.35. Check the unit of "
            "the displacement and initial_length_mm of the specimen."
        )
    if contraction.min() < -0.01:
        yield (
            f"contraction goes down to {contraction.min():.3f}: the muscle is stretched beyond its initial length. "
            "Check the zero of the displacement and its sign (contraction is positive)."
        )
    if record.force.min() < -0.05 * abs(record.force.max()):
        yield (
            f"the force goes down to {record.force.min():.4g} N, but a muscle pulls and cannot push. Check the zero "
            "of the load cell and its sign (pull is positive)."
        )
    floor, n = _clipped(record.force)
    if n:
        yield (
            f"{n} samples read exactly {floor:g} N, the lowest force: the reading is clipped or the muscle is slack. "
            "Leave those rows out (a column `slack` of 1 and 0 does it), or pretension the muscle."
        )
    wander = _wander(record)
    if wander is not None:
        level, deviation, low, high = wander
        yield (
            f"the pressure is not isobaric: at {level:g} MPa it wanders between {low:.4g} and {high:.4g} MPa (standard "
            f"deviation {deviation:.2g} MPa). Use a larger reservoir, a closer regulator or slower strokes."
        )


def _gaps(record: Record, speeds: tuple[float, ...]) -> Iterator[str]:
    """What the record cannot show."""
    inputs = record.inputs
    levels = len(record.levels)
    if levels < 3:
        yield (
            f"{levels} pressure level{'s' if levels > 1 else ''}: what grows with pressure cannot be told from what "
            "does not. Measure at least three, better five."
        )
    if inputs.time is None:
        yield "no time column (time_s): damping, lag, creep, drift and holds cannot be seen. Log the time."
        if not inputs.has("branch"):
            yield "no branches: friction cannot be seen. Log time, or a branch column (contraction or extension)."
    else:
        if len(speeds) < 2:
            yield (
                f"{'one stroke speed' if speeds else 'no stroke'}: damping and lag cannot be told from friction. "
                "Measure at two speeds or more, a factor of three apart."
            )
        if inputs.moving is not None and inputs.moving.all():
            yield "no holds: creep and what friction keeps at rest cannot be seen. Hold some seconds at both ends."
        cycles = 0 if inputs.cycle is None else len(np.unique(inputs.cycle))
        if cycles == 1:
            yield (
                "no repeated cycle: drift and softening over cycles cannot be told from noise, and nothing can be held "
                "out whole. Run three cycles or more on each isobar."
            )
        elif cycles == 2:
            yield (
                "two cycles: the noise is known from one repeat alone, and a trend over cycles cannot be told from it. "
                "Run three cycles or more on each isobar."
            )
    yield from _lone_branches(record)
    if inputs.temperature is None:
        yield "no temperature (temperature_C): softening by warming cannot be told from drift. Log it at the bladder."


def _lone_branches(record: Record) -> Iterator[str]:
    """Isobars with one branch alone, where branches are known."""
    names = {1.0: "contraction", -1.0: "extension"}
    lone: dict[float, list[str]] = {}
    for level in record.levels:
        signs = set(np.unique(record.inputs.direction[record.level == level])) & set(names)
        if len(signs) == 1:
            lone.setdefault(signs.pop(), []).append(f"{level:g}")
    for sign, levels in lone.items():
        many = f"{len(levels)} isobars" if len(levels) > 5 else f"{' and '.join(levels)} MPa"
        yield (
            f"the {names[-sign]} branch is missing at {many}: friction cannot be seen there. Measure both ways on each "
            "isobar."
        )


def _clipped(force: np.ndarray) -> tuple[float, int]:
    """The lowest force and how many samples read exactly that, 0 where they are few or the force is constant."""
    floor = float(force.min())
    n = int(np.sum(force == floor))
    return floor, n if n >= max(3, len(force) // 100) and n < len(force) else 0


def _wander(record: Record) -> tuple[float, float, float, float] | None:
    """Level, standard deviation and range of pressure on the worst isobar, None while all stay within 2 % (2 kPa)."""
    worst: tuple[float, float, float, float] | None = None
    ratio = 1.0
    for level in record.levels:
        pressure = record.inputs.pressure[record.level == level]
        allowed = max(0.02 * abs(float(level)), 0.002)
        deviation = float(np.sqrt(np.mean((pressure - level) ** 2)))
        if deviation / allowed > ratio:
            ratio = deviation / allowed
            worst = (float(level), deviation, float(pressure.min()), float(pressure.max()))
    return worst
