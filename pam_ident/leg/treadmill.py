"""The ground below the prototype: a padded belt that runs back as fast as the gait's foot does."""

import math
from dataclasses import dataclass

import numpy as np

from ..core import UsageError
from .anatomy import Leg
from .gait import Gait

SLIP_M_S = 0.05
"""Slip over which friction turns over, so that it can be integrated; assumed."""


@dataclass(frozen=True)
class Treadmill:
    """A pad from `below_hip_m` down, under heel and ball each with a force of its own after Hunt & Crossley (1975, J.
    Appl. Mech. 42, 440–445), F = stiffness · δ (1 + damping · dδ/dt) at the depth δ, and with Coulomb friction on the
    belt. It never pulls."""

    below_hip_m: float
    stiffness_N_m: float
    damping_s_m: float
    friction: float

    def force(self, depth_m: float, sinking_m_s: float, slip_m_s: float) -> tuple[float, float]:
        """Forward and upward force in N on a point of the sole: how deep, how fast it sinks and slips forward."""
        up = self.stiffness_N_m * max(depth_m, 0.0) * max(1.0 + self.damping_s_m * sinking_m_s, 0.0)
        return -self.friction * up * math.tanh(slip_m_s / SLIP_M_S), up

    def belt_m_s(self, leg: Leg, gait: Gait) -> float:
        """Mean speed at which the gait's sole goes back while it is in the pad. Raises UsageError where it never is."""
        time = np.linspace(0.0, 1.0 / gait.cadence_Hz, 401)
        motion = gait.at(time)
        shank = np.exp(-1j * motion.knee.angle)
        ankle = -1j * leg.thigh.length_m + leg.knee.at(motion.knee.angle).knee[0] - 1j * shank * leg.shank.length_m
        foot = shank * np.exp(1j * motion.ankle.angle)
        places = [np.exp(1j * motion.hip.angle) * (ankle + foot * point) for point in sole(leg)]
        back = [-np.gradient(place.real, time)[place.imag < -self.below_hip_m] for place in places]
        touching = np.concatenate(back)
        if not len(touching):
            low = -min(float(place.imag.min()) for place in places)
            raise UsageError(
                f"the sole reaches {low:.3f} m below the hip and never the ground, [ground] below_hip_m = "
                f"{self.below_hip_m:g}; raise the ground"
            )
        return float(np.mean(touching))


def sole(leg: Leg) -> tuple[complex, complex]:
    """Heel and ball below the ankle, in the foot's frame; 60 mm behind it and 125 mm ahead are assumed."""
    return -0.06 - 1j * leg.foot.length_m, 0.125 - 1j * leg.foot.length_m
