"""Tables as xarray's labelled arrays and back: units, which stand in the names of our columns, become attributes."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..core import UsageError

if TYPE_CHECKING:
    import pandas as pd

UNITS = {"s": "s", "MPa": "MPa", "N": "N", "C": "degC", "mm_s": "mm/s", "mm": "mm"}
ENDS = {unit: end for end, unit in UNITS.items()}


def dataset(frame: "pd.DataFrame", about: Mapping[str, Any]) -> Any:
    """A Dataset over `sample` with a variable a column. Raises UsageError where xarray is missing."""
    try:
        import xarray  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise UsageError("to_xarray needs xarray; pip install xarray") from None
    found = {}
    for column in frame:
        name, unit = split(str(column))
        found[name] = ("sample", frame[column].to_numpy(), {"units": unit} if unit else {})
    return xarray.Dataset(found, attrs={key: value for key, value in about.items() if value not in ("", None)})


def table(data: Any) -> "pd.DataFrame":
    """A Dataset as a table, a row a sample; units stand in the names of the columns again."""
    named = {str(name): str(one.attrs.get("units", "")) for name, one in data.variables.items()}
    frame = data.to_dataframe()
    frame = frame.reset_index(drop=frame.index.name not in named)  # a dimension alone only counts
    return frame.rename(columns={name: _joined(name, unit) for name, unit in named.items()})


def split(column: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit, which may be empty."""
    for end, unit in sorted(UNITS.items(), key=lambda pair: -len(pair[0])):
        if column.endswith(f"_{end}"):
            return column.removesuffix(f"_{end}"), unit
    return column, ""


def _joined(name: str, unit: str) -> str:
    return f"{name}_{ENDS[unit]}" if unit in ENDS else f"{name} [{unit}]" if unit else name
