"""Bootstrap: how the parameters scatter over records drawn again from this one."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..core import Array, FitError, UsageError
from .covariance import LEVEL
from .fit import Fit
from .refit import refit_forces, refit_weights

PART = 250
"""Draws that are refitted together, whoever does it, because sums round by what they are summed with."""


@dataclass(frozen=True)
class Bootstrap:
    """B refits of a fit: `values` (B, k) of the fitted parameters `names`; `singly` were refitted one by one."""

    names: tuple[str, ...]
    values: Array
    by: str
    seed: int
    singly: int

    @property
    def stderr(self) -> dict[str, float]:
        """Standard deviation of each parameter over the refits."""
        return dict(zip(self.names, map(float, self.values.std(axis=0, ddof=1)), strict=True))

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each parameter by percentiles (Efron & Tibshirani 1993, ch. 13)."""
        ends = np.quantile(self.values, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=0)
        return {n: (float(a), float(b)) for n, a, b in zip(self.names, *ends, strict=True)}


Draws = tuple[Array, Array]
"""Number of the cycle of each fitted row, shape (m,), and how often each cycle is drawn, shape (draws, cycles)."""
Refit = Callable[[list[Draws]], list[tuple[Array, int]]]
"""What `refit_weights` says of each of some parts of the draws."""


def bootstrap(fit: Fit, n: int = 1000, by: str = "cycle", seed: int = 0, refit: Refit | None = None) -> Bootstrap:
    """Refit to `n` records drawn from the fitted one: whole cycles with replacement, or residuals put back shuffled.

    By cycle is right where residuals are correlated along a stroke (Cameron, Gelbach & Miller 2008, Rev. Economics and
    Statistics 90, 414–427); by residual only where they are white. In a static table its lengths or isobars take the
    place of cycles, which are refitted PART at a time, by `refit` if given.

    Raises UsageError for an unknown way to draw or a count below 2, FitError when a parameter is not determined or
    there are fewer than four cycles to draw from.
    """
    if by not in ("cycle", "residual") or n < 2:
        raise UsageError(f"bootstrap of {n} by {by!r}: expected at least 2, by cycle or residual")
    if fit.problems:
        raise FitError(f"nothing to bootstrap: {'; '.join(fit.problems)}")
    rng = np.random.default_rng(seed)
    rows = fit.rows
    if by == "residual":
        left = fit.residual[rows] * np.sqrt(rows.sum() / max(rows.sum() - len(fit.free), 1))
        forces = fit.force[rows, None] + rng.choice(left - left.mean(), (int(rows.sum()), n))
        values, singly = refit_forces(fit, forces)
    else:
        names, block = np.unique(fit.record.block[rows], return_inverse=True)
        if len(names) < 4:
            kind = fit.record.block_kind
            raise FitError(f"{len(names)} {kind}s to draw from; a bootstrap by {kind}s needs four or more")
        counts = rng.multinomial(len(names), np.full(len(names), 1.0 / len(names)), n).astype(float)
        parts = [(block, counts[k : k + PART]) for k in range(0, n, PART)]
        found = [refit_weights(fit, *part) for part in parts] if refit is None else refit(parts)
        values, singly = np.concatenate([part for part, _ in found]), sum(alone for _, alone in found)
    return Bootstrap(tuple(e.name for e in fit.estimates if e.name not in fit.held), values, by, seed, singly)
