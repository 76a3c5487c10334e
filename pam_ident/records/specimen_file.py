"""specimen.toml: the muscle's geometry at rest, and the errors of the sensors where they are known."""

import json
from dataclasses import asdict, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ..core import DataError, Sensors, Specimen
from ..core.files import read_toml
from ..core.nearest import nearest
from .kind import check_kind

ALIKE = 0.9
"""Likeness of a key that is not known to one that is, from which it is a slip: others may hold what a user notes."""


def read_specimen(path: str | Path, record: Path | None = None) -> Specimen:
    """Read the table [specimen] of a TOML file. Raises DataError for missing keys or values out of range."""
    path = Path(path)
    content = _content(path, record)
    table = content.get("specimen")
    if not isinstance(table, dict):
        raise DataError(
            f"{path}: no table [specimen]; expected name, initial_length_mm, initial_radius_mm, braid_angle_deg"
        )
    known = [item.name for item in fields(Specimen) if item.name != "sensors"]
    strange = [key for key in table if key not in known]
    if slips := [(key, one) for key in strange for one in get_close_matches(key, known, 1, ALIKE) if one not in table]:
        raise DataError(f"{path}: [specimen] {slips[0][0]} is no key of it; did you mean {slips[0][1]}?")
    given: dict[str, Any] = {}
    lacking = []
    for item in fields(Specimen):
        if item.name == "name" and item.name in table:
            given["name"] = str(table["name"])
        elif item.name in table and item.name != "sensors":
            given[item.name] = _toml_number(path, "specimen", item.name, table[item.name])
        elif item.name not in ("wall_thickness_mm", "sensors"):
            beside = [key for key in strange if item.name in nearest(key, [item.name])]
            lacking.append(f"{item.name} ({' and '.join(beside)} is not it)" if beside else item.name)
    if lacking:
        raise DataError(f"{path}: [specimen] lacks {', '.join(lacking)}; add {'it' if len(lacking) == 1 else 'them'}")
    try:
        return Specimen(**given, sensors=_read_sensors(path, content.get("sensors")))
    except DataError as error:
        raise DataError(f"{path}: {error}") from None


def specimen_toml(specimen: Specimen, kind: str = "") -> str:
    """The text of a specimen file, with the kind of test where one was said; `read_specimen` reads the same back."""
    given = {item.name: getattr(specimen, item.name) for item in fields(Specimen) if item.name != "sensors"}
    sensors = [] if specimen.sensors is None else ["", "[sensors]", *_lines(asdict(specimen.sensors))]
    lines = [*_lines({"kind": kind or None}), "[specimen]", *_lines(given), *sensors]
    return "\n".join([*lines, ""])


def _lines(table: dict[str, Any]) -> list[str]:
    """Keys and values as TOML; a string of JSON is one of TOML."""
    return [f"{key} = {json.dumps(value, ensure_ascii=True)}" for key, value in table.items() if value is not None]


def read_kind(path: str | Path) -> str:
    """The kind of test that a specimen file says, `kind` at its top or in [specimen]; empty where it says none.

    Raises DataError for another word.
    """
    content = _content(Path(path))
    table = content.get("specimen")
    return check_kind(content.get("kind", table.get("kind") if isinstance(table, dict) else None), str(path))


def _content(path: Path, record: Path | None = None) -> dict[str, Any]:
    there = f" beside {record}" if record and path.name == "specimen.toml" else ""
    absent = (
        f"no specimen file{there}; write one with a table [specimen] (name, initial_length_mm, initial_radius_mm, "
        "braid_angle_deg) or pass --specimen FILE"
    )
    return read_toml(path, absent)


def _read_sensors(path: Path, table: object) -> Sensors | None:
    """The optional table [sensors]."""
    if table is None:
        return None
    names = [item.name for item in fields(Sensors)]
    if not isinstance(table, dict) or "force_N" not in table or not set(table) <= set(names):
        raise DataError(f"{path}: [sensors] needs force_N and may hold {', '.join(names[1:])}, standard deviations")
    return Sensors(**{name: _toml_number(path, "sensors", name, value) for name, value in table.items()})


def _toml_number(path: Path, table: str, name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{path}: [{table}] {name} = {value!r}; expected a number")
    return float(value)
