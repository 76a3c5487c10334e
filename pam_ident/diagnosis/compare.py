"""Where a model fails: error over pressure, contraction, branch, speed, cycle and time."""

import itertools
import math
from dataclasses import replace

import numpy as np

from ..core.digits import newtons, number, percent
from ..fitting import Fit
from .follows import Following
from .nouns import Bin, Comparison, Follows, Region
from .sentence import told

Array = np.ndarray
CELLS = 10
NAMES = {1.0: "contraction", -1.0: "extension", 0.0: "static"}
WHILE = {"contraction": ", contracting", "extension": ", extending", "static": ""}


def compare(fit: Fit, follows: tuple[Follows, ...] | None = None) -> Comparison:
    """Where a fit fails: its squared error by place, and the share that is odd or even in the branch.

    Args:
        fit: of any model. Errors of the answer are in N, by isobar, or tenths of a pressure that was driven, by branch
            and by ten equal parts of the contraction.
        follows: what its error follows, where that is known; else it is worked out, which takes longer than the rest.

    Example:
        >>> from pam_ident.diagnosis import compare
        >>> from pam_ident.fitting import fit
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> found = compare(fit(Model.build("exponential_law"), read_record(dataset_record("hidden_effect"))))
        >>> print(f"worst at {found.worst[0].pressure_MPa} MPa; {found.odd:.0%} odd in the branch")
        worst at 0.5 MPa; ...% odd in the branch
    """
    record, rows = fit.record.in_tenths(), fit.rows
    if record is not fit.record:
        fit = replace(fit, record=record)
    residual = fit.residual
    direction, contraction = record.inputs.direction, record.inputs.contraction
    total = max(float(np.sum(residual[rows] ** 2)), 1e-300)
    signs = [s for s in (1.0, -1.0, 0.0) if np.any(direction[rows] == s)]
    levels = np.unique(record.level[rows])
    edges = contraction_edges(contraction[rows])
    cell = np.clip(np.searchsorted(edges, contraction, side="right") - 1, 0, len(edges) - 2)
    shape = (len(signs), len(levels), len(edges) - 1)
    mean, rms, share = np.full(shape, math.nan), np.full(shape, math.nan), np.full(shape, math.nan)
    regions: list[Region] = []
    for b, sign in enumerate(signs):
        for p, level in enumerate(levels):
            for c in range(len(edges) - 1):
                here = rows & (direction == sign) & (record.level == level) & (cell == c)
                if not here.any():
                    continue
                part = residual[here]
                mean[b, p, c], rms[b, p, c] = part.mean(), np.sqrt(np.mean(part**2))
                share[b, p, c] = np.sum(part**2) / total
                span = (float(edges[c]), float(edges[c + 1]))
                regions.append(
                    Region(float(level), span, NAMES[sign], len(part), mean[b, p, c], rms[b, p, c], share[b, p, c])
                )
    worst = tuple(sorted(regions, key=lambda r: -r.share)[:5])
    odd, even = _odd_even(fit, cell, len(levels), total)
    rest = 1.0 - (odd or 0.0) - (even or 0.0) if odd is not None else math.nan
    by = _profiles(fit, signs, levels, edges, total)
    follows = Following.of(fit).shares() if follows is None else follows
    sentence = f"{_sentence(fit, by, odd, even, worst)} {told(follows)}"
    branches = tuple(NAMES[s] for s in signs)
    return Comparison(fit, branches, levels, edges, mean, rms, share, by, odd, even, rest, worst, follows, sentence)


def contraction_edges(contraction: Array) -> Array:
    """Edges (cells + 1,) of cells over contraction (n,): around each value of a table of few lengths, else ten."""
    values = np.unique(np.round(contraction, 4))
    if len(values) == 1:
        return np.array([values[0] - 0.005, values[0] + 0.005])
    if len(values) <= 2 * CELLS:
        middle = 0.5 * (values[1:] + values[:-1])
        return np.r_[values[0] - (middle[0] - values[0]), middle, values[-1] + (values[-1] - middle[-1])]
    return np.linspace(contraction.min(), contraction.max() + 1e-9, CELLS + 1)


def _odd_even(fit: Fit, cell: Array, levels: int, total: float) -> tuple[float | None, float | None]:
    """Shares of the squared error that change sign with the branch, and that do not, cell by cell."""
    record, residual = fit.record, fit.residual
    direction = record.inputs.direction
    odd = even = 0.0
    both = False
    _, level = np.unique(record.level, return_inverse=True)
    speed = record.inputs.stroke_speed
    pace = np.zeros(len(record), int) if speed is None else np.round(np.log2(np.maximum(speed, 1e-3))).astype(int)
    place = level * 1000 + cell
    # At one speed where both branches have it, else at any: a drive may be slower one way than the other.
    _, at_pace = np.unique(place * 100 + (pace - pace.min()), return_inverse=True)
    ways = [np.bincount(at_pace, fit.rows & (sign * direction > 0)) > 0 for sign in (1, -1)]
    key = np.where((ways[0] & ways[1])[at_pace], at_pace, -1 - place)
    for k in np.unique(key[fit.rows]):
        here = fit.rows & (key == k)
        up, down = residual[here & (direction > 0)], residual[here & (direction < 0)]
        if not len(up) or not len(down):
            continue
        both = True
        one, other = float(up.mean()), float(down.mean())
        squares = len(up) * one**2 + len(down) * other**2
        # Where one branch has more samples than the other the two overlap; what the cell's means hold is shared out.
        part = (one - other) ** 2 / max(2.0 * (one**2 + other**2), 1e-300)
        odd += part * squares
        even += (1.0 - part) * squares
    return (odd / total, even / total) if both else (None, None)


def _profiles(fit: Fit, signs: list[float], levels: Array, edges: Array, total: float) -> dict[str, tuple[Bin, ...]]:
    record, inputs = fit.record, fit.record.inputs
    found: dict[str, tuple[Bin, ...]] = {
        "pressure_MPa": tuple(_bin(fit, record.level == v, f"{v:g} MPa", v, v, total) for v in levels),
        "contraction": tuple(
            _bin(fit, (inputs.contraction >= a) & (inputs.contraction < b), _span(a, b), a, b, total)
            for a, b in itertools.pairwise(edges)
        ),
        "branch": tuple(_bin(fit, inputs.direction == s, NAMES[s], s, s, total) for s in signs),
    }
    if inputs.stroke_speed is not None:
        pace = np.round(np.log2(np.maximum(inputs.stroke_speed, 1e-3)) * 2.0)
        found["speed_mm_s"] = tuple(
            _bin(
                fit,
                pace == v,
                f"{number(float(np.median(inputs.stroke_speed[pace == v])), 3)} mm/s",
                2 ** (v / 2 - 0.25),
                2 ** (v / 2 + 0.25),
                total,
            )
            for v in np.unique(pace)
        )
    if inputs.cycle is not None and len(np.unique(inputs.cycle)) > 1:
        found["cycle"] = tuple(
            _bin(fit, inputs.cycle == v, f"cycle {v:g}", v, v, total) for v in np.unique(inputs.cycle)[:30]
        )
    if len(runs := np.unique(record.run)) > 1:
        found["run"] = tuple(_bin(fit, record.run == k, record.run_name(int(k)), k, k, total) for k in runs)
    if inputs.time is not None:
        marks = np.linspace(inputs.time[0], inputs.time[-1] + 1e-9, 11)
        found["time_s"] = tuple(
            _bin(fit, (inputs.time >= a) & (inputs.time < b), f"{a:.0f} to {b:.0f} s", a, b, total)
            for a, b in itertools.pairwise(marks)
        )
    return {key: tuple(b for b in bins if b.n) for key, bins in found.items()}


def _bin(fit: Fit, mask: Array, label: str, low: float, high: float, total: float) -> Bin:
    part = fit.residual[fit.rows & mask]
    if not len(part):
        return Bin(label, float(low), float(high), 0, math.nan, math.nan, 0.0)
    square = float(np.sum(part**2))
    return Bin(
        label, float(low), float(high), len(part), float(part.mean()), math.sqrt(square / len(part)), square / total
    )


def _span(low: float, high: float) -> str:
    """Two contraction ratios in words; a rounded minus zero is zero."""
    return f"{round(low, 3) + 0.0:.3f} to {round(high, 3) + 0.0:.3f}"


def _sentence(
    fit: Fit, by: dict[str, tuple[Bin, ...]], odd: float | None, even: float | None, worst: tuple[Region, ...]
) -> str:
    worst_pressure = max(by["pressure_MPa"], key=lambda b: b.share)
    top = worst[0]
    text = (
        f"The {fit.model.words} misses the measurement by {newtons(fit.rmse)} rms (at most {newtons(fit.max_error)}). "
        f"{percent(worst_pressure.share)} of the squared error lies at {worst_pressure.label}; the worst cell is "
        f"{top.pressure_MPa:g} MPa, contraction {_span(*top.contraction)}{WHILE[top.branch]} "
        f"({newtons(top.rms)} rms, {percent(top.share)} of the squared error, "
        f"the model {'below' if top.mean > 0 else 'above'} the data)."
    )
    if odd is not None and even is not None:
        text += (
            f" {percent(odd)} of the squared error changes sign with the branch, "
            f"{percent(even)} is the same on both, "
            f"{percent(max(0.0, 1 - odd - even))} is neither."
        )
    return text
