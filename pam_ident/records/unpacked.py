"""How large a compressed file is behind its compression: a small one may hold gigabytes."""

import gzip
import zipfile
import zlib
from pathlib import Path

from ..core import DataError

PIECE = 1 << 20


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
