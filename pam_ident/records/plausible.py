"""Whether a record's units, signs and zeros can be right: beside the ideal braid, and beside itself."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..core import Array
from ..core.units import ATMOSPHERE_MPA
from .doubt import Doubt
from .record import Record

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
LIKELY, MEASURED = (0.4, 2.5), (0.7, 1.4)
"""Slope of the force over the pressure beside the ideal braid's that a unit can be right with, and that of measured
muscles: Festo DMSP-20 of two laboratories, a hand-made one of a third, and the bundled data sets, 0.71 to 1.35."""
ALONE = (0.25, 2.5)
"""The force itself beside the ideal braid's, where only one pressure was measured."""
ENOUGH_MPA = 0.2
"""Pressure below which a stiff bladder takes so much of the force that this says nothing of its unit."""
LATEST_MPA, TOO_LATE_MPA = 0.12, 0.135
"""Gauge pressure at which a muscle near its full length begins to pull, at the latest, and where it cannot be that any
more; the same ones lie between 0 and 0.09 MPa."""
TOO_EARLY_MPA = -0.01
"""Gauge pressure below which no muscle begins to pull, where the air's pressure was taken off readings named absolute:
had they been gauge pressure, an ideal braid would begin at -0.1, a measured muscle at -0.02."""
LEAST_MPA = 1e-12
"""Pressure below which arithmetic says nothing any more."""
AT_REST = 0.05
"""Contraction up to which a muscle is near its full length: beyond, its bladder may take as much."""
NEVER_LONG = 0.1
"""Contraction above which a muscle that is driven all the time may rather have another length, or another zero."""
AT_THE_AIRS_MPA = 0.03
"""How near to the air's pressure that is, for pressures that may count from vacuum, and twice by how much it differs
at another length."""
BEND = (0.06, 1.0)
"""Contraction at which a straight line through an isobar meets zero force; an ideal braid's free one is 0.36."""
HALF = (0.1, 0.85)
"""Contraction, from the shortest on an isobar, at which half of its force is gone, beside the ideal braid's free one;
the same muscles lie between 0.18 and 0.43."""
BEYOND = 1.35
"""Largest contraction beside the ideal braid's free one that a unit can be right with; the same lie below 0.78."""
STRETCHED = -0.15
"""Contraction below which the braid would be stretched beyond its own lock at usual angles."""
FAINT_MPA, BURST_MPA = 1e-4, 2.0
"""Largest pressure of which a muscle feels nothing, and one that it does not bear (Festo's bear 0.8 MPa)."""
LIFT, LIFTING, ENDS, LEAST_LIFT = (0.3, 3.0), 0.3, (0.01, 0.99), 0.02
"""Way of the contraction under held loads beside an ideal braid's that a unit can be right with, from this share of the
largest pressure on, between these quantiles, where the ideal one's is so long. Four measured runs lie between 0.61 and
1.23."""
FALLS, RISES = -0.5, 0.5
"""Correlation of force and contraction along an isobar from which it is said to fall or rise."""
LONGEST_MM = 1e4
"""Length of a muscle beyond reason: the longest that are sold have 9 m."""


class Pull(NamedTuple):
    """Force over pressure near the full length, slope and level beside the ideal braid's (slope None where only one
    pressure was measured), and the pressure in MPa at which it begins."""

    slope: float | None
    level: float
    begins_MPa: float


def doubt_units(record: Record) -> Iterator[Doubt]:
    """What looks like a wrong unit, sign or zero."""
    pressure, muscle = record.inputs.pressure, record.specimen
    if not 2.0 * muscle.initial_radius_mm < muscle.initial_length_mm < LONGEST_MM:
        text = (
            f"a muscle {muscle.initial_length_mm:g} mm long and {2.0 * muscle.initial_radius_mm:g} mm wide. Check the "
            "unit of initial_length_mm and initial_radius_mm of the specimen, which are in mm."
        )
        yield Doubt("specimen", text, grave=True)
    if pressure.min() < -0.02:
        text = (
            f"the pressure goes down to {pressure.min():.4g} MPa: below the air's. Check the zero of the sensor, and "
            "whether the air's pressure was taken off twice."
        )
        yield Doubt("pressure_sign", text, "pressure", bool(pressure.min() < -ATMOSPHERE_MPA or pressure.mean() < 0.0))
    likeness = _likeness(record)
    pull = pull_at(record)
    if pull is not None and likeness is not None and likeness < FALLS:
        yield from _doubt_pull(pull, record)
    yield from _doubt_range(record)
    yield from _doubt_isobar(record, likeness)


def pull_at(record: Record, begin: float = 0.0) -> Pull | None:
    """The pull in the tenth of the stroke from `begin` on, at more than 0.3 of the largest pressure; None where it
    means nothing: fewer than three samples, or beyond the ideal braid's free contraction."""
    pressure, contraction = record.inputs.pressure, record.inputs.contraction
    along = (contraction - contraction.min()) / max(float(np.ptp(contraction)), 1e-12)
    near = (along >= begin) & (along <= begin + 0.1) & (pressure > 0.3 * pressure.max())
    p, force = pressure[near], record.force[near]
    if near.sum() < 3 or p.max() < LEAST_MPA:
        return None
    ideal = record.specimen.ideal_force(p, contraction[near])
    high = p > 0.9 * p.max()
    if ideal[high].mean() <= 0.0:
        return None
    level = float(force[high].mean() / ideal[high].mean())
    if p.max() < 1.5 * p.min():
        return Pull(None, level, np.nan)
    # Where pressure and length are driven together, a friction would tilt the line. On one branch it is the offset's.
    direction = record.inputs.direction[near]
    columns = np.column_stack([p - p.mean(), np.ones_like(p), direction * (np.ptp(direction) > 0.0)])
    slope, offset, _ = np.linalg.lstsq(columns, force)[0]
    expected = np.polyfit(p - p.mean(), ideal, 1)[0]
    if slope == 0.0 or expected <= 0.0:
        return None
    return Pull(float(slope / expected), level, float(p.mean() - offset / slope))


def _doubt_pull(pull: Pull, record: Record) -> Iterator[Doubt]:
    pressure = record.inputs.pressure
    if pull.slope is None:
        if pressure.max() > ENOUGH_MPA and not ALONE[0] < pull.level < ALONE[1]:
            yield _scale(f"the force is {pull.level:.3g} times an ideal braid's", pull.level, True)
        return
    if pull.slope > 0.0 and not LIKELY[0] < pull.slope < LIKELY[1]:
        # A wrong unit changes slope and level alike; a soft fixture or a stiff bladder does not.
        grave = pull.level < LIKELY[0] if pull.slope < 1.0 else pull.level > LIKELY[1]
        what = f"the force grows with the pressure {pull.slope:.3g} times as an ideal braid's would"
        least = record.inputs.contraction.min()
        if least > NEVER_LONG:
            what = f"no contraction is below {least:.3g} (initial_length_mm or a zero may be wrong), and {what}"
        yield _scale(what, pull.slope, grave)
    elif pull.slope < 0.0:
        what = "near its full length the force falls as the pressure rises"
        yield Doubt("scale", f"{what}: a run may be in another unit, or a sign is wrong.", None, False)
    elif pull.begins_MPa < TOO_EARLY_MPA and any(note.code == "absolute_pressure" for note in record.notes):
        text = (
            "the air's pressure was taken off, and near its full length the muscle then pulls from "
            f"{pull.begins_MPa:.3f} MPa on: the readings may be gauge pressure after all. If so, name their unit in a "
            "columns.toml without _abs, such as pressure_kPa."
        )
        yield Doubt("pressure_absolute", text, "pressure", True)
    elif (
        pressure.min() > 0.9 * ATMOSPHERE_MPA
        and record.inputs.contraction.min() < AT_REST
        and (pull.begins_MPa > LATEST_MPA or _from_vacuum(record, pull))
    ):
        text = (
            f"near its full length the muscle begins to pull at {pull.begins_MPa:.3f} MPa, and no pressure is below "
            f"the air's: the pressure may be absolute. If so, take {ATMOSPHERE_MPA:.4f} MPa off "
            "(offset in a columns.toml)."
        )
        yield Doubt("pressure_absolute", text, "pressure", pull.begins_MPa > TOO_LATE_MPA or _from_vacuum(record, pull))


def _from_vacuum(record: Record, pull: Pull) -> bool:
    """Whether the muscle begins to pull at the air's pressure, and does so at another length, too, and alike: what a
    bladder takes grows with the contraction."""
    shorter = pull_at(record, 0.4)
    if shorter is None:
        return False
    begins, there = pull.begins_MPa, shorter.begins_MPa
    near = all(abs(one - ATMOSPHERE_MPA) < AT_THE_AIRS_MPA for one in (begins, there))
    return near and abs(there - begins) < 0.5 * AT_THE_AIRS_MPA


def _scale(what: str, ratio: float, grave: bool) -> Doubt:
    put_right = ((ratio / factor if ratio > 1.0 else ratio * factor, words) for factor, words in SLIPS)
    known = [words for slope, words in put_right if MEASURED[0] < slope < MEASURED[1]]
    slip = f"Slips of about that size: {'; '.join(known)}." if known else "Check units and radius."
    kind = "a unit of force, pressure or radius is wrong, or the muscle is of another kind"
    return Doubt("scale", f"{what}: {kind}. {slip}", None, grave)


def _doubt_range(record: Record) -> Iterator[Doubt]:
    """Contraction and pressure that geometry and bladder permit."""
    contraction, pressure = record.inputs.contraction, record.inputs.pressure
    most = max(BEYOND * _free(record), 0.4)
    if contraction.max() > 0.35:
        text = (
            f"contraction reaches {contraction.max():.3f}: a braided muscle seldom goes beyond 0.35. Check the unit of "
            "the displacement and initial_length_mm of the specimen."
        )
        yield Doubt("displacement_scale", text, "displacement", bool(contraction.max() > most))
    if record.kind == "isobaric" and contraction.min() > NEVER_LONG:
        text = (
            f"no contraction is below {contraction.min():.3g}: the muscle never comes near its full length. Check the "
            f"zero of the displacement and initial_length_mm of the specimen ({record.specimen.initial_length_mm:g})."
        )
        yield Doubt("displacement_scale", text, "displacement", False)
    if contraction.min() < -0.01:
        turned = contraction.min() < STRETCHED or -contraction.min() > max(contraction.max(), 0.06)
        text = (
            f"contraction goes down to {contraction.min():.3f}: the muscle is stretched beyond its initial length. "
            "Check the zero of the displacement and its sign (contraction is positive)."
        )
        yield Doubt("displacement_sign", text, "displacement", bool(turned))
    wrong = ""
    if 0.0 < pressure.max() < FAINT_MPA:
        wrong = f"{1e6 * pressure.max():.3g} Pa, of which a muscle feels nothing"
    elif pressure.max() > BURST_MPA:
        wrong = f"{pressure.max():.4g} MPa, which a muscle on a rig does not bear"
    if wrong:
        yield Doubt("scale", f"the pressure reaches {wrong}. Check its unit.", "pressure", True)


def _free(record: Record) -> float:
    """Contraction at which the ideal braid pulls no more."""
    return 1.0 - (record.specimen.b / record.specimen.a) ** 0.5


def _highest(record: Record) -> Array:
    """Mask (n,) of the highest pressures; not of the highest isobar, which in a wrong unit may be all there is."""
    return record.inputs.pressure >= 0.9 * record.inputs.pressure.max()


def _likeness(record: Record) -> float | None:
    """Correlation of force and contraction at the highest pressures, −1 where all is at one length; None where nothing
    can be said."""
    here = _highest(record)
    e, force = record.inputs.contraction[here], record.force[here]
    if np.ptp(record.inputs.contraction) < 1e-3:
        return -1.0
    if len(e) < 5 or np.ptp(e) < 1e-6 or np.ptp(force) < 1e-9:
        return None
    return float(np.corrcoef(e, force)[0, 1])


def _doubt_isobar(record: Record, likeness: float | None) -> Iterator[Doubt]:
    """Force must fall along an isobar, and end near the braid's free contraction."""
    here = _highest(record)
    e, force = record.inputs.contraction[here], record.force[here]
    if likeness is None or not len(e) or np.ptp(e) < 1e-6:
        return
    if record.kind == "isotonic":  # of a few weights, whose lengths answer the pressure, no curve is seen
        yield from _doubt_lift(record)
        return
    level = float(np.median(record.level[here]))
    if likeness > RISES:
        text = (
            f"at {level:g} MPa the force rises with the contraction: a muscle pulls less the shorter it is. Check the "
            "sign of the displacement (contraction is positive) or of the force."
        )
        yield Doubt("displacement_sign", text, "displacement", True)
    elif likeness < FALLS and force.mean() > 0.0 and record.kind != "dynamic":  # else it is no isobar
        half, free = _half(e, force), _free(record)
        slope, offset = np.polyfit(e, force, 1)
        end = float(-offset / slope)
        grave = half is not None and not HALF[0] < half / free < HALF[1]
        if grave or (likeness < -0.7 and not BEND[0] < end < BEND[1]):
            what = f"the force falls as if it ended at a contraction of {end:.3g}, where a muscle ends at 0.15 to 0.4"
            if grave:
                low, high = (share * free for share in HALF)
                what = f"half of the force is gone within a contraction of {half:.2g}, not {low:.2g} to {high:.2g}"
            text = f"at {level:g} MPa {what}. Check the unit of the displacement and initial_length_mm of the specimen."
            yield Doubt("displacement_scale", text, "displacement", grave)


def _doubt_lift(record: Record) -> Iterator[Doubt]:
    """Under a load a braid shortens by about what an ideal one would."""
    p, specimen = record.inputs.pressure, record.specimen
    inflated = p > LIFTING * p.max()
    ideal = specimen.ideal_contraction(np.maximum(p[inflated], LEAST_MPA), record.force[inflated])
    way, expected = (np.diff(np.quantile(one, ENDS))[0] for one in (record.inputs.contraction[inflated], ideal))
    if expected > LEAST_LIFT and not LIFT[0] < way / expected < LIFT[1]:
        text = (
            f"under its loads the contraction changes by {way:.3g}, where an ideal braid's changes by {expected:.3g}. "
            "Check the unit of the displacement and initial_length_mm of the specimen."
        )
        yield Doubt("displacement_scale", text, "displacement", True)


def _half(e: Array, force: Array) -> float | None:
    """How far from the least contraction the force is half of what it is there, None where it never is."""
    order = np.argsort(e, kind="stable")
    bins = [part for part in np.array_split(order, min(20, len(e))) if len(part)]
    at = np.array([e[part].mean() for part in bins])
    mean = np.array([np.median(force[part]) for part in bins])
    below = np.flatnonzero(mean < 0.5 * mean[0])
    if not len(below) or mean[0] <= 0.0:
        return None
    k = below[0]
    return float(np.interp(-0.5 * mean[0], -mean[[k - 1, k]], at[[k - 1, k]]) - at[0])
