"""How a text file is written: encoding, delimiter, decimal mark, preamble, header, row of units."""

import codecs
import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..core import DataError
from .heading import Heading, find_heading, of_numbers
from .mapping import Mapping as Told
from .quantities import quantity_of
from .table import count_numbers

# The earlier one wins a tie: where cells are parted by semicolons or tabs, commas are decimal marks.
DELIMITERS = ("\t", ";", ",", "|", " ")
"""In the order in which they are tried; a space stands for any run of blanks."""
HEAD_BYTES = 1 << 16
HEAD_LINES = 300
MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))
_NO_TEXT = re.compile(r"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f]")
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2},\d{3}\s*")


@dataclass(frozen=True)
class Layout:
    """How to read a text table: `skip` bytes of the mark of the encoding, then lines; `header_line` and `first_line`
    count from 1 (0: no header). `width` is the number of cells of a row."""

    encoding: str
    skip: int
    delimiter: str
    decimal: str
    header_line: int
    first_line: int
    width: int
    names: tuple[str, ...]
    headers: tuple[str, ...]
    repeated: tuple[str, ...]
    """Header and row of units as written, stripped: they may come again further down."""
    doubtful: Mapping[int, str]
    """Position of a column → a cell whose point may part thousands, where no cell of the file says that it does not."""


def find_layout(place: str, head: bytes, mapping: Told | None = None) -> Layout:
    """The layout of a text file from its first bytes. Raises DataError where they are no table."""
    told = mapping.layout if mapping else {}
    encoding, skip = _encoding(place, head, told.get("encoding"))
    text = head[skip : skip + (len(head) - skip) // 2 * 2].decode(encoding, errors="replace")
    if not text.strip():
        raise DataError(f"{place}: the file is empty; expected a header row and one row a sample")
    if text.lstrip().startswith("{") and '"pam-ident/' in text:
        raise DataError(f"{place}: JSON that this program wrote, no record; a saved fit is for validate and predict")
    if _NO_TEXT.search(text):
        raise DataError(f"{place}: not a readable CSV file (it is not text); expected a table as text")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if len(head) >= HEAD_BYTES:
        lines.pop()  # cut in two
    lines = lines[:HEAD_LINES]
    delimiter, rows, heading = _heading(lines, mapping)
    names = heading.names
    data = [row for row in rows[heading.first :] if any(cell.strip() for cell in row)]
    if not data:
        raise DataError(f"{place}: a header but no rows of numbers; expected one row a sample")
    width = len(data[0])
    line = heading.first + 1
    if heading.header is None:
        names = tuple(f"column {k + 1}" for k in range(width))
        if mapping is None:
            raise DataError(
                f"{place}, row {line}: no header row above the numbers; say in a columns.toml beside the file which "
                "column is what, such as: [columns] pressure_kPa = 2"
            )
    else:
        names = _fit_width(place, names, data[0], line)
        above = [k for k, row in enumerate(rows[: heading.header], 1) if len(row) == width and of_numbers(row)]
        if above and "header_row" not in told:
            raise DataError(
                f"{place}, row {above[0]}: numbers above the header, which is row {heading.header + 1}; expected them "
                "below it. Fix the header, or say header_row under [file] in a columns.toml beside the file"
            )
    units = [*heading.units, *[""] * width][:width]
    heading = Heading(heading.header, heading.first, heading.score, names, tuple(units))
    where = heading.header + 1 if heading.header is not None else 0
    repeated = tuple(lines[k].strip() for k in range(where - 1, heading.first) if lines[k].strip()) if where else ()
    headers = heading.headers(f"{place}, row {where}")
    decimal = told.get("decimal") or _decimal(place, data, delimiter, names)
    doubtful = _doubtful(data) if decimal == "." and delimiter != "," and "decimal" not in told else {}
    return Layout(encoding, skip, delimiter, decimal, where, line, width, names, headers, repeated, doubtful)


def cells_of(line: str, delimiter: str) -> list[str]:
    """The cells of a line. One that csv takes for too long is cut as if it held no quotation marks."""
    if delimiter == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:
        return line.split(delimiter)


def _encoding(place: str, head: bytes, told: str | None) -> tuple[str, int]:
    """Name of the encoding, and the length of the mark that tells it."""
    for mark, name in MARKS:
        if head.startswith(mark):
            return name, len(mark)
    if told is not None:
        try:
            return codecs.lookup(told).name, 0
        except LookupError:
            raise DataError(f"{place}: unknown encoding {told!r} in columns.toml; try utf-8 or cp1252") from None
    # UTF-16 without its mark: every second byte of plain text is zero.
    even, odd = head[0:2000:2].count(0), head[1:2000:2].count(0)
    if max(even, odd) > 0.4 * min(len(head), 2000) / 2 and min(even, odd) == 0:
        return ("utf-16-le" if odd else "utf-16-be"), 0
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "latin-1", 0
    return "utf-8", 0


def _heading(lines: list[str], mapping: Told | None) -> tuple[str, list[list[str]], Heading]:
    """Delimiter, rows and heading: the delimiter under which most names are known, else most cells are numbers. One
    under which the rows hold no number is a mark within the names."""
    told = mapping.layout if mapping else {}
    best: tuple[tuple[bool, int, int], str, list[list[str]], Heading] | None = None
    written = [delimiter for delimiter in DELIMITERS if any(delimiter in line for line in lines)] or DELIMITERS
    for delimiter in (told["delimiter"],) if "delimiter" in told else written:
        rows = [cells_of(line, delimiter) if line.strip(f"{delimiter} \t") else [] for line in lines]
        heading = _one_heading(rows, mapping)
        sample = rows[heading.first : heading.first + 50]
        numbers = max(sum(count_numbers(row, mark) for row in sample) for mark in ".,")
        score = (numbers > 0, heading.score, numbers)
        if best is None or score > best[0]:
            best = (score, delimiter, rows, heading)
    assert best is not None
    return best[1:]


def _one_heading(rows: list[list[str]], mapping: Told | None) -> Heading:
    if mapping is None:
        return find_heading(rows, quantity_of)
    line = mapping.layout.get("header_row")
    if line is None:
        return find_heading(rows, mapping.known, mapping.enough)
    if line == 0:
        return Heading(None, next((k for k, row in enumerate(rows) if row), len(rows)), 0, ())
    found = find_heading(rows[line - 1 :], lambda _: "any", 1)
    header = None if found.header is None else found.header + line - 1
    return Heading(header, found.first + line - 1, found.score, found.names, found.units)


def _fit_width(place: str, names: tuple[str, ...], row: Sequence[str], line: int) -> tuple[str, ...]:
    """The names of a row's cells; a last delimiter too many, in the header or in the rows, is passed over."""
    if len(row) == len(names) + 1 and not row[-1].strip():
        return (*names, "")
    if len(row) == len(names) - 1 and not names[-1]:
        return names[:-1]
    if len(row) != len(names):
        raise DataError(
            f"{place}, row {line}: {len(row)} cells, but the header has {len(names)}; expected as many. Fix the row, "
            "or the header"
        )
    return names


def _doubtful(rows: Sequence[Sequence[str]]) -> dict[int, str]:
    """The columns of rows in which each point could part thousands (`1.167`), with such a cell; none where any other
    number of the rows has a point that cannot."""
    found: dict[int, str] = {}
    for row in rows:
        for position, cell in enumerate(row):
            if "." in cell and count_numbers([cell]):
                if not _THOUSANDS.fullmatch(cell.replace(".", ",")):
                    return {}
                found.setdefault(position, cell.strip())
    return found


def _decimal(place: str, rows: Sequence[Sequence[str]], delimiter: str, names: Sequence[str]) -> str:
    """The decimal mark that makes more cells numbers. Raises DataError where a comma may part thousands."""
    points, commas = (sum(count_numbers(row, mark) for row in rows) for mark in ".,")
    if commas <= points:
        return "."
    cells = [(name, cell) for row in rows for name, cell in zip(names, row, strict=False) if "," in cell]
    numbers = [(name, cell) for name, cell in cells if count_numbers([cell], ",")]
    # 1,234 in every cell reads either way, and a wrong guess is a factor of a thousand.
    if all(_THOUSANDS.fullmatch(cell) for _, cell in numbers):
        name, cell = numbers[0]
        raise DataError(
            f"{place}, column {name!r}: {cell.strip()!r} may be a decimal number or thousands; write it without the "
            "comma, or say decimal = ',' under [file] in a columns.toml beside the file"
        )
    return ","
