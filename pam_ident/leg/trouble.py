"""Trouble in a run: what happened, and at which moment."""

from dataclasses import dataclass

import numpy as np

from .control import SAMPLE_S
from .feed_forward import PressurePlan
from .loop import Log, Task
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
