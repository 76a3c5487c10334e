"""A four-bar knee, solved in closed form.

Points of the sagittal plane are complex numbers, x forward and y up, so that a turn by an angle is a product. The thigh
is the ground link and the shank the coupler. The same code runs on NumPy and on JAX arrays.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..core import UsageError

Array = Any
"""A float or complex array of NumPy or JAX."""
LEAST_SINE = 0.05
"""Sine of the angle between crank and diagonal below which a posture counts as a dead centre, about 3°."""


def as_array(x: Array) -> Array:
    """Numbers and lists as a NumPy array of their shape; arrays of any library as they are."""
    return x if hasattr(x, "__array_namespace__") else np.asarray(x, float)


class Posture(NamedTuple):
    """The linkage at flexions φ of any shape; all fields have that shape, lengths are in m, derivatives by φ.

    `sprocket` is the crank's turn from the straight leg in rad, positive in flexion, `ratio` = ds/dφ and `bend` =
    d²s/dφ². The complex vectors are given in the thigh's frame, each with its first and second derivative: `knee`, the
    place of the shank's origin from where it lies when the leg is straight; `crank` and `rocker`, the two links from
    their pivots on the thigh to those on the shank.
    """

    sprocket: Array
    ratio: Array
    bend: Array
    knee: tuple[Array, Array, Array]
    crank: tuple[Array, Array, Array]
    rocker: tuple[Array, Array, Array]

    @property
    def centre(self) -> Array:
        """Instantaneous centre of the shank's turn against the thigh, in the thigh's frame, from the straight knee."""
        return self.knee[0] - 1j * self.knee[1]


@dataclass(frozen=True)
class FourBar:
    """Four pivots, as complex places in m from the knee's origin while the leg is straight.

    Crank and rocker each join a pivot on the thigh to one on the shank. The sprocket is fixed to the crank, about the
    crank's pivot on the thigh. `low` and `high` in rad bound the flexion for which the linkage must close.

    Raises UsageError where it cannot close over that range, or meets a dead centre, or turns its sprocket backwards.
    """

    crank_thigh: complex
    rocker_thigh: complex
    crank_shank: complex
    rocker_shank: complex
    low: float = np.radians(-10.0)
    high: float = np.radians(85.0)

    def __post_init__(self) -> None:
        flexion = np.linspace(self.low, self.high, 381)
        _, g, along = self._loop(flexion)
        reach = self.lengths[0] ** 2 * _dot(g, g)
        wrong, word = reach - along**2 <= LEAST_SINE**2 * reach, "cannot close"
        if not wrong.any():
            wrong, word = self.at(flexion).ratio <= 0.0, "turns its sprocket backwards"
        if wrong.any():
            worst = np.degrees(flexion[wrong][np.argmin(np.abs(flexion[wrong]))])
            raise UsageError(
                f"the four-bar knee {word} at {worst:.1f}° of flexion; expected {np.degrees(self.low):.0f}° to "
                f"{np.degrees(self.high):.0f}°: change its pivots or its range"
            )

    @property
    def lengths(self) -> tuple[float, float, float, float]:
        """Lengths of crank, coupler (on the shank), rocker and ground link (on the thigh), m."""
        return (
            abs(self.crank_shank - self.crank_thigh),
            abs(self.rocker_shank - self.crank_shank),
            abs(self.rocker_shank - self.rocker_thigh),
            abs(self.rocker_thigh - self.crank_thigh),
        )

    def _loop(self, flexion: Array) -> tuple[Array, Array, Array]:
        """Coupler w = C→D, the diagonal's vector g = v − u, and crank · g, the last from the three fixed lengths."""
        crank, _, rocker, _ = self.lengths
        w = _turned(flexion) * (self.rocker_shank - self.crank_shank)
        g = self.crank_thigh - self.rocker_thigh + w
        return w, g, 0.5 * (rocker**2 - crank**2 - _dot(g, g))

    def at(self, flexion: Array) -> Posture:
        """The posture at `flexion` in rad, any shape; NaN where the linkage cannot close.

        The shank's turn gives the coupler w. Crank u and rocker v = u + g with g = A − B + w then follow from
        |u| and |v|: u · g is known, and the sign of u × g stays what it is for the straight leg. The rates follow from
        the same closure, differentiated: u' = iθ'u with θ' (iu · g) = −v · g'.
        """
        flexion = as_array(flexion)
        xp = flexion.__array_namespace__()
        start = self.crank_shank - self.crank_thigh
        side = np.sign(_cross(self.crank_thigh - self.rocker_thigh + self.rocker_shank - self.crank_shank, start))
        w, g, along = self._loop(flexion)
        square = _dot(g, g)
        across = side * xp.sqrt(self.lengths[0] ** 2 * square - along**2)
        u = (along + 1j * across) * g / square
        v = u + g
        g1, g2 = -1j * w, -w
        lever = _dot(1j * u, g)
        turn1 = -_dot(v, g1) / lever
        u1 = 1j * turn1 * u
        v1 = u1 + g1
        turn2 = -(_dot(v1, g1) + _dot(v, g2) + turn1 * (_dot(1j * u1, g) + _dot(1j * u, g1))) / lever
        u2 = 1j * turn2 * u - turn1**2 * u
        arm = _turned(flexion) * self.crank_shank
        knee = (self.crank_thigh + u - arm, u1 + 1j * arm, u2 + arm)
        sprocket = xp.atan2(_cross(u, start), _dot(u, start))
        return Posture(sprocket, -turn1, -turn2, knee, (u, u1, u2), (v, v1, u2 + g2))


def _turned(flexion: Array) -> Array:
    """exp(−iφ): a shank that is flexed by φ."""
    xp = as_array(flexion).__array_namespace__()
    return xp.cos(flexion) - 1j * xp.sin(flexion)


def _dot(a: Array, b: Array) -> Array:
    return (a.conjugate() * b).real


def _cross(a: Array, b: Array) -> Array:
    return (a.conjugate() * b).imag
