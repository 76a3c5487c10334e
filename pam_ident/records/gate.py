"""Everything that is doubtful of a record, whatever is asked of it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .doubt import GRAVE, Doubt
from .plausible import doubt_units
from .readings import doubt_clock, doubt_force, doubt_temperature, spikes
from .record import Record


def doubts_of(record: Record) -> tuple[Doubt, ...]:
    """What looks wrong in a record, `column` by its header, the grave first, and behind it what was left out or assumed
    while it was read; empty when there is nothing to say.

    Example:
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.records.gate import doubts_of
        >>> record = read_record(dataset_record("leg_muscle"))
        >>> print([(doubt.code, doubt.grave) for doubt in doubts_of(record)])
        [('force_sign', False)]
    """
    found = [_with_header(record, doubt) for doubt in _all_of(record.as_measured)]
    found += [Doubt(note.code, note.text, note.column, note.code in GRAVE) for note in record.notes]
    return tuple(sorted(found, key=lambda doubt: not doubt.grave))


def _all_of(record: Record) -> Iterator[Doubt]:
    with np.errstate(all="ignore"):
        wild = spikes(record)
        impossible = [doubt for doubt in doubt_force(record, wild) if doubt.code == "impossible_value"]
        yield from impossible
        if impossible and not wild.any():
            return
        rest = record.take(np.flatnonzero(~wild)) if wild.any() else record
        yield from (doubt for doubt in doubt_force(rest, wild[~wild]) if doubt.code != "impossible_value")
        yield from doubt_units(rest)
        yield from _doubt_wander(record)
        yield from doubt_clock(rest)
        yield from doubt_temperature(rest)


def _with_header(record: Record, doubt: Doubt) -> Doubt:
    if doubt.column is None:
        return doubt
    names = ("displacement", "contraction", "length") if doubt.column == "displacement" else (doubt.column,)
    header = next((record.columns[name] for name in names if name in record.columns), doubt.column)
    return replace(doubt, column=header)


def _doubt_wander(record: Record) -> Iterator[Doubt]:
    """The worst isobar whose pressure does not stay within 2 % (2 kPa)."""
    if record.kind != "isobaric":
        return
    worst, ratio = None, 1.0
    for level in record.levels:
        pressure = record.inputs.pressure[record.level == level]
        deviation = float(np.sqrt(np.mean((pressure - level) ** 2)))
        allowed = max(0.02 * abs(float(level)), 0.002)
        if deviation / allowed > ratio:
            ratio, worst = deviation / allowed, (level, deviation, pressure.min(), pressure.max())
    if worst is not None:
        level, deviation, low, high = worst
        text = (
            f"the pressure is not isobaric: at {level:g} MPa it wanders between {low:.4g} and {high:.4g} MPa (standard "
            f"deviation {deviation:.2g} MPa). Use a larger reservoir, a closer regulator or slower strokes."
        )
        yield Doubt("pressure_wanders", text, "pressure")
