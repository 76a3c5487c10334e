"""MATLAB files: vectors by name, structs of vectors, or a matrix whose columns a columns.toml names."""

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...core import DataError
from ..mapping import Mapping
from ..mat_check import check_elements
from ..quantities import quantity_of
from ..table import Table, table_in_memory
from .base import Format, reading


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The file's own vectors, each struct (an array of structs is several runs) and each matrix are tables; samples
    count from 1. Raises DataError, UsageError for a file of version 7.3 without h5py.
    """
    with path.open("rb") as file:
        is_hdf = b"MATLAB 7.3" in (start := file.read(520)) or start[512:520] == b"\x89HDF\r\n\x1a\n"
    content = _of_hdf(path) if is_hdf else _of_mat(path)
    wanted = mapping.layout.get("part") if mapping else None
    tables = []
    for name, columns in _groups(content):
        if wanted in (None, name):
            place = f"{path}, variable {name!r}" if name else str(path)
            tables += _table(place, columns)
    if not tables:
        raise DataError(
            f"{path}: no vectors{f' in {wanted!r}' if wanted else ''} that could be a record; expected such as force_N "
            "and pressure_MPa, or a struct of them (of a table: s = table2struct(T, 'ToScalar', true))"
        )
    return tables


def _of_mat(path: Path) -> dict[str, object]:
    from scipy.io import loadmat
    from scipy.io.matlab import matfile_version

    with reading(path, "scipy", "MATLAB file", "save it again"):
        if matfile_version(path)[0] == 1:  # of versions 5 to 7
            check_elements(path.read_bytes())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what MATLAB alone can read, such as its tables
            content = loadmat(path, squeeze_me=True, struct_as_record=False)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _of_hdf(path: Path) -> dict[str, object]:
    def take(group: Any) -> dict[str, object]:
        found = {name: one for name, one in group.items() if not name.startswith("#")}
        return {name: take(one) if hasattr(one, "items") else np.squeeze(one[()]).T for name, one in found.items()}

    with reading(path, "h5py", "MATLAB file", "save it again"):
        import h5py

        with h5py.File(path) as file:
            return take(file)


def _groups(content: dict[str, object]) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
    """Name and columns of what may be a table."""
    yield "", {name: value for name, value in content.items() if isinstance(value, np.ndarray) and value.ndim == 1}
    for name, value in content.items():
        if isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "fiu":
            yield name, {f"column {k + 1}": column for k, column in enumerate(value.T)}
        several = value if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype == object else [value]
        for number, one in enumerate(several, 1):
            fields = one if isinstance(one, dict) else getattr(one, "__dict__", {})
            columns = {key: np.asarray(x) for key, x in fields.items() if np.ndim(x) == 1}
            yield f"{name}({number})" if len(several) > 1 else name, columns


def _table(place: str, columns: dict[str, np.ndarray]) -> list[Table]:
    """A table of the columns of equal length; none where there are less than two."""
    import pandas as pd

    lengths = [len(column) for name, column in columns.items() if quantity_of(name)] or [*map(len, columns.values())]
    n = max(lengths, default=0)
    for name, column in columns.items():
        if quantity_of(name) and len(column) != n:
            raise DataError(f"{place}, {name!r}: {len(column)} samples, others {n}; expected as many")
    frame = pd.DataFrame({name: column for name, column in columns.items() if len(column) == n and n})
    return [table_in_memory(place, place, frame, 1)] if frame.shape[1] > 1 else []


FORMAT = Format((".mat",), read_tables)
