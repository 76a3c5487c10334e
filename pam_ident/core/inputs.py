"""What a force law is given: the specimen's geometry and the state of the muscle, sample by sample.

Internal units: pressure MPa (gauge), length mm, force N, time s, temperature degrees Celsius, so that
MPa times mm² is N. Contraction is positive when the muscle shortens.
"""

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from .errors import DataError
from .recursion import Array, Live

THINNEST_MM = 0.01
"""A wall that is thinner is no bladder's, but given in another unit."""


@dataclass(frozen=True)
class Sensors:
    """Standard deviations of the sensors' errors from sample to sample. Raises DataError for one below 0, or for a
    force that is read without error."""

    force_N: float
    pressure_MPa: float = 0.0
    displacement_mm: float = 0.0

    def __post_init__(self) -> None:
        for key in ("force_N", "pressure_MPa", "displacement_mm"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value >= 0.0) or self.force_N == 0.0:
                raise DataError(f"sensors: {key} = {value}; expected a standard deviation, above 0 for force_N")


@dataclass(frozen=True)
class Specimen:
    """Geometry of a muscle at rest.

    Args:
        name: what it is called.
        initial_length_mm: length L0 without pressure and load, mm.
        initial_radius_mm: radius r0 of the braid at rest, mm.
        braid_angle_deg: angle θ0 between thread and axis at rest, degrees, 5 to 54 (from 54.7 on it cannot contract).
        wall_thickness_mm: of the bladder, mm; None where it is not known.
        sensors: those of the rig it was measured on, None where they are not known.

    Raises:
        DataError: for a length that is not positive, a wall as thick as the radius, or an angle out of range.

    Example:
        >>> from pam_ident.core import Specimen
        >>> muscle = Specimen("muscle 7", initial_length_mm=200.0, initial_radius_mm=10.0, braid_angle_deg=25.4)
        >>> print(f"{muscle.ideal_force(0.5, 0.0):.0f} N at 0.5 MPa and rest length")
        1236 N at 0.5 MPa and rest length
    """

    name: str = "unnamed"
    initial_length_mm: float = 200.0
    initial_radius_mm: float = 10.0
    braid_angle_deg: float = 25.0
    wall_thickness_mm: float | None = None
    sensors: Sensors | None = None

    def __post_init__(self) -> None:
        for key in ("initial_length_mm", "initial_radius_mm", "wall_thickness_mm"):
            value = getattr(self, key)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise DataError(f"specimen {self.name}: {key} = {value}; expected a length above 0 mm")
        wall = self.wall_thickness_mm
        if wall is not None and not THINNEST_MM <= wall < self.initial_radius_mm:
            raise DataError(
                f"specimen {self.name}: wall_thickness_mm = {wall}; expected {THINNEST_MM:g} mm or more, and less than "
                f"the radius of {self.initial_radius_mm:g} mm"
            )
        if not 5.0 <= self.braid_angle_deg <= 54.0:
            raise DataError(
                f"specimen {self.name}: braid_angle_deg = {self.braid_angle_deg}; expected 5 to 54 degrees "
                "between thread and axis"
            )

    @property
    def geometry(self) -> str:
        """Length, radius and braid angle, in words."""
        return (
            f"length {self.initial_length_mm:g} mm, radius {self.initial_radius_mm:g} mm, "
            f"braid angle {self.braid_angle_deg:g}°"
        )

    @property
    def a(self) -> float:
        """3 / tan²θ0 (Chou & Hannaford 1996)."""
        return 3.0 / math.tan(math.radians(self.braid_angle_deg)) ** 2

    @property
    def b(self) -> float:
        """1 / sin²θ0 (Chou & Hannaford 1996)."""
        return 1.0 / math.sin(math.radians(self.braid_angle_deg)) ** 2

    def ideal_force(self, pressure: Array, contraction: Array) -> Array:
        """π r0² p [a(1−ε)² − b] in N, shape (n,), of the ideal braid (Chou & Hannaford 1996) at p in MPa."""
        return math.pi * self.initial_radius_mm**2 * pressure * (self.a * (1.0 - contraction) ** 2 - self.b)

    def ideal_contraction(self, pressure: Array, force: Array) -> Array:
        """Contraction at which the ideal braid pulls with a force in N at p in MPa, above 0, shape (n,): the inverse of
        `ideal_force`."""
        xp = force.__array_namespace__()
        share = force / (math.pi * self.initial_radius_mm**2 * pressure)
        return 1.0 - xp.sqrt(xp.maximum(share + self.b, 0.0) / self.a)

    def radius_ratio(self, contraction: Array) -> Array:
        """r / r0 of the ideal braid at a contraction ratio (any shape), from cosθ = (1−ε) cosθ0."""
        square = (3.0 * self.b - self.a * (1.0 - contraction) ** 2) / 3.0
        xp = square.__array_namespace__()
        return xp.sqrt(xp.maximum(square, 1e-9))

    def log_volume_slope(self, contraction: Array) -> Array:
        """d ln V / dε of the braid's cylinder V = π r² L (any shape, dimensionless)."""
        ratio = self.radius_ratio(contraction)
        return 2.0 * self.a * (1.0 - contraction) / (3.0 * ratio**2) - 1.0 / (1.0 - contraction)


@dataclass(frozen=True, eq=False)
class Inputs:
    """The state of the muscle at n samples, in the order of time.

    `velocity` is dx/dt of the contraction in mm/s; `direction` is +1 on the contraction branch, −1 on
    extension, 0 where a static table knows no branch; a hold keeps the direction of the motion before
    it and has `moving` False. `stroke_speed` is the median speed of the stroke a sample belongs to.
    `segment` numbers the runs between changes of what is held or gaps in time. `slide` is the contraction of the braid
    alone, of which velocity and direction are, where that is another: of a locked muscle; `pressure_rate`, in MPa/s,
    that of a driven pressure; `locked` whether it alone is driven. Fields that a record lacks are None. With `live` the
    samples are no record, but n muscles at one instant.
    """

    pressure: Array
    contraction: Array
    specimen: Specimen
    direction: Array
    time: Array | None = None
    velocity: Array | None = None
    stroke_speed: Array | None = None
    moving: Array | None = None
    cycle: Array | None = None
    temperature: Array | None = None
    segment: Array | None = None
    slide: Array | None = None
    pressure_rate: Array | None = None
    locked: bool = False
    live: Live | None = None

    def __len__(self) -> int:
        return len(self.pressure)

    @property
    def xp(self) -> Any:
        """The array namespace of these samples: NumPy for a record, JAX where a model is traced."""
        return self.pressure.__array_namespace__()

    @cached_property
    def displacement_mm(self) -> Array:
        """Contraction in mm, shape (n,)."""
        return self.contraction * self.specimen.initial_length_mm

    @property
    def seconds(self) -> float:
        """From the first sample to the last; without end where no time was recorded."""
        return math.inf if self.time is None else float(self.time[-1] - self.time[0])

    @cached_property
    def interval(self) -> float:
        """The usual time from a sample to the next in s, 0 where no time was recorded."""
        return 0.0 if self.time is None or len(self) < 2 else float(np.median(np.diff(self.time)))

    @property
    def way(self) -> Array:
        """Contraction of the braid, along which it slides and rubs, shape (n,)."""
        return self.contraction if self.slide is None else self.slide

    @property
    def way_mm(self) -> Array:
        """The same in mm, shape (n,)."""
        return self.displacement_mm if self.slide is None else self.slide * self.specimen.initial_length_mm

    @cached_property
    def reach_mm(self) -> float:
        """The longest way in mm without a break of the test."""
        breaks = [] if self.segment is None else np.flatnonzero(np.diff(self.segment)) + 1
        return max(float(np.ptp(part)) for part in np.split(self.way_mm, breaks))

    def has(self, need: str) -> bool:
        """Whether the record holds what `need` names: branch, motion, time, cycle, temperature or driven pressure."""
        if need == "branch":
            return bool(np.any(self.direction != 0))
        if need == "driven pressure":
            return self.pressure_rate is not None and not self.locked
        field = {"motion": self.velocity, "time": self.time, "cycle": self.cycle, "temperature": self.temperature}
        return field[need] is not None

    def take(self, rows: Array | slice) -> "Inputs":
        """Some of the samples, by index (m,), mask (n,) or slice."""
        arrays = {f.name: value for f in fields(self) if isinstance(value := getattr(self, f.name), np.ndarray)}
        return replace(self, **{name: value[rows] for name, value in arrays.items()})

    def with_geometry(self, radius_mm: float, angle_deg: float) -> "Inputs":
        """The same samples on a specimen of another radius (mm) and braid angle (degrees)."""
        geometry = replace(self.specimen, initial_radius_mm=radius_mm, braid_angle_deg=angle_deg)
        return replace(self, specimen=geometry)
