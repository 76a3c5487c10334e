"""Muscles of a batch beside each other: how their parameters spread, which stand apart, what they follow."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..core import Array

if TYPE_CHECKING:
    import pandas as pd

OVER = {
    "specimen_initial_length_mm": "length (mm)",
    "specimen_diameter_mm": "diameter (mm)",
    "specimen_serial_number": "serial number",
}
FEWEST = 5
"""Muscles below which nothing is called an outlier or a trend."""
APART = 3.5
LEVEL = 0.01


@dataclass(frozen=True)
class Spread:
    """A quantity over the records of one branch: names, values and standard errors (NaN where unknown), shape (n,).

    `width` is 1.4826 times the median absolute deviation. `outlier` marks what lies more than 3.5 of that from the
    median (Iglewicz & Hoaglin 1993, How to Detect and Handle Outliers).
    """

    quantity: str
    unit: str
    branch: str
    records: Array
    value: Array
    stderr: Array
    median: float
    width: float
    outlier: Array

    @property
    def stderr_median(self) -> float:
        """What the scatter of repeated records of one muscle should be; NaN where no error is known."""
        known = self.stderr[np.isfinite(self.stderr)]
        return float(np.median(known)) if len(known) else float("nan")


@dataclass(frozen=True)
class Trend:
    """A spread over what the muscles differ in: Spearman's correlation and its p, `p_all` after Holm's correction for
    all trends looked at, and the line of Theil and Sen (`slope` in the quantity's unit per unit of `over`)."""

    spread: Spread
    over: str
    x: Array
    correlation: float
    p: float
    p_all: float
    slope: float
    intercept: float

    @property
    def found(self) -> bool:
        """Whether chance makes as much of it in less than one batch of a hundred."""
        return self.p_all < LEVEL


def spreads(frame: "pd.DataFrame", units: dict[str, str]) -> tuple[Spread, ...]:
    """Every parameter, and the error of the fit, by branch; `units` names the parameters."""
    names = [name for name in units if not name.endswith("_stderr")]
    found = []
    for branch, rows in frame.groupby("branch", sort=True):
        for name in ("rmse_N", *names):
            value = np.asarray(rows[name], float)
            error = rows.get(f"{name}_stderr")
            stderr = np.full(len(rows), np.nan) if error is None else np.asarray(error, float)
            keep = np.isfinite(value) & np.asarray(rows["error"].isna())
            if keep.any():
                records = np.asarray(rows["record"], object)[keep]
                found.append(_spread(name, units.get(name, "N"), str(branch), records, value[keep], stderr[keep]))
    return tuple(found)


def _spread(name: str, unit: str, branch: str, records: Array, value: Array, stderr: Array) -> Spread:
    median = float(np.median(value))
    away = np.abs(value - median)
    width = 1.4826 * float(np.median(away))
    outlier = (away > APART * width) & (len(value) >= FEWEST) & (width > 0.0)
    return Spread(name, unit, branch, records, value, stderr, median, width, outlier)


def trends(frame: "pd.DataFrame", found: Sequence[Spread]) -> tuple[Trend, ...]:
    """Each spread over each property in which its muscles differ, the surest first."""
    from scipy.stats import spearmanr, theilslopes

    seen = []
    for spread in found:
        rows = frame[frame["branch"] == spread.branch].set_index("record").loc[spread.records]
        for column, over in OVER.items():
            x = rows[column].to_numpy(float)
            known = np.isfinite(x)
            x, y = x[known], spread.value[known]
            if len(x) < FEWEST or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
                continue
            (rho, p), (slope, intercept, *_) = np.asarray(spearmanr(x, y)), np.asarray(theilslopes(y, x))
            part = replace(spread, **{k: getattr(spread, k)[known] for k in ("records", "value", "stderr", "outlier")})
            seen.append(Trend(part, over, x, float(rho), float(p), 1.0, float(slope), float(intercept)))
    seen.sort(key=lambda trend: trend.p)
    p_all = np.maximum.accumulate([trend.p * (len(seen) - k) for k, trend in enumerate(seen)] or [0.0])
    return tuple(replace(trend, p_all=min(float(p), 1.0)) for trend, p in zip(seen, p_all, strict=False))
