"""Tables as xarray's labelled arrays: units, which stand in the names of our columns, become attributes."""

from typing import TYPE_CHECKING, Any

from ..core import UsageError

if TYPE_CHECKING:
    import pandas as pd

UNITS = {"s": "s", "MPa": "MPa", "N": "N", "C": "degC", "mm_s": "mm/s", "mm": "mm"}


def dataset(frame: "pd.DataFrame", about: dict[str, str]) -> Any:
    """A Dataset over `sample` with a variable a column. Raises UsageError where xarray is missing."""
    try:
        import xarray  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise UsageError("to_xarray needs xarray; pip install xarray") from None
    found = {}
    for column in frame:
        name, unit = split(str(column))
        found[name] = ("sample", frame[column].to_numpy(), {"units": unit} if unit else {})
    return xarray.Dataset(found, attrs={key: value for key, value in about.items() if value})


def split(column: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit, which may be empty."""
    for end, unit in sorted(UNITS.items(), key=lambda pair: -len(pair[0])):
        if column.endswith(f"_{end}"):
            return column.removesuffix(f"_{end}"), unit
    return column, ""
