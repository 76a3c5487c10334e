"""Small integrators on an uneven time grid, exact or implicit so that long holds keep them stable."""

from collections.abc import Callable

import numpy as np

from .muscle import Array


def follow(time: Array, drive: Array, tau: float) -> Array:
    """q' = (u - q)/tau from q = u at the start, shapes (m,); exact for u straight between grid points."""
    dt = np.maximum(np.diff(time), 1e-12)
    decay = np.exp(-dt / tau)
    behind = np.diff(drive) / dt * tau * -np.expm1(-dt / tau)
    lag, out = 0.0, np.empty_like(drive)
    out[0] = drive[0]
    for i, (a, b) in enumerate(zip(decay.tolist(), behind.tolist(), strict=True)):
        lag = a * lag + b  # lag = u - q
        out[i + 1] = lag
    out[1:] = drive[1:] - out[1:]
    return out


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
