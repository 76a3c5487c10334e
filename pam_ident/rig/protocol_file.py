"""Protocols as TOML files: a table [protocol] with the keys of KEYS."""

from pathlib import Path
from typing import Any

from ..core import UsageError
from ..core.files import read_toml
from .protocol import Protocol

KEYS = {
    "pressures_MPa": "a list of gauge pressures above 0",
    "speeds_mm_s": "a list of speeds above 0",
    "cycles_per_speed": "a count",
    "stroke_mm": "[from, to] in mm of contraction; a stroke also ends at zero force",
    "hold_s": "seconds at each end, or a list of holds that follow in turn",
    "move_rows": "a count of rows in each move",
    "hold_rows": "a count of rows in each hold, or one for each of hold_s",
    "minor_loops_mm": "a list of sizes above 0",
    "warming_K": "kelvin that the muscle is warmed by until the middle of the run",
    "gap_s": "seconds between pressures",
}
NEEDED = ("pressures_MPa", "speeds_mm_s")
COUNTS = ("cycles_per_speed", "move_rows", "hold_rows")
LISTS = ("pressures_MPa", "speeds_mm_s", "minor_loops_mm", "stroke_mm")
LISTS_TOO = ("hold_s", "hold_rows")


def read_protocol(path: str | Path) -> Protocol:
    """The protocol of a TOML file. Without hold_s there are no holds.

    Raises UsageError naming file and key, with what was expected there.
    """
    path = Path(path)
    absent = "no such file; `pam-ident diagnose RECORD --protocol FILE.toml` writes one"
    table = read_toml(path, absent, UsageError).get("protocol")
    if not isinstance(table, dict):
        raise UsageError(f"{path}: no table [protocol]; expected one with {', '.join(NEEDED)}")
    for key in NEEDED:
        if key not in table:
            raise UsageError(f"{path}: [protocol] lacks {key}; expected {KEYS[key]}")
    given = {key: _value(path, key, value) for key, value in table.items()}
    if "hold_s" not in given or given["hold_s"] == 0:
        given |= {"hold_s": 0.0, "hold_rows": 0}
    try:
        return Protocol(**given)
    except ValueError as error:
        raise UsageError(f"{path}: {error}") from None


def _value(path: Path, key: str, value: object) -> Any:
    if key not in KEYS:
        raise UsageError(f"{path}: [protocol] {key} is not known; expected {', '.join(KEYS)}")
    kinds = int if key in COUNTS else (int, float)
    numbers: list[Any] = value if isinstance(value, list) else [value]
    typed = all(isinstance(x, kinds) and not isinstance(x, bool) for x in numbers)
    listed = isinstance(value, list)
    shaped = listed if key in LISTS else not listed or key in LISTS_TOO
    counted = len(numbers) == 2 if key == "stroke_mm" else bool(numbers) or key == "minor_loops_mm"
    if not (typed and shaped and counted):
        raise UsageError(f"{path}: [protocol] {key} = {value!r}; expected {KEYS[key]}")
    exact = [x if key in COUNTS else float(x) for x in numbers]
    return tuple(exact) if listed else exact[0]
