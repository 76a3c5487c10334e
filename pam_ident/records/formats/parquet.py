"""Parquet files."""

from pathlib import Path

from ...core import DataError
from ..mapping import Mapping
from ..table import Table, table_in_memory
from .base import Format, reading


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The table of a file; rows count from 1. Raises DataError where it is none, UsageError without pyarrow."""
    with reading(path, "pyarrow", "Parquet file", "write it again"):
        import pyarrow.parquet

        content = pyarrow.parquet.ParquetFile(path, page_checksum_verification=True).read().replace_schema_metadata()
        frame = content.to_pandas()
    if frame.empty:
        raise DataError(f"{path}: columns but no rows; expected one row a sample")
    return [table_in_memory(str(path), str(path), frame, 1)]


FORMAT = Format((".parquet",), read_tables)
