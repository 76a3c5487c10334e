"""Where the tracking error comes from: the paper's three causes, each switched off in turn."""

from dataclasses import dataclass, replace

import numpy as np

from .hinge import Hinge
from .linear import linearised
from .loop import Loop, Task
from .tuning import Tuned, tune


@dataclass(frozen=True)
class Budget:
    """Rms errors in degrees of a PID without feed-forward, from which the shares of the paper's three causes follow.

    `by_hand` with all of them: gains found by trial and error. `automatic`: the same leg with the gains that are found
    automatically. `hinge` and `linear`, tuned automatically as well: a hinge of the same mean transmission in place of
    the four-bar knee; the plane nearest to the muscle, which keeps its damping, in place of the muscle.
    """

    by_hand: float
    automatic: float
    hinge: float
    linear: float

    @property
    def tuning(self) -> float:
        """What trial and error adds to the error, in degrees."""
        return self.by_hand - self.automatic

    @property
    def structure(self) -> float:
        """What the four-bar adds to the error of the best tuned leg; below zero where it helps."""
        return self.automatic - self.hinge

    @property
    def muscle(self) -> float:
        """What the muscle's nonlinearity and hysteresis add to that; below zero where they help."""
        return self.automatic - self.linear


def budget(loop: Loop, task: Task, judged: slice, by_hand: Tuned, automatic: Tuned, seed: int = 1) -> Budget:
    """A plain PID on the leg, on one with a hinge, on one with linear muscles. Each is tuned anew, beginning with the
    leg's own gains: with gains meant for another leg the difference would be that of the tuning."""
    pair = loop.pair
    target = np.asarray(task.target)
    ends = (float(target.min()), float(target.max()))
    hinge = replace(pair.leg, knee=Hinge.like(pair.leg.knee, ends))
    sprocket = pair.leg.knee.at(np.array(ends)).sprocket
    strokes = np.stack(pair.leg.contraction(sprocket, 1e-3 * pair.muscle.specimen.initial_length_mm))
    plane = linearised(pair.muscle, (0.0, pair.highest_MPa), (float(strokes.min()), float(strokes.max())))
    others = (replace(pair, leg=hinge), replace(pair, muscle=plane))
    hinged, plain = (tune(replace(loop, pair=other), task, judged, automatic.gains, seed).rms_deg for other in others)
    return Budget(by_hand.rms_deg, automatic.rms_deg, hinged, plain)
