"""What a record is made of, and which column holds it."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..core import DataError
from ..core.units import TO_INTERNAL, conversion, is_absolute, split_header
from .table import Table

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
Finder = Callable[[Table], "dict[str, Source]"]
"""Finds the columns of a table without a columns.toml. Raises DataError."""
_LETTER = re.compile(r"[^\W\d_]")
_CLOCK = re.compile(r"[hms:.,0fdyYMDHTZ \-]*:[hms:.,0fzTZ ]*", re.IGNORECASE)
"""What stands for a unit above clock times: `hh:mm:ss.000`, `YYYY-MM-DD hh:mm:ss`."""
BRANCHES = {"contraction": 1.0, "extension": -1.0}


@dataclass(frozen=True)
class Source:
    """Where a quantity is from: the column at `position`, or `value` for all rows where that is None.

    internal = factor · cell + offset; `words` are the branches' names in lower case with their signs. `absolute`
    pressure has the air's in its offset. A column of time whose `unit_missing` can hold clock times only. By a `lever`
    the values are made of the torque and the angle.
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


def quantity_of(header: str) -> str | None:
    """The quantity that a header names, None for any other header."""
    if not _LETTER.search(header):
        return None
    name, _ = split_header(header)
    return name if name in QUANTITIES else None


def scale_of(quantity: str, unit: str | None, where: str) -> tuple[float, float]:
    """Factor and offset to the internal unit; `where` names the column. Raises DataError for an unknown unit."""
    dimension = QUANTITIES[quantity]
    return (1.0, 0.0) if dimension == "text" else conversion(dimension, unit, where)


def find_sources(table: Table, constants: Mapping[str, Source] | None = None) -> dict[str, Source]:
    """The columns of a table by name and unit, and the `constants` of its run. Raises DataError where one is missing,
    doubled, or of unknown unit."""
    found: dict[str, int] = {}
    for position, header in enumerate(table.headers):
        name = quantity_of(header)
        if name is None:
            continue
        if name in found:
            first = table.headers[found[name]]
            if first == header:
                raise DataError(f"{table.head}: two columns are called {header!r}; keep one")
            raise DataError(f"{table.place}: columns {first!r} and {header!r} are both {name}; keep one")
        found[name] = position
    _refuse_unknown_units(table, found)
    constants = constants or {}
    check_complete([*found, *constants], table.head, table.headers)
    sources: dict[str, Source] = {}
    for name, position in found.items():
        header = table.headers[position]
        unit = split_header(header)[1]
        if name == "time" and (unit is None or _CLOCK.fullmatch(unit)):
            sources[name] = Source(header, position, unit_missing=True)
            continue
        scale = scale_of(name, unit, f"{table.place}, column {header!r}")
        sources[name] = Source(header, position, *scale, absolute=is_absolute(unit))
    for name, source in constants.items():
        if name in sources:
            raise DataError(f"{table.head}: {name} is a column, and {source.header}; keep one")
    return check_shape(sources | dict(constants), table.head)


def find_states(table: Table) -> dict[str, Source]:
    """The same of a table of states, which need no force, or no shape where a force is what is carried. What is not
    there is 0, by a source without a header; of loads the motion is not known, and no time is taken."""
    given = {quantity_of(header) for header in table.headers}
    lacking = Source("", None)
    if "force" not in given:
        return find_sources(table, {"force": lacking})
    if given & {*SHAPES}:
        return find_sources(table)
    found = find_sources(table, {"contraction": lacking})
    return {name: one for name, one in found.items() if name not in ("time", "cycle", "pressure_set")}


def check_shape(sources: dict[str, Source], head: str) -> dict[str, Source]:
    """The sources. Raises DataError where pressure, force or shape is missing, or the shape is there twice."""
    check_complete(sources, head, [source.header for source in sources.values()])
    shapes = [sources[key].header for key in SHAPES if key in sources]
    if len(shapes) > 1:
        raise DataError(f"{head}: columns {' and '.join(shapes)} say the same thing; keep one")
    return sources


def _refuse_unknown_units(table: Table, found: dict[str, int]) -> None:
    """A name with a suffix that is no unit is a slip where nothing else gives the quantity."""
    for header in table.headers:
        name, _, unit = split_header(header)[0].rpartition("_")
        if name in QUANTITIES and name not in found and quantity_of(header) is None:
            raise DataError(
                f"{table.head}, column {header!r}: unknown unit {unit!r} for {name}; expected one of "
                f"{', '.join(TO_INTERNAL.get(QUANTITIES[name], ()))}, or another name if it is something else"
            )


def check_complete(found: Sequence[str] | Mapping[str, object], head: str, headers: Sequence[str]) -> None:
    """Raise DataError where pressure, force or the muscle's shape is missing."""
    there = f"among {', '.join(map(repr, headers))[:300]}"
    cure = "or say in a columns.toml beside the file which it is"
    for need, name in (("pressure", "pressure_MPa"), ("force", "force_N")):
        if need not in found:
            raise DataError(f"{head}: no {need} column {there}; name it {name} (or with another unit), {cure}")
    if not any(key in found for key in SHAPES):
        raise DataError(
            f"{head}: no displacement_mm, contraction, contraction_pct or length_mm column {there}; "
            f"name one of them so, {cure}"
        )
