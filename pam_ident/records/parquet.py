"""Parquet files."""

from pathlib import Path

from ..core import DataError
from .mapping import Mapping
from .table import Table, need_extra, table_in_memory


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The table of a file; rows count from 1. Raises DataError where it is none, UsageError without pyarrow."""
    try:
        import pyarrow.parquet
    except ImportError:
        raise need_extra("pyarrow", path) from None
    try:
        content = pyarrow.parquet.ParquetFile(path).read().replace_schema_metadata()
        frame = content.to_pandas()
    except Exception as error:  # a broken file ends in any of a dozen errors of the package
        first = str(error).partition("\n")[0]
        raise DataError(f"{path}: not a readable Parquet file ({first}); write it again") from None
    if frame.empty:
        raise DataError(f"{path}: columns but no rows; expected one row a sample")
    return [table_in_memory(str(path), str(path), frame, 1)]
