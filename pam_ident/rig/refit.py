"""Least squares of the base laws alone, to know what a hidden effect leaves once the law has had its try."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from .muscle import Array, RigMuscle


def _columns(muscle: RigMuscle, p: Array, eps: Array, bend: float) -> Array:
    """Columns (n, k) of the law's linear part, `bend` its one nonlinear parameter (mu, or k1)."""
    if muscle.law.name == "exponential_law":
        decay = np.exp(-bend * eps)
        return np.column_stack([np.ones_like(p), p, eps, p * eps, decay, p * decay])
    theta0 = np.radians(muscle.specimen.braid_angle_deg)
    shape = 3 / np.tan(theta0) ** 2 * (1 - bend * eps) ** 2 - 1 / np.sin(theta0) ** 2
    return np.column_stack([p * shape, np.ones_like(p)])


def _residual(columns: Array, force: Array) -> Array:
    scale = np.linalg.norm(columns, axis=0)
    answer = np.linalg.lstsq(columns / scale, force, rcond=None)[0]
    return force - columns / scale @ answer


def law_residual(muscle: RigMuscle, p: Array, eps: Array, force: Array) -> Array:
    """Residual (N, (n,)) of the muscle's kind of law, all parameters refitted by separable least squares."""
    low, high = (5.0, 200.0) if muscle.law.name == "exponential_law" else (0.3, 3.0)

    def loss(log_bend: float) -> float:
        return float(np.sum(_residual(_columns(muscle, p, eps, float(np.exp(log_bend))), force) ** 2))

    grid = np.linspace(np.log(low), np.log(high), 9)
    values = [loss(g) for g in grid]
    best = int(np.argmin(values))
    around = (grid[max(best - 1, 0)], grid[min(best + 1, 8)])
    found = minimize_scalar(loss, bounds=around, method="bounded", options={"xatol": 1e-7})
    return _residual(_columns(muscle, p, eps, float(np.exp(found.x))), force)  # type: ignore[attr-defined]


def rms(values: Array) -> float:
    """Root of the mean square of values of any shape."""
    return float(np.sqrt(np.mean(values**2)))
