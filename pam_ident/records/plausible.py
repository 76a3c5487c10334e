"""Whether a record's units, signs and zeros can be right: beside the ideal braid, and beside itself."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .record import Record

ATMOSPHERE_MPA = 0.101325
SLIPS = (
    (4.2, "pound-force and N (4.4) or radius and diameter (4)"),
    (6.9, "psi and kPa (6.9)"),
    (10.0, "bar and MPa (10) or kgf and N (9.8)"),
    (14.5, "psi and bar (14.5)"),
    (100.0, "kPa and bar, or a radius in cm and mm (100)"),
    (145.0, "psi and MPa (145)"),
    (1000.0, "kPa and MPa, or kN and N (1000)"),
)
"""By how much the force is wrong beside the pressure if two units are taken for each other."""
LIKELY = (0.4, 2.5)
"""Slope of the force over the pressure beside the ideal braid's. Measured muscles (Festo DMSP-20 of two laboratories, a
hand-made one of a third) and the data sets that come along lie between 0.76 and 1.31."""
LATEST_MPA = 0.12
"""Gauge pressure at which a muscle near its full length begins to pull, at the latest; the same ones lie between 0.04
and 0.09 MPa."""
BEND = (0.06, 1.0)
"""Contraction at which a straight line through an isobar meets zero force; an ideal braid's free one is 0.36."""


class Pull(NamedTuple):
    """Force over pressure near the full length: slope beside the ideal braid's, pressure in MPa at which it begins."""

    ratio: float
    begins_MPa: float


def doubt_units(record: Record) -> Iterator[str]:
    """What looks like a wrong unit, sign or zero, in plain words."""
    pressure = record.inputs.pressure
    if pressure.min() < -0.02:
        yield (
            f"the pressure goes down to {pressure.min():.4g} MPa: below the air's. Check the zero of the sensor, and "
            "whether the air's pressure was taken off twice."
        )
    pull = near_full_length(record)
    if pull is not None and pull.ratio > 0.0:
        yield from _doubt_pull(pull, float(pressure.min()))
    yield from _doubt_contraction(record)


def near_full_length(record: Record) -> Pull | None:
    """The pull in the first tenth of the stroke, None where less than two pressures a factor of 1.5 apart are there."""
    pressure, contraction = record.inputs.pressure, record.inputs.contraction
    near = contraction <= contraction.min() + 0.1 * np.ptp(contraction)
    near &= pressure > 0.3 * pressure.max()
    p, force = pressure[near], record.force[near]
    if near.sum() < 3 or p.max() < 1.5 * p.min():
        return None
    ideal = record.specimen.ideal_force(p, contraction[near])
    slope, offset = np.polyfit(p - p.mean(), force, 1)
    expected = np.polyfit(p - p.mean(), ideal, 1)[0]
    if slope == 0.0 or expected <= 0.0:
        return None
    return Pull(float(slope / expected), float(p.mean() - offset / slope))


def _doubt_pull(pull: Pull, lowest_MPa: float) -> Iterator[str]:
    low, high = LIKELY
    if not low < pull.ratio < high:
        size = max(pull.ratio, 1.0 / pull.ratio)
        known = [words for factor, words in SLIPS if 1.0 / 1.5 < size / factor < 1.5]
        slip = f"Slips of about that size: {'; '.join(known)}." if known else "Check units and radius."
        yield (
            f"the force grows with the pressure {pull.ratio:.3g} times as an ideal braid's would: a unit of force, "
            f"pressure or radius is wrong, or the muscle is of another kind. {slip}"
        )
    elif pull.begins_MPa > LATEST_MPA and lowest_MPa > 0.9 * ATMOSPHERE_MPA:
        yield (
            f"near its full length the muscle begins to pull at {pull.begins_MPa:.3f} MPa, and no pressure is below "
            f"the air's: the pressure may be absolute. If so, take {ATMOSPHERE_MPA:.4f} MPa off "
            "(offset in a columns.toml)."
        )


def _doubt_contraction(record: Record) -> Iterator[str]:
    """Force must fall along an isobar, and end near the braid's free contraction."""
    level = record.levels[-1]
    here = record.level == level
    e, force = record.inputs.contraction[here], record.force[here]
    if len(e) < 5 or np.ptp(e) < 1e-6 or np.ptp(force) < 1e-9:
        return
    likeness = float(np.corrcoef(e, force)[0, 1])
    if likeness > 0.5:
        yield (
            f"at {level:g} MPa the force rises with the contraction: a muscle pulls less the shorter it is. Check the "
            "sign of the displacement (contraction is positive) or of the force."
        )
    elif likeness < -0.7:
        slope, offset = np.polyfit(e, force, 1)
        end = float(-offset / slope)
        if not BEND[0] < end < BEND[1] and force.mean() > 0.0:
            yield (
                f"at {level:g} MPa the force falls as if it ended at a contraction of {end:.3g}, where a braided "
                "muscle ends at 0.15 to 0.4. Check the unit of the displacement and initial_length_mm of the specimen."
            )


def doubt_clock(record: Record) -> Iterator[str]:
    """Jumps of the clock within an isobar, and a load cell that has drifted from one tare to the next."""
    time, segment = record.inputs.time, record.inputs.segment
    if time is None or segment is None:
        return
    steps = np.diff(time)[(np.diff(segment) != 0) & (np.diff(record.level) == 0.0)]
    if len(steps):
        yield (
            f"the time jumps {len(steps)} times within an isobar, by up to {steps.max():.4g} s: samples are lost or "
            "the run was stopped. Log without a break, or give each run a file of its own."
        )
    drift = _tare_drift(record)
    if drift is not None:
        yield (
            f"between the first and the last tare (no pressure) the force drifts by {drift:.3g} N. Tare the load cell "
            "before each isobar, let it warm up, and keep the tares in the record."
        )


def _tare_drift(record: Record) -> float | None:
    """Change of the mean force without pressure from the first spell to the last, None where it is within the noise,
    or half a per cent of the largest force, or where there are no two such spells at one length."""
    rows = np.flatnonzero(np.abs(record.inputs.pressure) < 0.01)
    spells = [spell for spell in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if len(spell) >= 3]
    if len(spells) < 2:
        return None
    first, last = spells[0], spells[-1]
    contraction, force = record.inputs.contraction, record.force
    if abs(contraction[first].mean() - contraction[last].mean()) > 0.005:
        return None
    drift = float(force[last].mean() - force[first].mean())
    noise = float(np.hypot(force[first].std() / len(first) ** 0.5, force[last].std() / len(last) ** 0.5))
    return drift if abs(drift) > max(4.0 * noise, 0.005 * np.abs(force).max()) else None
