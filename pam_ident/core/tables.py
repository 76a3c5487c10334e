"""Numbers on their way out to JSON."""

import math
from typing import Any


def blank_nan(value: Any) -> Any:
    """`value` with every NaN and infinity replaced by None and numpy scalars by Python's, all the way down."""
    if isinstance(value, dict):
        return {str(key): blank_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [blank_nan(item) for item in value]
    if hasattr(value, "tolist"):
        return blank_nan(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
