"""leg.toml: every number of the leg in tables of keys, its own or those of a user's file over them."""

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..core import DataError
from ..core.nearest import unknown
from ..records.datasets import dataset_path

Tables = Mapping[str, Mapping[str, Any]]
"""Numbers, pairs of numbers and words by table and key."""
DEFAULT_FILE = "leg.toml"
WORDS = {"muscles": ("plant", "controller"), "off": ("unknown",)}
"""Keys that hold a word; in the leg's own file those of the muscles stand as comments."""
REACH_M = 0.2
"""How far a pivot may lie from the knee's origin along each axis."""
SPAN = 100.0
"""So many times a number of the leg's own another leg may have: a unit's slip is a thousand."""
RANGES = {
    ("muscles", "rest_contraction"): (-0.05, 0.4),
    ("muscles", "dead_volume_m3"): (0.0, 1e-3),
    ("valve", "critical_ratio"): (0.0, 0.9),
    ("valve", "lag_s"): (0.001, 0.5),
    ("load", "mass_kg"): (0.0, 100.0),
    ("load", "torque_N_m"): (-200.0, 200.0),
    ("knee", "stops_deg"): (-10.0, 85.0),
    ("knee", "damping_N_m_s"): (0.0, 50.0),
    ("ground", "below_hip_m"): (0.3, 2.0),
    ("ground", "damping_s_m"): (0.0, 10.0),
    ("ground", "friction"): (0.0, 5.0),
    ("supply", "temperature_K"): (200.0, 400.0),
    ("supply", "pressure_MPa"): (0.1, 2.0),
    ("off", "force"): (0.2, 5.0),
    ("off", "mass"): (0.2, 5.0),
    ("off", "supply"): (0.2, 5.0),
    ("off", "ageing"): (0.0, 0.5),
}
"""Least and largest value where it is not SPAN around the leg's own."""


def _content(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise DataError(
            f"{path}: not a readable TOML file ({error}); `pam-ident track --write-leg FILE` writes one"
        ) from None


def default_file() -> Path:
    """The leg of the examples, each number with its source."""
    return dataset_path("leg_muscle") / DEFAULT_FILE


DEFAULT: Tables = _content(default_file())


def read_leg(path: str | Path) -> Tables:
    """The leg's own tables with those of a user's file over them; paths of muscles are told from where the file lies.

    Raises DataError naming file, table and key for what is unknown, of another kind or impossible.
    """
    path = Path(path)
    given = _content(path)
    for name, table in given.items():
        if name not in DEFAULT or not isinstance(table, dict):
            raise DataError(f"{path}: {unknown('table', name, DEFAULT, '`pam-ident track --write-leg FILE`')}")
        for key, value in table.items():
            _check(path, name, key, value)
    for key in set(WORDS["muscles"]) & set(given.get("muscles", {})):
        given["muscles"][key] = str(path.parent / given["muscles"][key])
    tables = {name: {**own, **given.get(name, {})} for name, own in DEFAULT.items()}
    muscles = tables["muscles"]
    if not muscles["lowest_MPa"] < muscles["mean_MPa"] < muscles["highest_MPa"]:
        raise DataError(f"{path}: [muscles] mean_MPa must lie between lowest_MPa and highest_MPa")
    if not tables["knee"]["stops_deg"][0] < tables["knee"]["stops_deg"][1]:
        raise DataError(f"{path}: [knee] stops_deg must rise")
    return tables


def _check(path: Path, table: str, key: str, value: object) -> None:
    """Raises DataError where a key is unknown or its value cannot be."""
    words = WORDS.get(table, ())
    known = (*DEFAULT[table], *words)
    if key not in known:
        raise DataError(f"{path}: {unknown(f'key of [{table}]', key, known, '`pam-ident track --write-leg FILE`')}")
    if key in words:
        if not isinstance(value, str):
            raise DataError(f"{path}: [{table}] {key} = {value!r}; expected a name in quotes")
        return
    own = DEFAULT[table][key]
    around = (-REACH_M, REACH_M) if isinstance(own, list) else (own / SPAN, own * SPAN)
    low, high = RANGES.get((table, key), around)
    numbers: list[Any] = value if isinstance(value, list) else [value]
    shaped = isinstance(value, list) == isinstance(own, list) and (not isinstance(own, list) or len(numbers) == 2)
    typed = all(isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x) for x in numbers)
    if not (shaped and typed and all(low <= x <= high for x in numbers)):
        kind = "a pair of numbers, each" if isinstance(own, list) else "a number"
        raise DataError(f"{path}: [{table}] {key} = {value!r}; expected {kind} from {low:g} to {high:g}")
