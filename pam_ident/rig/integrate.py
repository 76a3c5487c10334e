"""Small integrators on an uneven time grid, exact or implicit so that long holds keep them stable."""

from collections.abc import Callable

import numpy as np

from .muscle import Array


def fading(keep: Array, gain: Array) -> Array:
    """y, shape (m,), with y[i] = keep[i] y[i-1] + gain[i], from 0 before the first."""
    out, now = np.empty_like(gain), 0.0
    for i, (k, more) in enumerate(zip(keep.tolist(), gain.tolist(), strict=True)):
        out[i] = now = k * now + more
    return out


def follow(time: Array, drive: Array, tau: float) -> Array:
    """q' = (u - q)/tau from q = u at the start, shapes (m,); exact for u straight between grid points."""
    dt = np.maximum(np.diff(time), 1e-12)
    behind = np.diff(drive) / dt * tau * -np.expm1(-dt / tau)
    return drive - np.r_[0.0, fading(np.exp(-dt / tau), behind)]  # u - (u - q)


def stiff_path(time: Array, start: float, slope: Callable[[int, float], tuple[float, float]]) -> Array:
    """y(t), shape (m,), of y' = f(i, y) by exponential Rosenbrock-Euler steps; `slope` gives f and df/dy."""
    out = np.empty_like(time)
    y = out[0] = start
    for i, dt in enumerate(np.diff(time).tolist()):
        rate, stiffness = slope(i + 1, y)
        z = stiffness * dt
        y += rate * dt * (float(np.expm1(z)) / z if abs(z) > 1e-9 else 1.0)
        out[i + 1] = y
    return out


def travel_path(x: Array, start: float, slope: Callable[[float, float], float], substeps: int = 2) -> Array:
    """z(x), shape (m,), with dz/dx = slope(direction, z), a midpoint rule along the travelled way; at rest z stays."""
    out = np.empty_like(x)
    z = out[0] = start
    for i, dx in enumerate(np.diff(x).tolist()):
        if dx != 0.0:
            way, h = (1.0 if dx > 0 else -1.0), dx / substeps
            for _ in range(substeps):
                middle = z + 0.5 * h * slope(way, z)
                z += h * slope(way, middle)
        out[i + 1] = z
    return out
