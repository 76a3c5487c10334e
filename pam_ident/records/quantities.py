"""What a record is made of, and where it is from."""

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..core.units import conversion, known_scale, split_header

if TYPE_CHECKING:
    from .joint_lever import JointLever

QUANTITIES = {
    "time": "time",
    "pressure": "pressure",
    "pressure_set": "pressure",
    "displacement": "length",
    "contraction": "ratio",
    "length": "length",
    "force": "force",
    "temperature": "temperature",
    "cycle": "ratio",
    "branch": "text",
    "slack": "ratio",
}
"""Quantity → dimension of its unit."""
SHAPES = ("displacement", "contraction", "length")
_LETTER = re.compile(r"[^\W\d_]")
BRANCHES = {"contraction": 1.0, "extension": -1.0}


@dataclass(frozen=True)
class Source:
    """Where a quantity is from: the column at `position`, or `value` for all rows where that is None.

    internal = factor · cell + offset; `words` are the branches' names in lower case with their signs. `absolute`
    pressure has the air's in its offset. A column of time whose `unit_missing` can hold clock times only. By a `lever`
    the values are made of the torque and the angle. A `guessed` one was found by word and unit, not by its name.
    """

    header: str
    position: int | None
    factor: float = 1.0
    offset: float = 0.0
    value: float = 0.0
    words: tuple[tuple[str, float], ...] = tuple(BRANCHES.items())
    absolute: bool = False
    unit_missing: bool = False
    lever: "JointLever | None" = None
    guessed: bool = False


def quantity_of(header: str) -> str | None:
    """The quantity that a header names, None for any other header."""
    if not _LETTER.search(header):
        return None
    name, unit = split_header(header)
    if name == "contraction" and known_scale("length", unit):  # a way that the muscle shortens by
        return "displacement"
    return name if name in QUANTITIES else None


def scale_of(quantity: str, unit: str | None, where: str) -> tuple[float, float]:
    """Factor and offset to the internal unit; `where` names the column. Raises DataError for an unknown unit."""
    dimension = QUANTITIES[quantity]
    return (1.0, 0.0) if dimension == "text" else conversion(dimension, unit, where)
