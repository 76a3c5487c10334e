"""Where the tracking error comes from: the paper's three causes, each switched off in turn.

In place of the four-bar knee stands a hinge, in place of the muscle one without its nonlinearity and hysteresis.
"""

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ..core import Param
from ..effects import get_effect
from ..laws import Law
from ..model import Model, Term
from .arrays import jnp
from .four_bar import FourBar, Posture, as_array
from .loop import Loop, Task
from .muscle import Muscle
from .tuning import Tuned, tune

Array = np.ndarray
SPEED_MM_S = 100.0
"""Speed at which the damping is taken, that of a knee's walking."""


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


@dataclass(frozen=True)
class Hinge:
    """The shank turns about the knee's origin, the sprocket with it at the fixed `ratio`. Its links are idle."""

    ratio: float
    lengths = (0.0, 1.0, 1.0, 1.0)
    crank_thigh = rocker_thigh = 0j

    @classmethod
    def like(cls, knee: FourBar, flexion_rad: tuple[float, float]) -> "Hinge":
        """The mean transmission of a four-bar between two flexions."""
        begin, end = (float(knee.at(angle).sprocket) for angle in flexion_rad)
        return cls((end - begin) / (flexion_rad[1] - flexion_rad[0]))

    def at(self, flexion: Array) -> Posture:
        """The posture at `flexion` in rad, any shape."""
        flexion = as_array(flexion)
        still = 0.0 * flexion
        link = (still + 0j, still + 0j, still + 0j)
        return Posture(self.ratio * flexion, still + self.ratio, still, link, link, link)


def _columns(p: Array, e: Array, specimen: object, shape: object) -> Array:
    return p.__array_namespace__().stack([0.0 * e + 1.0, p, e]).T


LAW = Law(
    name="linear_muscle",
    title="Linear muscle",
    formula="F = F0 + F1 p + F2 ε",
    source="least squares over the working range of another model",
    linear=(
        Param("F0", "N", "force"),
        Param("F1", "N/MPa", "force per pressure"),
        Param("F2", "N", "force per stroke"),
    ),
    columns=_columns,
)


def linearised(muscle: Muscle, pressures_MPa: tuple[float, float], contractions: tuple[float, float]) -> Muscle:
    """The plane nearest to the pull of `muscle`, where it pulls, over a grid of gauge pressures and contractions, at
    rest and moving both ways: dry friction becomes the damping that takes as much at SPEED_MM_S."""
    axes = (np.linspace(*pressures_MPa, 21), np.linspace(*contractions, 21), SPEED_MM_S * np.array([-1.0, 0.0, 1.0]))
    p, e, v = (jnp.asarray(a.ravel()) for a in np.meshgrid(*axes))
    pull, _ = muscle.force(muscle.values(), muscle.start(p, e), 0.0, p, e, v)
    columns = np.column_stack([np.asarray(_columns(p, e, None, None)), -1e-3 * np.asarray(v)])
    taut = np.asarray(pull) > 0.0
    sizes, *_ = np.linalg.lstsq(columns[taut], np.asarray(pull)[taut], rcond=None)
    model = Model(LAW, (Term(*get_effect("viscous_damping")),))
    values = MappingProxyType(dict(zip(model.names, sizes.tolist(), strict=True)))
    return Muscle(model, muscle.specimen, values, values)
