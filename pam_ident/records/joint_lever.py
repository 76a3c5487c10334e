"""A muscle on a joint: force from a measured torque and shape from an angle, as [lever] of a columns.toml says."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core import Array, DataError
from ..core.units import split_header, strange_unit
from .guess import column_of
from .quantities import Source

UNITS = {"torque": {"Nm": 1000.0, "Ncm": 10.0, "Nmm": 1.0}, "angle": {"deg": math.pi / 180.0, "rad": 1.0}}
"""What is measured at a joint → its units, in N·mm and in radians."""
SIZES = {"radius_mm", "a_mm", "b_mm", "angle_offset_deg", "fixed_mm"}
LEAST_ARM = 0.01
"""Arm beside the shorter of both distances below which a torque tells no force."""


@dataclass(frozen=True)
class JointLever:
    """Where the muscle pulls on a joint: over a pulley of `radius_mm`, or between two points at `a_mm` and `b_mm` from
    the joint's axis, `angle + angle_offset_deg` apart, of which `fixed_mm` are no muscle."""

    radius_mm: float = 0.0
    a_mm: float = 0.0
    b_mm: float = 0.0
    angle_offset_deg: float = 0.0
    fixed_mm: float = 0.0

    @property
    def shape(self) -> str:
        """The quantity that the angle gives."""
        return "displacement" if self.radius_mm else "length"

    @property
    def text(self) -> str:
        """The conversion in words."""
        turned = f"(angle + {self.angle_offset_deg:g}°)"
        if self.radius_mm:
            return f"force = torque/{self.radius_mm:g} mm, displacement = {self.radius_mm:g} mm · {turned}"
        a, b = f"{self.a_mm:g}", f"{self.b_mm:g}"
        span = f"√({a}² + {b}² − 2·{a}·{b} cos {turned}) mm"
        fixed = f" − {self.fixed_mm:g} mm" if self.fixed_mm else ""
        return f"length = span{fixed}, span = {span}, force = torque · span/({a}·{b} sin {turned})"

    def arm(self, angle: Array) -> Array:
        """Arm in mm of the pull about the axis at angles in radians, both (n,): the span's slope over the angle."""
        if self.radius_mm:
            return np.full(len(angle), self.radius_mm)
        apart = angle + math.radians(self.angle_offset_deg)
        return self.a_mm * self.b_mm * np.sin(apart) / np.maximum(self.span(angle), 1e-300)

    def span(self, angle: Array) -> Array:
        """Distance in mm of the two points at angles in radians, both (n,), or way over the pulley."""
        apart = angle + math.radians(self.angle_offset_deg)
        if self.radius_mm:
            return self.radius_mm * apart
        square = self.a_mm**2 + self.b_mm**2 - 2.0 * self.a_mm * self.b_mm * np.cos(apart)
        return np.sqrt(np.maximum(square, 0.0))

    def dead(self, angle: Array) -> Array:
        """Where the pull goes so nearly through the axis that a torque tells no force, mask (n,)."""
        return np.abs(self.arm(angle)) < LEAST_ARM * (self.radius_mm or min(self.a_mm, self.b_mm))

    def converted(self, torque: Array, angle: Array) -> dict[str, Array]:
        """Force in N and shape in mm, (n,) each, of torques in N·mm and angles in radians."""
        return {"force": torque / self.arm(angle), self.shape: self.span(angle) - self.fixed_mm}


@dataclass(frozen=True)
class LeverColumns:
    """[lever] of a columns.toml: the lever, and for `torque` and `angle` the key with its unit and its entry."""

    path: str
    lever: JointLever
    entries: Mapping[str, tuple[str, Mapping[str, Any]]]

    @property
    def names(self) -> list[str]:
        """The headers that it names."""
        return [entry["column"] for _, entry in self.entries.values() if isinstance(entry["column"], str)]

    def sources(self, headers: Sequence[str], position: Callable[[str, str | int], int]) -> dict[str, Source]:
        """Torque and angle, and what is made of them; `position` finds the column of a key. Raises DataError for a
        header of another unit."""
        found = {}
        for what, (key, entry) in self.entries.items():
            at, unit = position(key, entry["column"]), key.partition("_")[2]
            given = split_header(headers[at])[1]
            if given in UNITS[what] and given != unit and "factor" not in entry:
                raise DataError(f"{self.path}: {key}, but the column's header is {headers[at]!r}; fix the unit")
            factor = UNITS[what][unit]
            scale = factor * entry.get("factor", 1.0), factor * entry.get("offset", 0.0)
            found[what] = Source(headers[at] or f"column {at + 1}", at, *scale)
        told = f"{found['torque'].header} and {found['angle'].header} by [lever]"
        made = dict.fromkeys(("force", self.lever.shape), Source(told, None, lever=self.lever))
        return {**found, **made}


def joint_of(headers: Sequence[str]) -> dict[str, int]:
    """Key of [lever] → position of the one column whose header has its unit; empty unless there are both."""
    units = [strange_unit(header) or header.rpartition("_")[2] for header in headers]
    found = {f"{what}_{unit}": units.index(unit) for what in UNITS for unit in UNITS[what] if units.count(unit) == 1}
    return found if len(found) == len(UNITS) == len({key.partition("_")[0] for key in found}) else {}


def lever_of(names: Sequence[str], joint: Mapping[str, int]) -> str:
    """What a columns.toml says of a `joint`, on a line, the radius of its pulley left open."""
    return f'lever = {{{", ".join(f"{key} = {column_of(names, k)}" for key, k in joint.items())}, radius_mm = "?"}}'


def read_lever(path: str, table: object, entry: Callable[[str, object], dict[str, Any]]) -> LeverColumns | None:
    """[lever] of the columns.toml at `path`, None where there is none; `entry` reads a column's. Raises DataError for
    what it cannot mean."""
    if table is None:
        return None
    expected = (
        f"{path}: [lever] expected torque_Nm and angle_deg with their columns, and radius_mm, or a_mm and b_mm; "
        "perhaps angle_offset_deg, and fixed_mm between two points"
    )
    if not isinstance(table, dict):
        raise DataError(expected)
    entries: dict[str, tuple[str, Mapping[str, Any]]] = {}
    sizes: dict[str, float] = {}
    for key, value in table.items():
        what, _, unit = key.partition("_")
        if key in SIZES and isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e6:
            sizes[key] = float(value)
        elif unit in UNITS.get(what, ()) and what not in entries and "column" in (given := entry(key, value)):
            entries[what] = key, given
        else:
            raise DataError(f"{expected}; not {key} = {value!r}")
    points = {"a_mm", "b_mm"} <= set(sizes) and "radius_mm" not in sizes
    pulley = "radius_mm" in sizes and not {"a_mm", "b_mm", "fixed_mm"} & set(sizes)
    if set(entries) != set(UNITS) or not (points or pulley):
        raise DataError(expected)
    if min(sizes.get(key, 1.0) for key in ("radius_mm", "a_mm", "b_mm")) <= 0.0:
        raise DataError(f"{path}: [lever] has a distance that is not above 0 mm; a column's factor of -1 turns a sign")
    return LeverColumns(path, JointLever(**sizes), entries)
