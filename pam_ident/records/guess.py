"""Which column of a foreign table is what: guessed from its name, its unit and its numbers, for a person to correct."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np

from ..core import Array
from ..core.units import TO_INTERNAL, known_scale, split_header, strange_unit
from .quantities import QUANTITIES, SHAPES
from .ranges import Values
from .table import Table, number_of
from .turning import pivots

WORDS = {
    "pressure_set": r"soll\w*|set|setpoint|target|command\w*|cmd|consigne",
    "temperature": r"temp|temp[eé]ratur\w*",
    "contraction": r"contraction|kontraktion|shortening|verkürzung|eps|epsilon|strain",
    "force": r"force|kraft|\w+kraft|load\w*|f|fz|fx|fuerza|forza|effort|pull|tension",
    "pressure": r"press\w*|druck|\w+druck|p|pres[ií]on\w*|pression\w*|air",
    "displacement": r"disp\w*|weg|\w+weg|stroke|hub|travel|pos\w*|way|lvdt|desplazamiento|d[ée]placement|course|x|s",
    "length": r"length|\w*l[äa]nge|\w*laenge|longueur|longitud|l",
    "cycle": r"cycle\w*|zyklus|zyklen|loop",
    "time": r"t|time\w*|zeit\w*|uhrzeit|temps|tiempo|tempo|clock|sec|seconds?",
}
"""Words of a header that name a quantity, the narrower first."""
ABSOLUTE = tuple(f"{unit}_abs" for unit in TO_INTERNAL["pressure"])
SYNONYMS = "degC", "sec", "kg"
ROWS, FIRST = 400, 2000
"""Rows that are looked at to tell columns apart by their numbers, and the first ones that they are taken from."""
MANY = 100
"""Rows from which a record may be a log."""
JUMP, FEW = 0.1, 0.05
"""Share of a range that a smooth track does not go in a step, and share of the steps that do, to another isobar."""
BACK, SPAN = 0.25, 0.05
"""Share of a range that a track turns back by, and least range beside the largest value of a track that is driven."""
SEVERAL = 3
"""Ways back that no table has whose rows are sorted; where a clock is seen, or branches are said, see `is_log`."""


@dataclass(frozen=True)
class Guess:
    """What a column may hold, and in which unit, both empty for nothing; `sure` where its name says so. Its `factor`
    is -1 where the numbers count the other way, as an extension does."""

    quantity: str = ""
    unit: str = ""
    sure: bool = False
    factor: int = 1

    @property
    def key(self) -> str:
        """Its key in a columns.toml."""
        return self.quantity + (f"_{self.unit}" if self.unit not in ("", "1") else "")


def units_of(quantity: str) -> tuple[str, ...]:
    """The units that a quantity may be given in; none for words and counts."""
    dimension = QUANTITIES.get(quantity, "text")
    if quantity in ("cycle", "slack") or dimension == "text":
        return ()
    if dimension == "ratio":
        return ("1", "pct")
    more = ABSOLUTE if dimension == "pressure" else ()
    return (*(unit for unit in TO_INTERNAL[dimension] if unit not in SYNONYMS), *more)


def guess_columns(headers: Sequence[str], columns: Sequence[Array]) -> tuple[Guess, ...]:
    """A guess for each column.

    Args:
        headers: the columns' names, with their units where they have any.
        columns: their first numbers, shape (n,) each, NaN where a cell holds none.

    What the names leave open is told by the numbers: a time grows without end; of pressure, length and force the
    assignment is taken under which a force in proportion to pressure that falls along the way explains most.
    """
    found = [by_name(header, lengths=True) for header in headers]
    for k, quantity in enumerate(found):
        if quantity and quantity in found[:k]:
            found[k] = ""
    named = set(filter(None, found))
    values = [np.asarray(column, float) for column in columns]
    free = [k for k, name in enumerate(found) if not name and _varies(values[k])]
    stated = [stated_by(header) for header in headers]
    if "time" not in named:
        clock = next((k for k in free if stated[k] in ("", "time") and rises(values[k])), None)
        if clock is not None:
            found[clock] = "time"
            free.remove(clock)
    free = [k for k in free if not np.all(np.diff(values[k]) == 1.0)]  # a count of the rows
    needed = [name for name in ("pressure", "force") if name not in named]
    needed += ["displacement"] * (not named & set(SHAPES))
    for k, quantity in _by_numbers(needed, free, found, values, stated):
        found[k] = quantity
    return tuple(
        Guess(name, _unit(name, header, column), name in named, _sign(name, column)) if name else Guess()
        for name, header, column in zip(found, headers, values, strict=True)
    )


def guess_table(table: Table) -> tuple[Guess, ...]:
    """A guess for each column of a table, by its first rows."""
    return guess_columns(table.headers, numbers_of(table, range(len(table.names))))


def numbers_of(table: Table, positions: Sequence[int]) -> list[Array]:
    """The first numbers of some of a table's columns, (n,) each, NaN where a cell holds none."""
    block = next(iter(table.read(positions)), None)
    cells = [[] if block is None else block.cells[k][:FIRST] for k in positions]
    return [np.array([number_of(cell, table.decimal) for cell in column]) for column in cells]


def rises(column: Array) -> bool:
    """Whether a column (n,) grows without end, as a clock does."""
    return _varies(column) and bool(np.all(np.diff(column) > 0))


def told_by(names: Sequence[str], headers: Sequence[str], k: int, guess: Guess) -> str:
    """What a columns.toml says of column k, as it is guessed; of a unit that nobody knows the factor is left open."""
    column, factor = column_of(names, k), '"?"' if strange_unit(headers[k]) and guess.unit else guess.factor
    return f"{guess.key} = {column if factor == 1 else f'{{column = {column}, factor = {factor}}}'}"


def column_of(names: Sequence[str], k: int) -> str:
    """Column k as a columns.toml names it: by its number where its name is no other's, or the reader's own."""
    plain = names[k] and names.count(names[k]) == 1 and not names[k].startswith("column ")
    return json.dumps(names[k], ensure_ascii=False) if plain else str(k + 1)


def by_name(header: str, lengths: bool = False) -> str:
    """The quantity that a header's words, and its unit, say; empty where they say none, or not the same.

    A unit alone says pressure, force or time; that of a length, if `lengths`, a displacement.
    """
    name, unit = split_header(header, loose=True)
    if name in QUANTITIES:
        return name
    base = re.split(r"[\[(]", header)[0]
    base = base.strip().removesuffix(unit) if unit and base == header else base
    spaced = re.sub(r"([a-zäöü])([A-ZÄÖÜ])", r"\1 \2", base)
    words = re.findall(r"[^\W\d_]+", spaced.lower())
    hits = [q for q, pattern in WORDS.items() if any(re.fullmatch(pattern, word) for word in words)]
    stated = stated_by(header, loose=bool(hits))
    if "pressure_set" in hits:  # what is commanded was not measured: of other quantities it is of no use
        return "pressure_set" if stated == "pressure" or (not stated and hits[1:] == ["pressure"]) else ""
    if "contraction" in hits and stated == "length":  # a way that the muscle shortens by
        return "displacement"
    if hits == ["time"] and stated == "temperature":  # `T [K]`
        return "temperature"
    if hits:
        return next((q for q in hits if stated in ("", QUANTITIES[q])), "")
    if lengths and stated == "length":
        return "displacement"
    return stated if stated in ("pressure", "force", "time") else ""


def stated_by(header: str, loose: bool = False) -> str:
    """The dimension of the unit that a header states, empty for none that is known."""
    unit = split_header(header, loose)[1]
    return next((dimension for dimension in TO_INTERNAL if known_scale(dimension, unit)), "")


def _varies(column: Array) -> bool:
    return len(column) > 1 and bool(np.isfinite(column).all()) and float(np.ptp(column)) > 0.0


def _by_numbers(
    needed: list[str], free: list[int], found: list[str], values: list[Array], stated: list[str]
) -> list[tuple[int, str]]:
    """Which of the free columns are what is needed still; none is whose unit is `stated` to be of something else."""
    if not needed or len(free) < len(needed) or len(free) > 8:
        return []
    known = {("displacement" if name in SHAPES else name): k for k, name in enumerate(found) if name}
    few = [column[:: max(len(column) // ROWS, 1)] for column in values]
    best: tuple[float, tuple[int, ...]] = (-np.inf, ())
    for chosen in permutations(free, len(needed)):
        if any(stated[k] not in ("", QUANTITIES[name]) for k, name in zip(chosen, needed, strict=True)):
            continue
        roles = known | dict(zip(needed, chosen, strict=True))
        pick = {name: few[roles[name]] for name in ("pressure", "displacement", "force")}
        best = max(best, (_explained(**pick), chosen))
    return list(zip(best[1], needed, strict=True)) if best[1] else []


def _explained(pressure: Array, displacement: Array, force: Array) -> float:
    """Share of a force's variance that pressure times a falling line explains; none where it rises along the way."""
    columns = np.column_stack([pressure, -pressure * displacement, np.ones(len(pressure))])
    if not np.isfinite(columns).all() or not np.isfinite(force).all():
        return -np.inf
    sizes = np.linalg.lstsq(columns, force, rcond=None)[0]
    left = float(np.var(force - columns @ sizes) / max(np.var(force), 1e-300))
    return -left if sizes[0] > 0 and sizes[1] > 0 else -1.0 - left


def _unit(quantity: str, header: str, column: Array) -> str:
    """The unit that the header states, else the one in which the numbers are of a muscle's size."""
    dimension = QUANTITIES[quantity]
    if not units_of(quantity):
        return ""
    stated = split_header(header, loose=True)[1]
    if stated:
        flat = re.sub(r"[ ()]+", "_", stated).strip("_")
        same = [unit for unit in units_of(quantity) if flat.lower() in (unit.lower(), {"pct": "%"}.get(unit, ""))]
        if same:
            return flat if flat in same else same[0]
    finite = np.abs(column[np.isfinite(column)])
    largest = float(finite.max()) if len(finite) else 0.0
    if quantity == "time":
        step = float(np.median(np.diff(column))) if len(column) > 1 else 0.0
        return "ms" if step >= 1.0 and largest > 1000.0 else "s"
    if dimension == "pressure":
        sizes = (("MPa", 1.2), ("bar", 12.0), ("psi", 120.0), ("kPa", 1200.0), ("mbar", 12_000.0), ("Pa", np.inf))
        return next(unit for unit, most in sizes if largest <= most)
    if quantity == "force":
        return "kN" if largest < 5.0 else "N"
    if dimension == "length":
        return "m" if largest < (2.0 if quantity == "length" else 0.3) else "mm"
    if dimension == "temperature":
        return "K" if len(finite) and float(np.median(finite)) > 200.0 else "C"
    return "pct" if largest > 1.5 else "1"


def _sign(quantity: str, column: Array) -> int:
    """A contraction is positive, so that most of one which is not is an extension."""
    return -1 if quantity in ("displacement", "contraction") and np.nansum(column) < 0.0 else 1


def likely_clock(table: Table, passed: tuple[int, ...]) -> str:
    """The header of the column among those `passed` over that looks like a clock: its name says so, or its numbers rise
    throughout, and do not merely count the rows; empty for none."""
    columns = dict(zip(passed, numbers_of(table, passed), strict=True)) if passed else {}
    rising = [k for k, column in columns.items() if rises(column) and not np.all(np.diff(column) == 1.0)]
    named = [k for k in rising if by_name(table.headers[k]) == "time"]
    return table.headers[(named or rising)[0]] if rising else ""


def is_log(values: Values, contraction: Array, clock: str) -> bool:
    """Whether the rows of a record without a time look like a log: its `contraction` (n,) or pressure goes smoothly
    back and forth, several times, or at all beside what looks like a `clock`. Where branches were said, a table of
    loops is meant unless there is a clock."""
    if len(contraction) < MANY or ("branch" in values and not clock):
        return False
    back = max(_ways_back(contraction), _ways_back(values["pressure"]))
    return back >= (1 if clock else SEVERAL)


def _ways_back(track: Array) -> int:
    """How often a smooth track (n,) turns back; what a jump begins anew is no turn."""
    span, steps = float(np.ptp(track)), np.abs(np.diff(track))
    jumps = np.flatnonzero(steps > JUMP * span) + 1
    if not span > SPAN * np.abs(track).max() or len(jumps) > FEW * len(steps):
        return 0
    pieces = [track[begin:end] for begin, end in pairwise([0, *jumps.tolist(), len(track)])]
    return sum(max(len(pivots(piece, BACK * span)) - 2, 0) for piece in pieces)
