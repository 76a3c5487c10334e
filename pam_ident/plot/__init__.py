"""Figures, one a file. Each file has `data(...)`, what would be drawn, and `draw(...)`, a matplotlib Figure of it.

Figures are built without pyplot and leave no global state behind; what they show is tested through `data`.
"""

from . import (
    calibration,
    candidates,
    coefficients,
    confusion,
    failure_map,
    follows,
    four_bar,
    isobars,
    ladder,
    laws_compared,
    measured_against_model,
    over_pressure,
    profiles,
    residual_pattern,
    signature,
)
from .style import to_png, to_svg

__all__ = [
    "calibration",
    "candidates",
    "coefficients",
    "confusion",
    "failure_map",
    "follows",
    "four_bar",
    "isobars",
    "ladder",
    "laws_compared",
    "measured_against_model",
    "over_pressure",
    "profiles",
    "residual_pattern",
    "signature",
    "to_png",
    "to_svg",
]
