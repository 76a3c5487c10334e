"""columns.toml: which column of a foreign file is what, for anything that names and units do not tell."""

from collections.abc import Mapping as Dict
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..core import DataError
from ..core.files import read_toml
from ..core.units import TO_INTERNAL, is_absolute, known_scale, split_header, strange_unit
from .joint_lever import LeverColumns, read_lever
from .kind import check_kind
from .quantities import BRANCHES, QUANTITIES, SHAPES, Source, quantity_of, scale_of
from .run_constants import Runs, read_runs
from .sources import check_complete, check_shape, find_sources
from .table import Table

LAYOUT = {"delimiter": str, "decimal": str, "encoding": str, "header_row": int, "part": str}
ENTRY = {"column", "value", "factor", "offset"}


@dataclass(frozen=True)
class Mapping:
    """What a columns.toml says: `columns` maps a quantity with its unit (`force_N`) to an entry (empty: columns are
    found by name), `layout` is the optional table [file]: delimiter, decimal, encoding, header_row (0 for none), part
    (a sheet or group); `runs` what differs from file to file; `kind` the kind of test, empty where it is not said;
    `lever` what makes force and shape of torque and angle, if anything does."""

    path: str
    columns: Dict[str, Dict[str, Any]]
    layout: Dict[str, Any]
    runs: Runs
    kind: str = ""
    lever: LeverColumns | None = None

    @property
    def for_all(self) -> dict[str, str]:
        """Quantity → value and unit of the constants of all runs, as written."""
        return {split_header(k)[0]: f"{k} = {e['value']:g}" for k, e in self.columns.items() if "value" in e}

    def known(self, header: str) -> str | None:
        """The header itself where a column is given by it; all quantities are known where columns are numbered."""
        names = [entry["column"] for entry in self.columns.values() if isinstance(entry.get("column"), str)]
        more = self.lever.names if self.lever else []
        return header if header in (*names, *more) else quantity_of(header) if not names else None

    @property
    def enough(self) -> int:
        """How many names the header must hold to be taken for it."""
        names = {entry["column"] for entry in self.columns.values() if isinstance(entry.get("column"), str)}
        return len(names.union(self.lever.names if self.lever else ())) if names else 2

    def sources(self, table: Table, run: str = "") -> dict[str, Source]:
        """The columns that are named here, no others, and the constants of the file `run`. Raises DataError where
        one is not in the table."""
        by_lever = self.lever.sources(table.headers, partial(self._position, table)) if self.lever else {}
        if not self.columns:
            has_force = bool(by_lever) or any(quantity_of(h) == "force" for h in table.headers)
            return find_sources(table, self.runs.sources(run, has_force) | by_lever)
        found: dict[str, Source] = {}
        for key, entry in self.columns.items():
            name, unit = split_header(key)
            factor, offset = scale_of(name, unit, f"{self.path}, {key}")
            scale = (factor * entry.get("factor", 1.0), factor * entry.get("offset", 0.0) + offset)
            if "value" in entry:
                found[name] = Source(f"{entry['value']:g} by {self.path}", None, value=entry["value"] * factor + offset)
                continue
            position = self._position(table, key, entry["column"])
            self._check_unit(table.headers[position], key, name, (factor, offset), entry)
            words = tuple((str(entry.get(word, word)).strip().lower(), sign) for word, sign in BRANCHES.items())
            header = table.headers[position] if table.headers[position] else f"column {position + 1}"
            found[name] = Source(header, position, *scale, words=words, absolute=is_absolute(unit))
        if twice := [name for name in by_lever if name in found]:
            raise DataError(f"{self.path}: {twice[0]} is given by [columns] and by [lever]; keep one")
        found |= by_lever
        own = self.runs.sources(run, "force" in found)
        for name in own:
            if name in found and (found[name].position is not None or name in by_lever):
                raise DataError(f"{self.path}: {name} is a column and a constant of {run!r}; keep one")
        return check_shape(found | own, f"{self.path}: [columns]")

    def _check_unit(self, header: str, key: str, name: str, scale: tuple[float, float], entry: Dict[str, Any]) -> None:
        """Refuse a unit against the one that the file states, unless a factor or an offset says that it is meant."""
        unit = split_header(header)[1]
        known = known_scale(QUANTITIES[name], unit)
        strange = strange_unit(header) if QUANTITIES[name] in TO_INTERNAL else None
        if strange and "factor" not in entry:
            raise DataError(
                f"{self.path}: {key}, but the column's header is {header!r}, and {strange!r} is no unit that is known; "
                "give the factor to the unit of the key (1 if it is no unit)"
            )
        if known is None:
            return
        other = known[0] != scale[0] and "factor" not in entry
        if other or (known[1] != scale[1] and not {"factor", "offset"} & set(entry)):
            raise DataError(
                f"{self.path}: {key}, but the column's header is {header!r}, in {unit}; fix the unit, or give a factor"
            )

    def _position(self, table: Table, key: str, column: str | int) -> int:
        if isinstance(column, int):
            if 1 <= column <= len(table.headers):
                return column - 1
            raise DataError(
                f"{self.path}: {key} is column {column}, but {table.place} has {len(table.headers)} columns; fix one"
            )
        places = [k for k, pair in enumerate(zip(table.names, table.headers, strict=True)) if column in pair]
        if not places and not (plain := split_header(column))[1]:  # a header less its unit
            places = [k for k, header in enumerate(table.headers) if split_header(header)[0] == plain[0]]
        if len(places) == 1:
            return places[0]
        what = f"{len(places)} columns {column!r}; give its number instead" if places else f"no column {column!r}"
        raise DataError(f"{table.head}: {what} ({self.path}: {key}) among {', '.join(map(repr, table.names))[:300]}")


def read_mapping(path: str | Path) -> Mapping:
    """Read a columns.toml. Raises DataError for what it cannot mean."""
    content = read_toml(path)
    kind = check_kind(content.pop("kind", None), str(path))
    strange = set(content) - {"columns", "file", "runs", "lever"}
    lever = read_lever(str(path), content.get("lever"), lambda key, value: _entry(path, key, value, known=True))
    runs = read_runs(path, content.get("runs", {}))
    table, layout = content.get("columns", {}), content.get("file", {})
    empty = not (table or runs.constants or lever or layout or kind)
    if strange or not isinstance(table, dict) or empty or not isinstance(layout, dict):
        raise DataError(
            f"{path}: expected a table [columns], such as force_N = 'Load', and perhaps [file], [runs], [lever]"
        )
    for key, value in layout.items():
        if not isinstance(value, LAYOUT.get(key, ())) or isinstance(value, bool):
            raise DataError(f"{path}: [file] {key} = {value!r}; expected of {', '.join(LAYOUT)}, text or a row number")
    if layout.get("decimal", ".") not in (".", ",") or len(layout.get("delimiter", ";")) != 1:
        raise DataError(f"{path}: [file] expected a decimal mark of '.' or ',' and a delimiter of one character")
    columns = {key: _entry(path, key, value) for key, value in table.items()}
    quantities = [split_header(key)[0] for key in columns]
    if len(set(quantities)) < len(quantities):
        raise DataError(f"{path}: [columns] gives a quantity twice; keep one")
    if len(set(quantities) & set(SHAPES)) > 1:
        raise DataError(f"{path}: [columns] gives more than one of {', '.join(SHAPES)}; keep one")
    if columns and not runs.constants:
        made = ("force", lever.lever.shape) if lever else ()
        check_complete([*quantities, *made], f"{path}: [columns]", list(columns))
    return Mapping(str(path), columns, layout, runs, kind, lever)


def _entry(path: str | Path, key: str, value: object, known: bool = False) -> dict[str, Any]:
    if not known and quantity_of(key) is None:
        raise DataError(
            f"{path}: [columns] {key}: expected a quantity with its unit, such as force_N; known are "
            f"{', '.join(QUANTITIES)}"
        )
    entry = value if isinstance(value, dict) else {"column": value}
    numbers = [entry[k] for k in ("value", "factor", "offset") if k in entry]
    allowed = ENTRY | (set(BRANCHES) if split_header(key)[0] == "branch" else set())
    good = (
        set(entry) <= allowed
        and ("column" in entry) != ("value" in entry)
        and isinstance(entry.get("column", 1), str | int)
        and not isinstance(entry.get("column", 1), bool)
        and all(isinstance(x, int | float) and not isinstance(x, bool) for x in numbers)
    )
    if not good:
        raise DataError(
            f"{path}: [columns] {key} = {value!r}; expected a header, a column's number from 1, or a table of column "
            "(with factor and offset, if need be) or value"
        )
    return entry
