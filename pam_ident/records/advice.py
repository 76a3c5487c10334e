"""Simple checks of a record, each with what to change on the rig."""

from collections.abc import Iterator

import numpy as np

from .doubt import Doubt
from .record import Record


def advise(record: Record, doubts: tuple[Doubt, ...], speeds: tuple[float, ...]) -> tuple[str, ...]:
    """What looks wrong in the record and what it cannot show, in plain words; empty when nothing is amiss."""
    noted = {note.code for note in record.notes}
    return (*(doubt.text for doubt in doubts if doubt.code not in noted), *_gaps(record, speeds))


def _gaps(record: Record, speeds: tuple[float, ...]) -> Iterator[str]:
    """What the record cannot show."""
    inputs = record.inputs
    levels = len(record.levels)
    if levels < 3 and record.kind == "isobaric":
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
