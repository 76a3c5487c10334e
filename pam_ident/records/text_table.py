"""Tables as text (CSV and its kin), read block by block: each row must have the cells that the header promises."""

import codecs
import gzip
import io
import warnings
import zlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from ..core import DataError
from ..core.progress import tell
from .mapping import Mapping
from .table import Table, TableRows
from .text_layout import HEAD_BYTES, Layout, cells_of, find_layout

if TYPE_CHECKING:
    import pandas as pd

BLOCK_BYTES = 1 << 24
MOST_LINE = 1 << 26
"""Bytes of a line beyond which nothing more of it is read: a small compressed file may hold gigabytes of it."""
SMALL_BYTES = 1 << 20
"""Text up to which numbers are parsed sooner by NumPy than pandas is imported."""


def read_text(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The table of a text file, plain or gzipped. Raises DataError where it is none."""
    layout = read_layout(path, mapping)

    def read(wanted: Sequence[int]) -> Iterator[TableRows]:
        with _open(path) as file:
            yield from _blocks(str(path), file, layout, wanted)

    row = layout.header_line or layout.first_line
    return [Table(str(path), f"{path}, row {row}", layout.names, layout.headers, read, layout.decimal, layout.doubtful)]


def read_layout(path: Path, mapping: Mapping | None = None) -> Layout:
    """How a text file is written. Raises DataError where it holds no table."""
    with _open(path) as file:
        return find_layout(str(path), _take(str(path), file, HEAD_BYTES), mapping)


def _open(path: Path) -> BinaryIO:
    try:
        return gzip.open(path, "rb") if path.suffix.lower() == ".gz" else path.open("rb")  # type: ignore[return-value]
    except OSError as error:
        raise DataError(f"{path}: not a readable file ({error.strerror}); check the path and its rights") from None


def _take(place: str, file: BinaryIO, size: int) -> bytes:
    try:
        return file.read(size)
    except (OSError, EOFError, zlib.error) as error:
        raise DataError(f"{place}: not a readable file ({error}); copy it again from the rig") from None


def _blocks(place: str, file: BinaryIO, layout: Layout, wanted: Sequence[int]) -> Iterator[TableRows]:
    """The rows after the header, numbered as lines."""
    line = 1
    for text in _pieces(place, file, layout):
        if (above := layout.first_line - line) > 0:
            lines = _with_newlines(text).split(b"\n", above)
            line += len(lines) - 1
            text = lines[-1]
            if line < layout.first_line or not text:
                continue
        tell("reading rows", line)
        block = _plain(text, line, layout, wanted)
        if block is not None:
            line += len(block)
        else:
            text = _with_newlines(text)
            block = _mended(place, text, line, layout, wanted)
            line += text.count(b"\n")
        yield block


def _pieces(place: str, file: BinaryIO, layout: Layout) -> Iterator[bytes]:
    """Whole lines in valid UTF-8, about BLOCK_BYTES at a time."""
    _take(place, file, layout.skip)
    decoder = None if layout.encoding == "utf-8" else codecs.getincrementaldecoder(layout.encoding)("replace")
    rest = b""
    while chunk := _take(place, file, BLOCK_BYTES):
        if decoder:
            chunk = decoder.decode(chunk).encode()
        cut = chunk.rfind(b"\n") + 1
        if not cut:
            if len(rest) > MOST_LINE:
                raise DataError(
                    f"{place}: a line of more than {MOST_LINE >> 20} MiB; expected a table, a row a sample. Check it"
                )
            chunk, rest = rest + chunk, b""
            # Not the last byte: its \n may come with the next chunk.
            cut = chunk.rfind(b"\r", 0, len(chunk) - 1) + 1
        if cut:
            yield _valid(b"".join((rest, memoryview(chunk)[:cut])))
            rest = b""
        rest += chunk[cut:]
    if rest:
        yield _valid(rest.rstrip(b"\r") + b"\n")


def _valid(text: bytes) -> bytes:
    return text if text.isascii() else text.decode("utf-8", "replace").encode()


def _with_newlines(text: bytes) -> bytes:
    """Lines that end in \\n."""
    return text.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in text else text


def _plain(text: bytes, first: int, layout: Layout, wanted: Sequence[int]) -> TableRows | None:
    """The rows of lines of which each is a row as the header promises; None where any may need a closer look.

    One pass over the marks between cells tells of all lines that they have as many cells as the header, without
    quotation marks; what is left to rule out are lines of nothing but delimiters, and the header again.
    """
    delimiter = layout.delimiter.encode()
    if delimiter == b" " or any(line.encode() in text for line in layout.repeated[:1]):
        return None
    marks = text.translate(None, bytes({*range(256)} - {*delimiter, *b'\n\r\0"'}))
    row = delimiter * (layout.width - 1) + (b"\r\n" if text.endswith(b"\r\n") else text[-1:])
    n = len(marks) // len(row)
    if marks != row * n:
        return None
    rows = range(first, first + n)
    if len(text) <= SMALL_BYTES and (numbers := _numbers(text, layout, wanted)) is not None and len(numbers) == n:
        return TableRows(dict(zip(wanted, numbers.T, strict=True)), rows)
    frame = _frame(text, layout, wanted)
    if frame is None or len(frame) != n or frame.iloc[:, 0].isna().any():
        return None
    return TableRows(_cells(frame, wanted), rows)


def _mended(place: str, text: bytes, first: int, layout: Layout, wanted: Sequence[int]) -> TableRows:
    """The rows among lines that are looked at one by one. Raises DataError for a row of other width."""
    if b"\0" in text:
        row = first + text[: text.index(b"\0")].count(b"\n")
        raise DataError(f"{place}, row {row}: holds a byte that is no text; expected a table. Copy the file again")
    text, rows, starts = _checked(place, text, first, layout)
    if not rows:
        return TableRows({k: np.empty(0) for k in wanted}, rows, starts)
    frame = _frame(text, layout, wanted)
    if frame is None or len(frame) != len(rows):
        raise DataError(f"{place}: not a readable CSV file (quotation marks around line ends?); write it without them")
    return TableRows(_cells(frame, wanted), rows, starts)


def _numbers(text: bytes, layout: Layout, wanted: Sequence[int]) -> np.ndarray | None:
    """The wanted columns of lines of numbers, shape (n, len(wanted)); None where a cell is none."""
    if layout.decimal != "." or not wanted:
        return None
    try:
        lines = io.StringIO(text.decode())
        found = np.loadtxt(lines, delimiter=layout.delimiter, comments=None, usecols=list(wanted), ndmin=2)
    except ValueError:
        return None
    return found if np.isfinite(found).all() else None


def _frame(text: bytes, layout: Layout, wanted: Sequence[int]) -> "pd.DataFrame | None":
    """The wanted columns, by their positions, of lines that have as many cells as the header; None where pandas finds
    other cells in them than a count of delimiters does."""
    import pandas as pd

    with suppress(ValueError), warnings.catch_warnings():
        warnings.simplefilter("ignore", pd.errors.DtypeWarning)  # of a bad cell, which is named later
        return pd.read_csv(
            io.BytesIO(text),
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            decimal=layout.decimal,
            header=None,
            names=list(range(layout.width)),
            usecols=sorted({*wanted}) or [0],
            index_col=False,
            skipinitialspace=b" " in text,
            skip_blank_lines=False,
        )
    return None


def _cells(frame: "pd.DataFrame", wanted: Sequence[int]) -> "dict[int, pd.Series]":
    import pandas as pd

    return {k: pd.Series(frame[k]) for k in wanted}


def _checked(place: str, text: bytes, first: int, layout: Layout) -> tuple[bytes, list[int], tuple[int, ...]]:
    """The lines that are rows, their numbers, and which rows follow a repeated header; blank lines are left out."""
    delimiter = layout.delimiter.encode()
    again = [line.encode() for line in layout.repeated]
    lines, rows, starts = [], [], []
    for row, line in enumerate(text.split(b"\n")[:-1], first):
        stripped = line.strip()
        # Loggers of DOS times end their files with ^Z.
        if not line.strip(delimiter + b' \t"\x1a'):
            continue
        if stripped in again:
            starts += [len(rows)] * (stripped == again[0])
            continue
        if line.count(b'"') % 2:
            raise DataError(f"{place}, row {row}: a quotation mark that is not closed; expected a pair. Fix the row")
        if b'"' in line or delimiter == b" ":
            width = len(cells_of(line.decode("utf-8", "replace"), layout.delimiter))
        else:
            width = line.count(delimiter) + 1
        if width != layout.width:
            raise DataError(
                f"{place}, row {row}: {width} cells, but the rows before have {layout.width}; expected as many. Fix "
                "or delete the row"
            )
        lines.append(line)
        rows.append(row)
    return b"\n".join([*lines, b""]), rows, tuple(starts)
