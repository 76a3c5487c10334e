"""Which kind of test a record is: what was driven, what was held, what answered."""

import numpy as np

from ..core import Array, DataError, Specimen
from .turning import pivots

KINDS = {
    "isobaric": "the pressure is held and the length driven",
    "isometric": "the length is held and the pressure driven",
    "isotonic": "the load is held, the pressure driven, and the length answers",
    "dynamic": "pressure and length both change",
}
BLOCKS = ("length", "pressure", "run", "cycle", "muscle")
"""What of a record may be held out whole."""
LOOKED_AT = 20_000
"""Rows, evenly taken, that a long record is judged by."""
HELD_LENGTH = 0.004
"""Contraction within which a clamped muscle stays."""
HELD_FORCE, LIGHT = 0.1, 0.02
"""Standard deviation of a held load beside its mean, or beside the blocked force where there is hardly a load."""
HELD_PRESSURE = 0.08
"""Standard deviation of a held pressure on an isobar beside its level; regulators stay within 0.05."""
VARIED = 0.15
"""Range of a driven pressure beside its largest."""
WAY = 0.25
"""Way of a length or a load that is held, and held elsewhere, beside the way of the pressure, both in their ranges; and
of a pressure beside that of a length that does not answer it, but is driven."""

SELDOM = 0.02
"""Share of the rows in which a muscle that is clamped at some lengths is moved to another."""


def check_kind(kind: object, where: str) -> str:
    """The kind as it was said, empty for None. Raises DataError for another word."""
    if kind is None:
        return ""
    if not isinstance(kind, str) or kind not in KINDS:
        raise DataError(f"{where}: kind = {kind!r}; expected one of {', '.join(KINDS)}")
    return kind


def find_kind(specimen: Specimen, pressure: Array, contraction: Array, force: Array, level: Array, timed: bool) -> str:
    """The kind of columns (n,) in MPa, 1, N and MPa, `level` the nominal pressures, as the data show it. A static table
    is isobaric unless one of length and force never changes."""
    step = max(1, len(force) // LOOKED_AT)
    with np.errstate(all="ignore"):
        return _found(specimen, pressure[::step], contraction[::step], force[::step], level[::step], timed)


def _found(specimen: Specimen, p: Array, e: Array, force: Array, level: Array, timed: bool) -> str:
    driven = np.ptp(p) > VARIED * np.abs(p).max()
    if driven and np.ptp(e) < HELD_LENGTH:
        return "isometric"
    blocked = abs(float(specimen.ideal_force(np.abs(p).max(), np.zeros(()))))
    length_way, pressure_way = (_way(e), _way(p)) if driven and timed else (0.0, 0.0)
    answers = not timed or WAY * length_way < pressure_way
    if driven and answers and force.std() < max(HELD_FORCE * abs(force.mean()), LIGHT * blocked):
        return "isotonic"
    if not timed:
        return "isobaric"
    if driven and _clamped(e):
        return "isometric"
    if driven and length_way < WAY * pressure_way:
        return "isometric"
    if driven and answers and _way(force) < WAY * pressure_way:
        return "isotonic"
    switched = driven and np.count_nonzero(np.diff(level)) >= len(large_turns(e))
    off = (p - level) / np.maximum(np.abs(level), 0.05)
    return "dynamic" if switched or np.sqrt(np.mean(off**2)) > HELD_PRESSURE else "isobaric"


def _clamped(contraction: Array) -> bool:
    """Whether a muscle is moved from one length to another, (n,), seldom and at once, and stays within HELD_LENGTH."""
    if np.count_nonzero(np.abs(np.diff(contraction)) > HELD_LENGTH) > SELDOM * len(contraction):
        return False
    return all(np.ptp(one) < HELD_LENGTH for one in _at_each_length(contraction)[0])


def held_lengths(contraction: Array) -> Array:
    """The contraction ratio at which a muscle is locked at each sample, (n,)."""
    lengths, group = _at_each_length(contraction)
    return np.array([np.median(one) for one in lengths])[group]


def _at_each_length(contraction: Array) -> tuple[list[Array], Array]:
    """Contractions (n,) at each length that is more than HELD_LENGTH from the next, and its number by sample, (n,)."""
    values, place = np.unique(contraction, return_inverse=True)
    group = np.r_[0, np.cumsum(np.diff(values) > HELD_LENGTH)][place]
    return [contraction[group == g] for g in range(group.max() + 1)], group


def large_turns(values: Array) -> list[int]:
    """Where a track (n,) in any unit turns, its ends among them; turns of less than a tenth of its range left out."""
    return pivots(values, 0.1 * float(np.ptp(values)))


def _way(values: Array) -> float:
    """Way from turn to turn in multiples of the range (n,)."""
    span, turns = float(np.ptp(values)), large_turns(values)
    return float(np.sum(np.abs(np.diff(values[turns])))) / span if span > 0.0 else 0.0
