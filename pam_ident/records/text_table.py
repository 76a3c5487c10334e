"""Tables as text (CSV and its kin), read block by block: each row must have the cells that the header promises."""

import codecs
import gzip
import io
import warnings
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

import pandas as pd

from ..core import DataError
from ..core.progress import tell
from .mapping import Mapping
from .table import Block, Table
from .text_layout import HEAD_BYTES, Layout, cells_of, find_layout

BLOCK_BYTES = 1 << 24


def read_text(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The table of a text file, plain or gzipped. Raises DataError where it is none."""
    layout = read_layout(path, mapping)

    def read(wanted: Sequence[int]) -> Iterator[Block]:
        with _open(path) as file:
            yield from _blocks(str(path), file, layout, wanted)

    row = layout.header_line or layout.first_line
    return [Table(str(path), f"{path}, row {row}", layout.names, layout.headers, read, layout.decimal)]


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


def _blocks(place: str, file: BinaryIO, layout: Layout, wanted: Sequence[int]) -> Iterator[Block]:
    """The rows after the header, numbered as lines."""
    line = 1
    for text in _pieces(place, file, layout):
        first, line = line, line + text.count(b"\n")
        if line <= layout.first_line:
            continue
        if first < layout.first_line:
            text = text.split(b"\n", layout.first_line - first)[-1]
            first = layout.first_line
        tell("reading rows", first)
        if text.strip():
            yield _parse(place, text, first, layout, wanted)


def _pieces(place: str, file: BinaryIO, layout: Layout) -> Iterator[bytes]:
    """Whole lines in UTF-8 with \\n at their ends, about BLOCK_BYTES at a time."""
    _take(place, file, layout.skip)
    decoder = None if layout.encoding == "utf-8" else codecs.getincrementaldecoder(layout.encoding)("replace")
    rest = b""
    while chunk := _take(place, file, BLOCK_BYTES):
        text = rest + (decoder.decode(chunk).encode() if decoder else chunk)
        cut = text.rfind(b"\n") + 1 or text.rfind(b"\r", 0, len(text) - 1) + 1
        text, rest = text[:cut], text[cut:]
        yield _clean(text)
    if rest:
        yield _clean(rest.rstrip(b"\r") + b"\n")


def _clean(text: bytes) -> bytes:
    """Lines that end in \\n, in valid UTF-8."""
    if not text.isascii():
        text = text.decode("utf-8", "replace").encode()
    return text.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in text else text


def _parse(place: str, text: bytes, first: int, layout: Layout, wanted: Sequence[int]) -> Block:
    """Cut lines into cells; `first` is the number of the first line. Raises DataError for a row of other width."""
    if b"\0" in text:
        row = first + text[: text.index(b"\0")].count(b"\n")
        raise DataError(f"{place}, row {row}: holds a byte that is no text; expected a table. Copy the file again")
    rows: Sequence[int] = range(first, first + text.count(b"\n"))
    starts: tuple[int, ...] = ()
    if not _is_plain(text, layout):
        text, rows, starts = _checked(place, text, first, layout)
    if not rows:
        return Block({k: pd.Series(dtype=float) for k in wanted}, rows, starts)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pd.errors.DtypeWarning)  # of a bad cell, which is named later
        frame = pd.read_csv(
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
    if len(frame) != len(rows):
        raise DataError(f"{place}: not a readable CSV file (quotation marks around line ends?); write it without them")
    return Block({k: pd.Series(frame[k]) for k in wanted}, rows, starts)


def _is_plain(text: bytes, layout: Layout) -> bool:
    """Whether every line has as many delimiters as the header and nothing needs a closer look."""
    delimiter, header = layout.delimiter.encode(), [line.encode() for line in layout.repeated[:1]]
    if delimiter == b" " or b'"' in text or any(line in text for line in header):
        return False
    empty = delimiter * (layout.width - 1) + b"\n"
    if text.startswith(empty) or b"\n" + empty in text:
        return False
    others = bytes(set(range(256)) - {*delimiter, *b"\n"})
    return text.translate(None, others) == empty * text.count(b"\n")


def _checked(place: str, text: bytes, first: int, layout: Layout) -> tuple[bytes, list[int], tuple[int, ...]]:
    """The lines that are rows, their numbers, and which rows follow a repeated header; blank lines are left out."""
    delimiter = layout.delimiter.encode()
    again = [line.encode() for line in layout.repeated]
    lines, rows, starts = [], [], []
    for row, line in enumerate(text.split(b"\n")[:-1], first):
        stripped = line.strip()
        if not line.strip(delimiter + b' \t"\x1a'):
            continue
        if stripped in again:
            starts += [len(rows)] * (stripped == again[0])
            continue
        if line.count(b'"') % 2:
            raise DataError(f"{place}, row {row}: a quotation mark that is not closed; expected a pair. Mend the row")
        if b'"' in line or delimiter == b" ":
            width = len(cells_of(line.decode("utf-8", "replace"), layout.delimiter))
        else:
            width = line.count(delimiter) + 1
        if width != layout.width:
            raise DataError(
                f"{place}, row {row}: {width} cells, but the rows before have {layout.width}; expected as many. Mend "
                "or delete the row"
            )
        lines.append(line)
        rows.append(row)
    return b"\n".join([*lines, b""]), rows, tuple(starts)
