"""Where a table's header stands among its rows, and whether a row of units follows it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..core import DataError
from ..core.units import is_unit, split_header
from .table import count_numbers

Known = Callable[[str], str | None]
"""Header → the quantity it names, or None."""


@dataclass(frozen=True)
class Heading:
    """Indices of the header row (None where there is none) and of the first row of data; `score` of the names known.

    `units` are the cells of a row of units, empty where there is none.
    """

    header: int | None
    first: int
    score: int
    names: tuple[str, ...]
    units: tuple[str, ...] = ()

    def headers(self, place: str) -> tuple[str, ...]:
        """The names with the units of the row of units. Raises DataError where the two say different units."""
        found = []
        for name, cell in zip(self.names, [*self.units, *[""] * len(self.names)], strict=False):
            found.append(with_unit(name, plain_unit(cell), f"{place}, column {name!r}") if name else name)
        return tuple(found)


def with_unit(name: str, unit: str, place: str) -> str:
    """A header with the unit that stands beside it. Raises DataError where the header says another."""
    written = split_header(name)[1]
    beside = split_header(f"{name} [{unit}]")[1] or ""  # of a pressure that is named absolute, `bar abs`
    if written is not None and unit and same_unit(written) != same_unit(beside):
        raise DataError(f"{place}: the unit beside it is {unit!r}; fix one of them")
    return name if written is not None or not unit else f"{name} [{unit}]"


def same_unit(unit: str) -> str:
    """A unit without what may be written in several ways: degrees, blanks."""
    return unit.replace("°", "").replace("deg", "").strip()


def find_heading(rows: Sequence[Sequence[str]], known: Known, enough: int = 2) -> Heading:
    """The row that names the most quantities, or one before it that names `enough` and is followed by as many cells;
    where there is none, the row above the first of numbers.

    `rows` are the first rows of a table, cut into cells.
    """
    scores = [len({known(plain(cell)) for cell in row} - {None}) for row in rows]
    best = max(scores, default=0)
    if best >= enough:
        header = next(k for k, score in enumerate(scores) if score >= enough and (score == best or _begins(rows, k)))
        first = _next(rows, header + 1)
    else:
        first = next((k for k, row in enumerate(rows) if of_numbers(row)), len(rows))
        above = [k for k in range(first) if any(cell.strip() for cell in rows[k])]
        if above and _is_units(rows[above[-1]]):
            above.pop()
        if not above or (first < len(rows) and len(rows[above[-1]]) < len(rows[first]) - 1):
            return Heading(None, first, best, ())
        header = above[-1]
        first = _next(rows, header + 1)
    names = tuple(plain(cell) for cell in rows[header])
    if first < len(rows) and _is_units(rows[first]):
        return Heading(header, _next(rows, first + 1), best, names, tuple(rows[first]))
    above = next((row for row in reversed(rows[:header]) if any(cell.strip() for cell in row)), ())
    units = tuple(above) if len(above) == len(names) > 1 and _is_units(above) else ()
    return Heading(header, first, best, names, units)


def plain(cell: str) -> str:
    """A header without blanks and the mark of a comment."""
    return cell.strip().lstrip("#% ")


def _next(rows: Sequence[Sequence[str]], start: int) -> int:
    """Index of the next row that is not blank."""
    return next((k for k in range(start, len(rows)) if any(cell.strip() for cell in rows[k])), len(rows))


def _begins(rows: Sequence[Sequence[str]], k: int) -> bool:
    """Whether a table begins with row k: a row of as many cells follows, with a delimiter more or less at its end."""
    following = _next(rows, k + 1)
    return following < len(rows) and abs(len(rows[following]) - len(rows[k])) <= 1


def of_numbers(row: Sequence[str]) -> bool:
    """Whether two cells or more are numbers."""
    return max(count_numbers(row, "."), count_numbers(row, ",")) >= 2


def plain_unit(cell: str) -> str:
    """A cell of a row of units without its brackets."""
    text = cell.strip().replace("°", "")
    return text[1:-1].strip() if text[:1] + text[-1:] in ("[]", "()") else text


def _is_units(row: Sequence[str]) -> bool:
    cells = [plain_unit(cell) for cell in row if cell.strip()]
    short = all(len(cell) <= 12 and (cell == "1" or not count_numbers([cell])) for cell in cells)
    return short and any(is_unit(cell) and cell != "1" for cell in cells)
