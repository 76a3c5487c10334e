"""Everything that is doubtful of a record, whatever is asked of it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..core import Array
from ..core.digits import newtons, percent
from .clipped import ends_piled_up
from .doubt import GRAVE, Doubt
from .plausible import doubt_units
from .record import Record
from .unlike import doubt_runs

MOST_N = 1e6
"""Force that no muscle reaches; arithmetic with much larger ones overflows."""
SPIKE, FEW = 5.0, 0.02
"""A force so many times the largest plausible one, in at most this share of the rows, is a fault of the reading."""
STILL = 0.05
"""Standard deviation of a force beside that of an ideal braid's in the same states, below which it does not answer."""
CLIPPED_ROWS, CLIPPED_SHARE = 20, 0.02
"""Rows at the very same extreme force that make a limit, if the muscle moves meanwhile."""
FAST, SLOW, SLOW_LOGGED = 10.0, 2.2e-4, 1e-3
"""Fastest stroke in initial lengths a second: faster and slower than on any rig, and slow for one that is logged"""
LONG_STEP_S = 5.0
"""every so many seconds at most."""
CONTRADICTED = 0.5
"""Share of the moving samples whose branch the motion contradicts, from which it is no matter of corners."""
AS_THE_CLOCK = 0.99
"""Correlation with the time from which a temperature tells no more than that."""
WARM_C = (-40.0, 90.0)
"""Between these rubber is a bladder (Festo's: −5 to 60 °C)."""


def spikes(record: Record) -> Array:
    """Mask (n,) of the rows whose force is beyond what muscle and other rows permit: a few at most."""
    size = np.abs(record.force)
    blocked = float(np.abs(record.specimen.ideal_force(np.abs(record.inputs.pressure).max(), np.zeros(()))))
    wild = size > SPIKE * max(blocked, 5.0 * float(np.median(size)))
    return wild if wild.sum() <= max(FEW * len(size), 3) and not wild.all() else np.zeros(len(size), bool)


def doubt_force(record: Record, wild: Array) -> Iterator[Doubt]:
    """Impossible forces, pushing and clipping; `wild` (n,) as of `spikes`."""
    force = record.force
    huge = wild | (np.abs(force) > MOST_N)
    if huge.any():
        rows = np.flatnonzero(huge)
        more = f" (and {len(rows) - 1} more)" if len(rows) > 1 else ""
        text = (
            f"sample {rows[0] + 1}{more} reads a force of {newtons(float(force[rows[0]]))}, which this muscle cannot "
            "pull. Fix or delete the row."
        )
        yield Doubt("impossible_value", text, "force", True)
    if huge.all():
        return
    yield from _doubt_still(record)
    force = force[~huge]
    if force.min() < -0.05 * abs(force.max()):
        text = (
            f"the force goes down to {newtons(force.min())}, but a muscle pulls and cannot push. Check the zero "
            "of the load cell and its sign (pull is positive)."
        )
        yield Doubt("force_sign", text, "force", bool(force.mean() < 0.0 and force.min() < -0.5 * np.abs(force).max()))
    for here in ends_piled_up(record.force):
        yield from _doubt_limit(record, here)


def _doubt_still(record: Record) -> Iterator[Doubt]:
    """A force that stays the same, whatever is driven."""
    force, inputs = record.force, record.inputs
    ideal = float(record.specimen.ideal_force(inputs.pressure, inputs.contraction).std())
    if record.kind != "isotonic" and float(force.std()) < STILL * ideal:
        text = (
            f"the force stays at {newtons(force.mean())} within {newtons(force.std())} rms, where an ideal braid's "
            f"varies by {newtons(ideal)} rms: a load cell that is not connected, or another column than the force."
        )
        yield Doubt("force_constant", text, "force", True)
    elif len(force) > 1 and not np.ptp(force):
        text = (
            f"the force is {newtons(force[0])} in every row: the load of a hanging weight, or a load cell that is not "
            "connected."
        )
        yield Doubt("force_constant", text, "force")


def _doubt_limit(record: Record, here: Array) -> Iterator[Doubt]:
    """Many samples at the very same extreme force."""
    end, n, contraction = float(record.force[here][0]), int(here.sum()), record.inputs.contraction
    words = "lowest" if end == record.force.min() else "highest"
    moves = np.ptp(contraction[here]) > 0.03 * np.ptp(contraction) or len(np.unique(record.level[here])) > 1
    if words == "highest" and not moves:
        return
    why = "the reading is clipped or the muscle is slack" if words == "lowest" else "the reading is clipped"
    cure = ", or pretension the muscle" if words == "lowest" else ""
    text = (
        f"{n} samples read exactly {end:g} N, the {words} force: {why}. Leave those rows out (a column `slack` of 1 "
        f"and 0 does it){cure}."
    )
    yield Doubt("force_clipped", text, "force", bool(moves and n >= max(CLIPPED_ROWS, CLIPPED_SHARE * len(here))))


def doubt_clock(record: Record) -> Iterator[Doubt]:
    """A clock in another unit, its jumps within an isobar, and a load cell that drifts from one tare to the next."""
    time, segment = record.inputs.time, record.inputs.segment
    if time is None or segment is None:
        return
    yield from _doubt_pace(record)
    one = (np.diff(record.level) == 0.0) & (np.diff(record.run) == 0)  # between files a pause is put
    steps = np.diff(time)[(np.diff(segment) != 0) & one]
    if len(steps) and record.inputs.pressure_rate is None:  # else another length or weight may come after a pause
        text = (
            f"the time jumps within an isobar ({len(steps)} times), by up to {steps.max():.4g} s: samples are lost "
            "or the run was stopped. Log without a break, or give each run a file of its own."
        )
        yield Doubt("clock_jumps", text, "time")
    drift = _tare_drift(record)
    if drift is not None:
        text = (
            f"between the first and the last tare (no pressure) the force drifts by {newtons(drift)}, unless friction "
            "was left there. Tare the load cell before each isobar, let it warm up, and keep the tares in the record."
        )
        yield Doubt("tare_drift", text, "force")


def _doubt_pace(record: Record) -> Iterator[Doubt]:
    pace, moving = record.inputs.stroke_speed, record.inputs.moving
    if pace is None or moving is None or not moving.any() or record.kind == "isometric":
        return
    fastest = float(np.abs(pace[moving]).max())
    rate = fastest / record.specimen.initial_length_mm
    step = record.inputs.interval
    if rate > FAST:
        slip = "seconds taken for milliseconds?"
    elif 0.0 < rate < SLOW or (0.0 < rate < SLOW_LOGGED and step > LONG_STEP_S):
        slip = "milliseconds taken for seconds?"
    else:
        return
    text = (
        f"the fastest stroke is {fastest:.3g} mm/s with {step:.3g} s from sample to sample, as on no rig: {slip} Check "
        "the unit of the time."
    )
    yield Doubt("clock_scale", text, "time", True)


def _doubt_branch(record: Record) -> Iterator[Doubt]:
    """Branches that were given, and that the motion contradicts."""
    inputs = record.inputs
    if inputs.velocity is None or inputs.moving is None or record.kind == "isometric":
        return
    said = (inputs.direction * np.sign(inputs.velocity))[inputs.moving]
    wrong = float(np.mean(said < 0.0)) if len(said) else 0.0
    if wrong > CONTRADICTED:
        text = (
            f"in {percent(wrong)} of the samples that move, the branch is contraction where the length grows, or "
            "extension where it falls. Swap the two words, or check the sign of the displacement."
        )
        yield Doubt("branch_sign", text, "branch", True)


def doubt_temperature(record: Record) -> Iterator[Doubt]:
    """A temperature that no bladder has, or that tells no more than the clock does."""
    found, time = record.inputs.temperature, record.inputs.time
    if found is not None and time is not None and np.ptp(found) > 0.0:
        alike = float(np.corrcoef(found, time)[0, 1])
        if abs(alike) > AS_THE_CLOCK:
            text = (
                f"the temperature goes evenly with the time (correlation {alike:.4f}): what drifts with the one is "
                "hard to tell from what follows the other. Let the muscle cool in between, or test it warm and cold."
            )
            yield Doubt("temperature_clock", text, "temperature")
    if found is not None and not (WARM_C[0] < found.min() and found.max() < WARM_C[1]):
        worst = float(found.max() if found.max() >= WARM_C[1] else found.min())
        text = f"the temperature reaches {worst:.4g} °C, where a bladder is no rubber. Check its unit (kelvin?)."
        yield Doubt("temperature_scale", text, "temperature", True)


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
        unlike = tuple(doubt_runs(rest))
        yield from unlike or doubt_units(rest)  # of runs at odds the whole says nothing of a unit
        yield from _doubt_wander(record)
        yield from doubt_clock(rest)
        yield from _doubt_branch(rest)
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
