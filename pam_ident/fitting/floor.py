"""What repeated cycles say: how large the noise is, and whether a fit leaves more than that."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre

from ..core import Array, Inputs
from ..records import Record
from .fit import Fit

SHAPES = 4
"""Coefficients of each stroke in which a lack of fit is looked for."""
SAME_COURSE = 0.05
"""Share of their ranges within which pressure and contraction of two strokes are the same."""


@dataclass(frozen=True)
class RepeatNoise:
    """Noise from strokes that repeat each other: standard deviation `sigma` in N, and `memory`, the number of samples
    that count as one because they are correlated. `strokes` in `groups` of one isobar, branch and speed."""

    sigma: float
    memory: float
    strokes: int
    groups: int


@dataclass(frozen=True)
class LackOfFit:
    """F test of what a fit leaves in the mean of repeated strokes against how the strokes differ."""

    statistic: float
    freedom: tuple[float, float]
    p_value: float

    @property
    def adequate(self) -> bool:
        """Whether nothing more than noise is left, at a level of 1 %."""
        return self.p_value > 0.01


def repeats(record: Record, rows: Array, at_rest: bool = False) -> list[list[tuple[Array, Array]]]:
    """Groups of two strokes or more of one isobar, branch and speed, of at least 3 · SHAPES samples of `rows` each.
    Where the pressure is driven, one course of it and of the length stands for the isobar.

    Of each stroke its rows, and its contraction scaled to −1 … 1 over the group. `rows` is a mask (n,). `at_rest`
    takes the holds behind those strokes instead, of SHAPES samples at least, by the time in s since each began.
    """
    inputs = record.inputs
    if inputs.moving is None or inputs.stroke_speed is None:
        return []
    usable = np.flatnonzero(rows & (inputs.moving != at_rest))
    usable = usable[np.argsort(record.stroke[usable], kind="stable")]
    edges = np.flatnonzero(np.diff(record.stroke[usable])) + 1
    strokes = [s for s in np.split(usable, edges) if len(s) >= (1 if at_rest else 3) * SHAPES]
    driven = _states(inputs)
    alike: dict[tuple[float, float, int], list[Array]] = {}
    for s in strokes:
        # Drives repeat a speed roughly: those in a quarter of its logarithm count as the same.
        pace = round(4.0 * np.log(max(float(inputs.stroke_speed[s[0]]), 1e-9)))
        held = 0.0 if driven is not None else float(record.level[s[0]])
        alike.setdefault((held, float(inputs.direction[s[0]]), pace), []).append(s)
    if driven is not None:
        alike = {(k, 0.0, 0): group for k, group in enumerate(_one_course(driven, alike.values()))}
    found = []
    for group in alike.values():
        if at_rest and len(group) >= 2 and inputs.time is not None:
            found.append([(s, inputs.time[s] - inputs.time[s[0]]) for s in group])
            continue
        reach = np.concatenate([inputs.way[s] for s in group])
        low, span = reach.min(), np.ptp(reach)
        if len(group) >= 2 and span > 0:
            found.append([(s, 2.0 * (inputs.way[s] - low) / span - 1.0) for s in group])
    return found


def _states(inputs: Inputs) -> Array | None:
    """Pressure and contraction in their ranges, shape (n, 2), where the pressure is driven, else None."""
    if inputs.pressure_rate is None:
        return None
    states = np.column_stack([inputs.pressure, inputs.contraction])
    return states / np.maximum(np.ptp(states, axis=0), 1e-12)


def _one_course(states: Array, groups: Iterable[list[Array]]) -> Iterator[list[Array]]:
    """Strokes of each group apart by where in pressure and contraction they begin, are half-way, and end."""
    for group in groups:
        apart: list[tuple[Array, list[Array]]] = []
        for s in group:
            course = states[s[[0, len(s) // 2, -1]]]
            same = next((found for first, found in apart if np.abs(course - first).max() < SAME_COURSE), None)
            if same is None:
                apart.append((course, [s]))
            else:
                same.append(s)
        yield from (found for _, found in apart)


def nearest(x: Array, y: Array) -> Array:
    """Which of y (m ≥ 2,) is nearest to each of x (n,): indices, shape (n,)."""
    order = np.argsort(y)
    right = np.clip(np.searchsorted(y[order], x), 1, len(y) - 1)
    return order[np.where(x - y[order[right - 1]] < y[order[right]] - x, right - 1, right)]


def repeat_noise(fit: Fit) -> RepeatNoise | None:
    """Noise of the record behind a fit, from strokes of one isobar, branch and speed; None without repeats.

    Each stroke is taken from the next of its group, at the sample of the nearest contraction, so that neither the
    fit's own faults nor correlation along a stroke is counted. Noise slower than a cycle is missed.

    Args:
        fit: of any model; its residual in N takes the force's course out, so that neighbours can be compared.

    Example:
        >>> from pam_ident.fitting import fit
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.fitting import repeat_noise
        >>> from pam_ident.records.datasets import dataset_record
        >>> found = fit(Model.build("exponential_law"), read_record(dataset_record("hidden_effect")))
        >>> print(f"{found.rmse:.1f} N are left, repeats differ by {repeat_noise(found).sigma:.1f} N")
        6.3 N are left, repeats differ by 2.1 N
    """
    groups = repeats(fit.record, fit.rows)
    squares, samples, lags = 0.0, 0, np.zeros(41)
    for group in groups:
        for (one, x), (other, y) in pairwise(group):
            apart = fit.residual[one] - fit.residual[other[nearest(x, y)]]
            squares, samples = squares + 0.5 * float(apart @ apart), samples + len(apart)
            for k in range(min(len(lags), len(apart) // 2)):
                lags[k] += float(apart[: len(apart) - k] @ apart[k:])
    if not samples:
        return None
    memory = _memory(lags / max(lags[0], 1e-300))
    return RepeatNoise(float(np.sqrt(squares / samples)), memory, sum(map(len, groups)), len(groups))


def _memory(correlation: Array) -> float:
    """1 + 2 Σ correlations, summed while they stay positive (Geyer 1992, Statistical Science 7, 473–483)."""
    negative = np.flatnonzero(correlation < 0.02)
    end = int(negative[0]) if len(negative) else len(correlation)
    return float(1.0 + 2.0 * correlation[1:end].sum())


def lack_of_fit(fit: Fit) -> LackOfFit | None:
    """Whether the fit leaves more than noise in the mean of repeated strokes, or of the holds behind them; None with
    too few repeats.

    The residual of each stroke is summed up in four Legendre coefficients over contraction, that of a hold in two over
    time. Their means over the repeats are tested against their scatter, so that correlation within a stroke does no
    harm (trace of Lawley and Hotelling, F by McKeon 1974, Biometrika 61, 381–383; the fitted parameters are taken off
    its freedom).

    Args:
        fit: of any model to a record in time.

    Example:
        >>> from pam_ident.fitting import fit
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.fitting import lack_of_fit
        >>> from pam_ident.records.datasets import dataset_record
        >>> law = Model.build("exponential_law")
        >>> for name in ("hidden_effect", "nothing_hidden"):
        ...     print(name, lack_of_fit(fit(law, read_record(dataset_record(name)))).adequate)
        hidden_effect False
        nothing_hidden True
    """
    strokes, holds = (repeats(fit.record, fit.rows, at_rest) for at_rest in (False, True))
    holds = [[(s, 2.0 * t / max(t[-1], 1e-9) - 1.0) for s, t in group] for group in holds]
    # Parameters are fitted to strokes above all, so that all of them are taken off there, and none of the holds.
    tests = (_lack(fit, strokes, SHAPES, len(fit.free)), _lack(fit, holds, SHAPES // 2, 0))
    found = [test for test in tests if test is not None]
    if not found:
        return None
    worst = min(found, key=lambda test: test.p_value)
    return replace(worst, p_value=min(len(found) * worst.p_value, 1.0))  # Bonferroni: of two tests the lower p


def _lack(fit: Fit, groups: list[list[tuple[Array, Array]]], shapes: int, fitted: int) -> LackOfFit | None:
    """The test in the first `shapes` coefficients of each stroke, or of each hold, less those `fitted`; None with too
    few repeats."""
    from scipy.special import fdtrc

    error = sum(len(g) for g in groups) - len(groups)
    p = min(shapes, error - 5)
    if p < 1 or p * len(groups) <= fitted:
        return None
    means, scatter = [], np.zeros((p, p))
    for group in groups:
        sums = np.array([_coefficients(x, fit.residual[s], p) for s, x in group])
        means.append(sums.mean(axis=0) * np.sqrt(len(group)))
        scatter += (sums - sums.mean(axis=0)).T @ (sums - sums.mean(axis=0))
    hypothesis = np.array(means).T @ np.array(means)
    trace = float(np.trace(np.linalg.lstsq(scatter, hypothesis, rcond=1e-12)[0]))
    h, v = len(groups), error
    b = (v + h - p - 1) * (v - 1) / ((v - p - 3) * (v - p))
    second = 4.0 + (p * h + 2.0) / (b - 1.0)
    first = float(p * h - fitted)
    statistic = trace * (v - p - 1) * second / (first * (second - 2.0))
    return LackOfFit(statistic, (first, second), float(fdtrc(first, second, statistic)))


def _coefficients(x: Array, residual: Array, p: int) -> Array:
    """Legendre coefficients of a stroke's residual times the root of its samples, so that all scatter alike."""
    return np.linalg.lstsq(legendre.legvander(x, p - 1), residual, rcond=None)[0] * np.sqrt(len(x))
