"""Sensor noise of several colours, the temperature of the day, and what a logger makes of a table.

Every fault changes the table (n, 7), in the order of record.COLUMNS, in place. A cell that is NaN is written empty, and
a row whose time is NaN is not written.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from .integrate import fading
from .muscle import Array

COLOURS = ("white", "ar1", "ou", "slow", "pink", "heavy", "growing")
GAUGES = {"good": (0.0002, 0.01), "noisy_pressure": (0.001, 0.01), "noisy_length": (0.0002, 0.04)}
"""Noise of the gauge in MPa and of the length sensor in mm."""
TIME, PRESSURE, LENGTH, FORCE = 0, 3, 4, 5
Fault = Callable[[Array, np.random.Generator], None]


@dataclass(frozen=True)
class RigSensors:
    """rms of the force noise (N) and its colour; pressure noise (MPa), displacement noise (mm)."""

    sigma_N: float = 2.0
    colour: str = "white"
    pressure_MPa: float = 0.0002
    displacement_mm: float = 0.01

    def __post_init__(self) -> None:
        if self.colour not in COLOURS:
            raise ValueError(f"colour {self.colour!r}: one of {', '.join(COLOURS)}")
        if min(self.sigma_N, self.pressure_MPa, self.displacement_mm) < 0:
            raise ValueError("noise cannot be negative")

    def force_noise(self, time: Array, pressure: Array, rng: np.random.Generator) -> Array:
        """Force noise (N) at the logged instants (n,), of rms sigma whatever its colour."""
        if self.colour == "growing":
            return self.sigma_N * pressure / float(np.sqrt(np.mean(pressure**2))) * rng.standard_normal(len(time))
        return self.sigma_N * _colour(self.colour, time, rng)


def ornstein_uhlenbeck(time: Array, tau: float, rng: np.random.Generator) -> Array:
    """Unit-variance Ornstein-Uhlenbeck noise at uneven instants (n,)."""
    keep = np.exp(-np.diff(time, prepend=time[0] - 50 * tau) / tau)
    kicks = rng.standard_normal(len(time)) * np.sqrt(1 - keep**2)
    return fading(keep, kicks)


def _colour(colour: str, time: Array, rng: np.random.Generator) -> Array:
    n = len(time)
    if colour == "white":
        return rng.standard_normal(n)
    if colour == "heavy":
        return rng.standard_t(3.0, n) / np.sqrt(3.0)
    if colour == "pink":  # a sum of wanders, each with the same variance: about 1/f
        wanders = [ornstein_uhlenbeck(time, tau, rng) for tau in (0.1, 0.5, 2.5, 12.0, 60.0)]
        return np.sum(wanders, axis=0) / np.sqrt(len(wanders))
    if colour == "ar1":
        rho = rng.uniform(0.5, 0.95)
        kicks = rng.standard_normal(n) * np.sqrt(1 - rho**2)
        kicks[0] /= np.sqrt(1 - rho**2)
        return np.asarray(lfilter([1.0], [1.0, -rho], kicks))
    if colour == "ou":
        return ornstein_uhlenbeck(time, float(np.exp(rng.uniform(np.log(0.5), np.log(10.0)))), rng)
    share = rng.uniform(0.1, 0.3)
    slow = ornstein_uhlenbeck(time, rng.uniform(20.0, 100.0), rng)
    return np.sqrt(1 - share) * rng.standard_normal(n) + np.sqrt(share) * slow


def temperature_course(time: Array, rng: np.random.Generator, warming: bool) -> Array:
    """Temperature (deg C), shape (m,): a slow ripple of the room, and a run-in of 12 to 18 K where warming."""
    start, ripple, period = rng.uniform(22.0, 25.0), rng.uniform(0.05, 0.25), rng.uniform(60.0, 400.0)
    out = start + ripple * np.sin(2 * np.pi * time / period + rng.uniform(0, 2 * np.pi))
    if warming:
        out += -rng.uniform(12.0, 18.0) * np.expm1(-(time - time[0]) / rng.uniform(150.0, 400.0))
    return out


def _some(n: int, share: float, rng: np.random.Generator) -> NDArray[np.intp]:
    return rng.choice(n, max(int(share * n), 1), replace=False)


def _spikes(table: Array, rng: np.random.Generator) -> None:
    """Two samples in a thousand of the force are off by 50 to 500 N."""
    rows = _some(len(table), 0.002, rng)
    table[rows, FORCE] += rng.choice([-1.0, 1.0], len(rows)) * rng.uniform(50.0, 500.0, len(rows))


def _empty_cells(table: Array, rng: np.random.Generator) -> None:
    """One in a hundred cells of pressure, length or force is empty."""
    for column in (PRESSURE, LENGTH, FORCE):
        table[_some(len(table), 0.01, rng), column] = np.nan


def _lost_rows(table: Array, rng: np.random.Generator) -> None:
    """One row in twenty was never written."""
    table[_some(len(table), 0.05, rng), TIME] = np.nan


def _jitter(table: Array, rng: np.random.Generator) -> None:
    """The clock is read up to a fifth of a step too late."""
    steps = np.diff(table[:, TIME], append=table[-1, TIME] + 0.01)
    table[:, TIME] = np.round(table[:, TIME] + 0.2 * rng.uniform(0.0, 1.0, len(table)) * np.clip(steps, 0.0, 0.2), 5)


def _coarse(table: Array, rng: np.random.Generator) -> None:
    """A logger of 12 bits: 1 N, 0.05 mm, 0.5 kPa."""
    for column, step in ((PRESSURE, 0.0005), (LENGTH, 0.05), (FORCE, 1.0)):
        table[:, column] = np.round(table[:, column] / step) * step


def _clipped(table: Array, rng: np.random.Generator) -> None:
    """The load cell ends at 85 to 95 % of the largest force."""
    table[:, FORCE] = np.minimum(table[:, FORCE], np.round(rng.uniform(0.85, 0.95) * table[:, FORCE].max(), 3))


FAULTS: dict[str, Fault] = {
    "spikes": _spikes,
    "empty_cells": _empty_cells,
    "lost_rows": _lost_rows,
    "jitter": _jitter,
    "coarse": _coarse,
    "clipped": _clipped,
}
