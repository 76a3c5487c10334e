"""Where the tracking error comes from: the paper's three causes, each switched off in turn."""

from dataclasses import dataclass, replace

import numpy as np

from .hinge import Hinge
from .linear import linearised
from .loop import Loop, Task
from .tuning import Tuned, tune_by_hand


@dataclass(frozen=True)
class Budget:
    """Rms errors in degrees of a PID without feed-forward: with all causes, and with each one switched off.

    `structure`: the four-bar knee, off: a hinge of the same mean transmission. `tuning`: gains found by trial and
    error, off: the automatic ones. `muscle`: nonlinearity and hysteresis, off: the
    plane nearest to the muscle, which keeps its damping.
    """

    everything: float
    without_structure: float
    without_tuning: float
    without_muscle: float

    @property
    def structure(self) -> float:
        """What the four-bar adds to the error, in degrees; below zero where it helps."""
        return self.everything - self.without_structure

    @property
    def tuning(self) -> float:
        """What trial and error adds."""
        return self.everything - self.without_tuning

    @property
    def muscle(self) -> float:
        """What the muscle's nonlinearity and hysteresis add."""
        return self.everything - self.without_muscle


def budget(loop: Loop, task: Task, judged: slice, by_hand: Tuned, automatic: Tuned) -> Budget:
    """A plain PID on the leg, on one with a hinge, on one with linear muscles. Each leg is tuned by hand anew, as its
    owner would: with gains meant for another leg the difference would be that of the tuning."""
    pair = loop.pair
    target = np.asarray(task.target)
    ends = (float(target.min()), float(target.max()))
    hinge = replace(pair.leg, knee=Hinge.like(pair.leg.knee, ends))
    sprocket = pair.leg.knee.at(np.array(ends)).sprocket
    strokes = np.stack(pair.leg.contraction(sprocket, 1e-3 * pair.muscle.specimen.initial_length_mm))
    plane = linearised(pair.muscle, (0.0, pair.highest_MPa), (float(strokes.min()), float(strokes.max())))
    others = (replace(pair, leg=hinge), replace(pair, muscle=plane))
    structure, muscle = (tune_by_hand(replace(loop, pair=other), task, judged).rms_deg for other in others)
    return Budget(by_hand.rms_deg, structure, automatic.rms_deg, muscle)
