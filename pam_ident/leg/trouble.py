"""Trouble in a run: what happened, and at which moment; and whether it asks of the muscles what their fit has seen."""

import math
from dataclasses import dataclass

import numpy as np

from ..records.doubt import Doubt
from .control import SAMPLE_S
from .course import Course
from .feed_forward import PressurePlan
from .loop import Log, Task
from .muscle import Muscle
from .pair import Pair
from .pneumatics import ATMOSPHERE

LOST_DEG = 30.0
STROKE = (-0.03, 0.25)
"""Contraction a Festo muscle is made for (data sheet DMSP/MAS: 3 % stretch, 25 % contraction)."""
HELD = 3
"""So many samples in a row make an event."""
WORDS = {
    "unstable": "the loop is unstable: the error passes 30 degrees",
    "slack": "a muscle is slack and pulls no more",
    "supply": "the pressure asked for is more than the supply gives or the muscles stand",
    "flow": "the valve cannot let through the air that the motion needs",
    "torque": "the pair cannot give the torque that the motion needs",
    "stroke": "the trajectory asks more stroke than the muscle has",
}

RANGES = {
    "pressure_MPa": "{:.3g} to {:.3g} MPa gauge",
    "contraction": "contraction {:.3f} to {:.3f}",
    "speed_mm_s": "{:.0f} to {:.0f} mm/s",
}
MARGIN = 0.02
"""Of a range, by which it may be left: sensors are not finer."""


@dataclass(frozen=True)
class Trouble:
    """A kind of trouble (a key of WORDS), its first moment in s, its share of the time judged, and what to do."""

    kind: str
    time_s: float
    share: float
    advice: str

    def __str__(self) -> str:
        return f"from {self.time_s:.3f} s, {100 * self.share:.0f} % of the time: {WORDS[self.kind]}; {self.advice}"


def _event(kind: str, where: np.ndarray, advice: str, begin: int) -> list[Trouble]:
    """At the first run of HELD samples in which `where` (n,) holds."""
    runs = np.convolve(where, np.ones(HELD), "valid") >= HELD
    if not runs.any():
        return []
    return [Trouble(kind, (begin + int(np.argmax(runs))) * SAMPLE_S, float(np.mean(where)), advice)]


def troubles(pair: Pair, log: Log, task: Task, judged: slice) -> list[Trouble]:
    """What went wrong in a run, by the samples judged."""
    flexion, reference, force, opening = (a[judged] for a in (log.flexion, log.reference, log.force, log.opening))
    error = np.degrees(flexion - np.asarray(task.target)[judged])
    lost = ~(np.abs(error) < LOST_DEG)
    begin, found = judged.start, []
    if lost.any():
        first = (begin + int(np.argmax(lost))) * SAMPLE_S
        found = [Trouble("unstable", first, float(np.mean(lost)), "lower the gains, or let `track` tune them")]
    slack = np.min(force, axis=1) <= 0.0
    found += _event("slack", slack, "raise the mean pressure or the muscles' rest stretch", begin)
    most = min(pair.highest_MPa, 1e-6 * (pair.supply.pressure_Pa - ATMOSPHERE))
    full = np.max(reference, axis=1) >= most - 1e-9
    found += _event("supply", full, "raise the supply pressure, or lower cadence or load", begin)
    found += _event("flow", np.max(np.abs(opening), axis=1) > 0.99, "use a larger valve, or a lower cadence", begin)
    return found


def plan_troubles(plan: PressurePlan, judged: slice) -> list[Trouble]:
    """What a feed-forward's plan cannot reach whatever the controller: torque, flow, stroke of the muscle."""
    begin = judged.start
    missing, scale = np.abs(plan.missing[judged]), np.max(np.abs(plan.torque))
    found = _event("torque", missing > 0.01 * scale, "raise supply or mean pressure, or lower cadence or load", begin)
    opening = np.max(np.abs(plan.opening[judged]), axis=1)
    found += _event("flow", opening > 1.0, "use a larger valve, or a lower cadence", begin)
    contraction = plan.contraction[judged]
    short = (np.min(contraction, axis=1) < STROKE[0]) | (np.max(contraction, axis=1) > STROKE[1])
    return found + _event("stroke", short, "use a longer muscle or a smaller sprocket", begin)


def outside(pair: Pair, model: Muscle, course: Course, pressure_MPa: np.ndarray) -> list[Doubt]:
    """Where a gait, followed at gauge pressures (N, 2) over the samples judged, leaves what the record behind `model`
    covered: at which flexion, in which part of the stride. Nothing where that is not known."""
    time = course.time[course.judged]
    phase, knee = 100.0 * (time * course.gait.cadence_Hz % 1.0), course.gait.at(time).knee
    posture = pair.leg.knee.at(knee.angle)
    strokes = pair.leg.contraction(posture.sprocket, 1e-3 * pair.muscle.specimen.initial_length_mm)
    speed = 1e3 * pair.leg.sprocket_radius_m * np.abs(posture.ratio * knee.rate)
    asked = {"pressure_MPa": pressure_MPa.T, "contraction": strokes, "speed_mm_s": (speed, speed)}
    found = []
    for quantity, both in asked.items():
        low, high = model.seen.get(quantity, (-math.inf, math.inf))
        least = -math.inf if quantity == "speed_mm_s" else low - MARGIN * (high - low)
        for name, values in zip(("flexor", "extensor"), both, strict=True):
            beyond = (values < least) | (values > high + MARGIN * (high - low))
            if beyond.any():
                there, part = np.degrees(knee.angle)[beyond], phase[beyond]
                found.append(
                    Doubt(
                        "outside_range",
                        f"{name} at {RANGES[quantity].format(values.min(), values.max())}, where the fit has seen "
                        f"{RANGES[quantity].format(low, high)}: {100.0 * beyond.mean():.0f} % of the time judged, "
                        f"knee at {there.min():.0f}° to {there.max():.0f}°, within {part.min():.0f} to "
                        f"{part.max():.0f} % of the stride; there the model is extrapolated",
                        quantity,
                    )
                )
    return found
