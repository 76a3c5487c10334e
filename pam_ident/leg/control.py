"""PID on the knee angle, its output a split of the pair's pressures."""

from typing import Any, NamedTuple

import numpy as np

from .arrays import Array, jnp

SAMPLE_S = 0.005
"""The paper's interval of control."""
SIGN = np.array([1.0, -1.0])
"""Of flexor and extensor: one is inflated where the other is vented."""


class Gains(NamedTuple):
    """Proportional MPa/rad, integral MPa/(rad s), derivative MPa s/rad."""

    proportional: Array | float
    integral: Array | float
    derivative: Array | float


class Control(NamedTuple):
    """What the controller remembers: integral of the error (rad s), last error (rad), filtered slope (rad/s), and where
    it learns, what earlier strides taught."""

    integral: Array
    error: Array
    slope: Array
    learned: Any = ()


class Sensor(NamedTuple):
    """Angle sensor: `bits` over a range in rad."""

    bits: int = 12
    lowest: float = -0.35
    highest: float = 1.75

    def read(self, angle: Array) -> Array:
        """The nearest step of the converter to angles in rad of any shape."""
        step = (self.highest - self.lowest) / 2**self.bits
        return self.lowest + step * jnp.clip(jnp.round((angle - self.lowest) / step), 0, 2**self.bits - 1)


FILTER_S = 0.01
"""Time constant of the derivative."""


def start(error: Array) -> Control:
    """At the first sample, without a jump of the derivative; error in rad, of any shape."""
    return Control(jnp.zeros_like(error), error, jnp.zeros_like(error))


def pid(gains: Gains, control: Control, error: Array, ahead: Array, reach: float) -> tuple[Array, Control]:
    """Split in MPa of the shape of `error` (rad), and what the controller remembers after it.

    `ahead` is the split that a feed-forward gives already; their sum stays within ±reach. The integral waits while
    the sum stands at its limit and the error would drive it further (conditional integration, Åström & Hägglund 1995).
    """
    rough = (error - control.error) / SAMPLE_S
    slope = control.slope + SAMPLE_S / (FILTER_S + SAMPLE_S) * (rough - control.slope)
    integral = control.integral + SAMPLE_S * error
    wanted = gains.proportional * error + gains.integral * integral + gains.derivative * slope
    whole = ahead + wanted
    split = jnp.clip(whole, -reach, reach) - ahead
    stuck = (jnp.abs(whole) > reach) & (whole * error > 0.0)
    return split, control._replace(integral=jnp.where(stuck, control.integral, integral), error=error, slope=slope)
