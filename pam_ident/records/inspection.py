"""What was read of a record, and advice on the rig."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..core import Array
from .doubt import Doubt
from .files import Files, find_files
from .gate import doubts_of
from .kind import HELD_LENGTH, held_lengths, large_turns
from .record import Record


@dataclass(frozen=True)
class Isobar:
    """One nominal pressure: samples, their standard deviation of pressure in MPa, range of contraction and force."""

    pressure_MPa: float
    n: int
    wander_MPa: float
    contraction: tuple[float, float]
    force_N: tuple[float, float]


@dataclass(frozen=True)
class LockedLength:
    """One contraction ratio at which a muscle was locked: samples, range of pressure in MPa and of force."""

    contraction: float
    n: int
    pressure_MPa: tuple[float, float]
    force_N: tuple[float, float]


@dataclass(frozen=True)
class Inspection:
    """A record in numbers. `speeds` are the strokes' speeds in mm/s, `None` fields are not in the record. `kind` is the
    kind of test, `doubts` what looks wrong, `advice` that and what the record cannot show, in plain words.

    `cycles` is the largest number of cycles on one isobar, in a row, or of the pressure at one length; `branches` maps
    a branch to its number of samples.
    """

    record: Record
    files: Files | None
    isobars: tuple[Isobar, ...]
    lengths: tuple[LockedLength, ...]
    branches: dict[str, int]
    strokes: int
    speeds: tuple[float, ...]
    cycles: int | None
    holds: int | None
    hold_samples: int
    duration_s: float | None
    temperature_C: tuple[float, float] | None
    advice: tuple[str, ...]
    kind: str
    doubts: tuple[Doubt, ...]


def inspect_record(record: Record) -> Inspection:
    """Count what a record holds and say what would make it tell more."""
    inputs, speeds, doubts = record.inputs, stroke_speeds(record), doubts_of(record)
    names = {"contraction": 1.0, "extension": -1.0, "without a branch": 0.0}
    counts = {name: int(np.sum(inputs.direction == sign)) for name, sign in names.items()}
    held = None if inputs.moving is None else ~inputs.moving
    noted = {note.code for note in record.notes}
    return Inspection(
        record,
        find_files(record.source) if record.sha256 else None,
        tuple(_isobar(record, level) for level in record.levels),
        _lengths(record) if record.kind == "isometric" else (),
        {name: count for name, count in counts.items() if count},
        len(np.unique(record.stroke[record.stroke > 0])),
        speeds,
        None if inputs.cycle is None else _cycles(record, inputs.cycle),
        None if held is None else int(np.sum(np.diff(np.r_[False, held].astype(int)) == 1)),
        0 if held is None else int(held.sum()),
        None if inputs.time is None else float(inputs.time[-1] - inputs.time[0]),
        None if inputs.temperature is None else (float(inputs.temperature.min()), float(inputs.temperature.max())),
        (*(doubt.text for doubt in doubts if doubt.code not in noted), *_gaps(record, speeds)),
        record.kind,
        doubts,
    )


def stroke_speeds(record: Record) -> tuple[float, ...]:
    """Distinct speeds of the strokes in mm/s, ascending; speeds within a third of each other count as one."""
    pace, moving = record.inputs.stroke_speed, record.inputs.moving
    if pace is None or moving is None or not moving.any():
        return ()
    values = np.sort(np.array([np.median(pace[record.stroke == k]) for k in np.unique(record.stroke[moving])]))
    values = values[values > 1e-9]  # a locked length is rounded
    if not len(values):
        return ()
    groups = np.split(values, np.flatnonzero(values[1:] > 4.0 / 3.0 * values[:-1]) + 1)
    return tuple(float(np.median(group)) for group in groups)


def _cycles(record: Record, cycle: Array) -> int:
    """The most cycles (n,) on one isobar, or in a row where none is held; of a locked muscle the most of the pressure
    at one length: a valve that is opened in steps, and leaks in between, makes none by each."""
    if record.kind == "isometric" and "cycle" not in record.columns:
        held = held_lengths(record.inputs.contraction)
        return max(len(large_turns(record.inputs.pressure[held == length])) // 2 for length in np.unique(held))
    if record.kind in ("isotonic", "dynamic"):
        return len(np.unique(cycle))
    return max(len(np.unique(cycle[record.level == p])) for p in record.levels)


def _isobar(record: Record, level: float) -> Isobar:
    here = record.level == level
    pressure = record.inputs.pressure[here]
    wander = float(pressure.std()) if np.ptp(pressure) > 0.0 else 0.0  # a mean is rounded
    return Isobar(float(level), int(here.sum()), wander, *_ends(here, record.inputs.contraction, record.force))


def _lengths(record: Record) -> tuple[LockedLength, ...]:
    held = held_lengths(record.inputs.contraction)
    rows = [(float(length), held == length) for length in np.unique(held)]
    return tuple(
        LockedLength(length, int(here.sum()), *_ends(here, record.inputs.pressure, record.force))
        for length, here in rows
    )


def _ends(here: Array, *columns: Array) -> list[tuple[float, float]]:
    """The least and the greatest of each column (n,) over some rows, by a mask (n,)."""
    return [(float(x[here].min()), float(x[here].max())) for x in columns]


def _gaps(record: Record, speeds: tuple[float, ...]) -> Iterator[str]:
    """What the record cannot show."""
    inputs = record.inputs
    levels = len(record.levels)
    if levels < 3 and record.kind == "isobaric":
        yield (
            f"{levels} pressure level{'s' if levels > 1 else ''}: what grows with pressure cannot be told from what "
            "does not. Measure at least three, better five."
        )
    if record.kind == "isometric" and np.ptp(inputs.contraction) < HELD_LENGTH:
        yield "one locked length: it shows no law, and no effect is named. Lock the muscle at three lengths or more."
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
            yield "no holds: what friction keeps at rest cannot be seen, creep hardly. Hold some seconds at both ends."
        cycles = 0 if inputs.cycle is None else _cycles(record, inputs.cycle)
        where = {"isobaric": " on each isobar", "isometric": " at each length"}.get(record.kind, "")
        if cycles == 1:
            yield (
                "no repeated cycle: drift and softening over cycles cannot be told from noise, and nothing can be held "
                f"out whole. Run three cycles or more{where}."
            )
        elif cycles == 2:
            yield (
                "two cycles: the noise is known from one repeat alone, and a trend over cycles cannot be told from it. "
                f"Run three cycles or more{where}."
            )
    if record.kind == "isobaric":
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
