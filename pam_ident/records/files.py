"""Which files are a record, and which loader reads each."""

import gzip
import os
import re
import zipfile
import zlib
from dataclasses import dataclass, replace
from glob import glob, has_magic
from pathlib import Path

from ..core import DataError
from ..core.files import spare
from ..core.nearest import nearest
from .datasets import bundled, dataset_names
from .formats import catalogue
from .mapping import Mapping, read_mapping
from .package import data_of, read_package
from .table import Table
from .text_table import read_layout, read_text

TEXT = (".csv", ".tsv", ".txt", ".dat", ".asc")
PROSE = re.compile(r"(read[ _-]?me|sources?|notes?|licen[cs]e|changelog)\.", re.IGNORECASE)
"""Names of files beside a record that are for people."""
PIECE = 1 << 20
"""Bytes that are unpacked at a time."""


@dataclass(frozen=True)
class Files:
    """The files of a record, as `given`: one, or several that are runs of one test. `name` is empty for several."""

    given: str
    paths: tuple[Path, ...]
    folder: Path
    name: str

    @property
    def mapping(self) -> Mapping | None:
        """What the columns.toml beside the files says, None where there is none."""
        beside = self.folder / "columns.toml"
        return read_mapping(beside) if beside.is_file() else None

    def written(self) -> str:
        """How the first file is written, in words."""
        ending = _ending(self.paths[0])
        if ending in catalogue():
            return f"as {ending}"
        layout = read_layout(self.paths[0], self.mapping)
        names = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "blanks"}
        header = f"header in row {layout.header_line}" if layout.header_line else "no header"
        mark = "comma" if layout.decimal == "," else "point"
        between = names.get(layout.delimiter, repr(layout.delimiter))
        return f"as text ({layout.encoding}), {between} between cells, decimal {mark}, {header}"

    @property
    def text_bytes(self) -> int:
        """Size of the files that are text."""
        return sum(path.stat().st_size for path in self.paths if _ending(path) not in catalogue())


def share_of_memory(path: str | Path) -> float:
    """Size of a record's text as a share of the memory that this process may still take. Raises DataError where there
    are no files."""
    return find_files(path).text_bytes / free_memory()


def free_memory() -> int:
    """Bytes that the system has left, or that the process's control group is granted."""
    found = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found += [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable")]
        found.append(int(Path("/sys/fs/cgroup/memory.max").read_text(encoding="ascii")))
    except (OSError, ValueError):
        pass  # another system, or no limit
    return min(found)


def find_files(path: str | Path) -> Files:
    """The files of a record: one, those of a folder or of a pattern (`runs/*.csv`) in the order of the numbers in their
    names, or that of a bundled data set by its name. Raises DataError where there are none."""
    given, path = str(path), Path(path)
    if not given.strip():  # which would be this folder
        raise DataError("no record was named; give the path of a file or folder, or the name of a data set")
    if path.is_file():
        return Files(given, (path,), path.parent, path.name.removesuffix(".gz").rpartition(".")[0] or path.name)
    endings = (*TEXT, *catalogue())
    if path.is_dir() and (package := read_package(path)):
        return Files(given, data_of(package, path, endings), path, package.title)
    if path.is_dir():
        files = [file for file in path.iterdir() if file.is_file() and not PROSE.match(file.name)]
        found = [file for file in files if _ending(file) in endings]
        if not found:
            raise DataError(
                f"{given}: a folder without a record; expected files ending in {', '.join(endings)}. Name a file"
            )
    elif has_magic(given):
        found = [Path(name) for name in glob(given, recursive=True) if Path(name).is_file()]
        found = [file for file in found if file.suffix != ".toml"]
        if not found:
            raise DataError(f"{given}: no file fits this pattern; check it, and the folder it begins in")
    else:
        along = bundled(given)
        if along is None:
            known = [name for name in dataset_names() if bundled(name)]
            near = nearest(given, known)
            if near:
                raise DataError(f"{given}: no such file; did you mean the data set {' or '.join(near)}?")
            raise DataError(f"{given}: no such file; give the path of a CSV record, or a data set: {', '.join(known)}")
        return replace(find_files(along), given=given)
    found.sort(key=_natural)
    return Files(given, tuple(found), found[0].parent, "")


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The tables of a file, by its ending; what ends in no known way is read as text. Raises DataError."""
    spare(path)
    ending = _ending(path)
    if ending == ".xls":
        raise DataError(f"{path}: an old Excel file; save it as .xlsx or as CSV")
    if path.stat().st_size == 0:
        raise DataError(f"{path}: the file is empty; expected a header row and one row a sample")
    return catalogue()[ending].read(path, mapping) if ending in catalogue() else read_text(path, mapping)


def _ending(path: Path) -> str:
    return Path(path.name.lower().removesuffix(".gz")).suffix


def _natural(path: Path) -> list[tuple[int, float, str]]:
    """Sort key under which run2 is before run10."""
    words = re.split(r"(\d+(?:\.\d+)?)", str(path))
    return [(1, 0.0, word) if k % 2 == 0 else (0, float(word), "") for k, word in enumerate(words)]


def check_unpacked(path: Path, most: int) -> None:
    """Raises DataError for a gzipped file, a workbook or a Parquet file that unpacks to more than `most` bytes; of what
    is broken its reader tells."""
    name, size = path.name.lower(), 0
    try:
        if name.endswith(".gz"):
            with gzip.open(path, "rb") as file:
                while size <= most and (piece := file.read(PIECE)):
                    size += len(piece)
        elif name.endswith((".xlsx", ".xlsm")):
            with zipfile.ZipFile(path) as book:
                size = sum(item.file_size for item in book.infolist())
        elif name.endswith(".parquet"):
            import pyarrow.parquet

            about = pyarrow.parquet.ParquetFile(path).metadata
            size = 8 * about.num_rows * about.num_columns
    except (OSError, EOFError, zlib.error, zipfile.BadZipFile, ImportError, ValueError):
        return
    if size > most:
        raise DataError(
            f"{path}: unpacks to more than {most / 2**20:.0f} MiB; expected a record of less. Give a part of it"
        )
