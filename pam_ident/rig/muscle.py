"""The muscle on the rig: geometry of the braid and the two base force laws hidden effects act upon.

Units: force N, gauge pressure MPa (= N/mm^2), lengths mm, contraction eps = (L0 - L)/L0 without unit.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.floating[Any]]
AMBIENT_MPA = 0.1013


@dataclass(frozen=True)
class RigSpecimen:
    """Braid geometry at rest; constant thread length, cylinder all along. Contractions `eps` may have any shape."""

    initial_length_mm: float = 200.0
    initial_radius_mm: float = 10.0
    braid_angle_deg: float = 25.4
    wall_thickness_mm: float = 1.5

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not value > 0:
                raise ValueError(f"{name} = {value}: a specimen needs positive dimensions")
        if not 5 < self.braid_angle_deg < 54:
            raise ValueError(f"braid_angle_deg = {self.braid_angle_deg}: a braid that contracts has 5..54")

    def cosine(self, eps: Array) -> Array:
        """cos(theta) = (1 - eps) cos(theta0), clipped below 1 where noise pulls the braid straight."""
        return np.minimum((1 - eps) * np.cos(np.radians(self.braid_angle_deg)), 0.999)

    def radius(self, eps: Array) -> Array:
        """Braid radius (mm): thread length and turns fixed, so r/r0 = sin(theta)/sin(theta0)."""
        return self.initial_radius_mm * np.sqrt(1 - self.cosine(eps) ** 2) / np.sin(np.radians(self.braid_angle_deg))

    def volume(self, eps: Array) -> Array:
        """Gas volume L pi r^2 (mm^3)."""
        return np.pi * self.initial_length_mm * (1 - eps) * self.radius(eps) ** 2

    def log_volume_slope(self, eps: Array) -> Array:
        """V'(eps)/V: minus the shortening of the cylinder plus the growth of its cross section."""
        cos2 = self.cosine(eps) ** 2
        return (3 * cos2 - 1) / ((1 - cos2) * (1 - eps))

    def lateral_area(self, eps: Array) -> Array:
        """Braid lateral surface 2 pi r L against its value at rest; it grows with contraction."""
        return (self.radius(eps) / self.initial_radius_mm) * (1 - eps)


@dataclass(frozen=True)
class Exponential:
    """F = (a0 + a1 p) - (b0 + b1 p) eps + (c0 + c1 p) exp(-mu eps), p in MPa, eps of its shape; defaults: law (4)."""

    a0: float = -197.8
    a1: float = 2442.0
    b0: float = 1735.0
    b1: float = 5464.0
    c0: float = -9.3
    c1: float = 688.3
    mu: float = 45.0
    name: str = "exponential_law"

    def force(self, p: Array, eps: Array) -> Array:
        """Pull force (N) at gauge pressure p (MPa) and contraction eps."""
        line = self.a0 + self.a1 * p - (self.b0 + self.b1 * p) * eps
        return line + (self.c0 + self.c1 * p) * np.exp(-self.mu * eps)


@dataclass(frozen=True)
class ChouHannaford:
    """F = k0 pi r0^2 p [a (1 - k1 eps)^2 - b] + k2, one k0, k1, k2 (N) for all pressures; p, eps of one shape."""

    specimen: RigSpecimen
    k0: float = 0.87
    k1: float = 1.15
    k2: float = 0.0
    name: str = "modified_chou_hannaford"

    def force(self, p: Array, eps: Array) -> Array:
        """Pull force (N) at gauge pressure p (MPa) and contraction eps."""
        theta0 = np.radians(self.specimen.braid_angle_deg)
        shape = 3 / np.tan(theta0) ** 2 * (1 - self.k1 * eps) ** 2 - 1 / np.sin(theta0) ** 2
        return self.k0 * np.pi * self.specimen.initial_radius_mm**2 * p * shape + self.k2


@dataclass(frozen=True)
class RigMuscle:
    """A specimen with the static law that holds for it; p (MPa) and eps are of one shape."""

    specimen: RigSpecimen
    law: Exponential | ChouHannaford

    def force(self, p: Array, eps: Array) -> Array:
        """Static force (N)."""
        return self.law.force(p, eps)

    def pressure_slope(self, p: Array, eps: Array) -> Array:
        """dF/dp (N/MPa), by a central difference: both laws are straight lines in p."""
        return (self.law.force(p + 0.01, eps) - self.law.force(p - 0.01, eps)) / 0.02

    def contraction(self, p: Array, load: Array) -> Array:
        """Contraction at which the muscle holds a load (N) at gauge pressure p (MPa), shapes (m,)."""
        eps = np.full_like(p, 0.05)
        for _ in range(30):
            slope = (self.law.force(p, eps + 1e-4) - self.law.force(p, eps - 1e-4)) / 2e-4
            eps = eps - np.clip((self.law.force(p, eps) - load) / slope, -0.05, 0.05)
        return eps

    def stroke_mm(self, pressure: float, share: float = 0.28) -> float:
        """Where the stroke ends: at zero force, or at `share` of the length if that comes first."""

        def pull(eps: float) -> float:
            return float(self.law.force(np.array([pressure]), np.array([eps]))[0])

        if pull(0.0) <= 0:
            raise ValueError(f"no pull at rest at {pressure} MPa: nothing to measure there")
        limit = share if pull(share) >= 0 else float(brentq(pull, 0.0, share))  # type: ignore[arg-type]
        return limit * self.specimen.initial_length_mm


def draw_specimen(rng: np.random.Generator, vary: bool = True) -> RigSpecimen:
    """The practice specimen, or one of its relatives (10 to 20 % other dimensions)."""
    if not vary:
        return RigSpecimen()
    return RigSpecimen(
        float(rng.choice([150.0, 180.0, 220.0, 250.0, 300.0])),
        round(rng.uniform(8.5, 12.0), 2),
        round(rng.uniform(23.5, 27.5), 1),
        round(rng.uniform(1.0, 2.2), 2),
    )


def draw_muscle(rng: np.random.Generator, law: str, specimen: RigSpecimen) -> RigMuscle:
    """A plausible muscle: coefficients scattered about law (4), or about k0 0.87, k1 1.15, k2 0."""
    if law == "modified_chou_hannaford":
        k0, k1, k2 = rng.uniform(0.75, 1.0), rng.uniform(1.05, 1.25), rng.uniform(-20.0, 20.0)
        return RigMuscle(specimen, ChouHannaford(specimen, k0, k1, k2))
    if law != "exponential_law":
        raise ValueError(f"law {law!r}: the rig knows exponential_law and modified_chou_hannaford")
    area = (specimen.initial_radius_mm / 10.0) ** 2
    spread = {"a0": 0.12, "a1": 0.10, "b0": 0.12, "b1": 0.08, "c0": 0.20, "c1": 0.10, "mu": 0.20}
    base = asdict(Exponential())
    for _ in range(100):
        values = {k: base[k] * (1 + rng.uniform(-s, s)) * (1.0 if k == "mu" else area) for k, s in spread.items()}
        law_drawn = Exponential(**values)
        if law_drawn.force(np.array([0.1]), np.array([0.012]))[0] > 0:
            return RigMuscle(specimen, law_drawn)
    raise RuntimeError("no muscle with a stroke at 0.1 MPa was drawn")
