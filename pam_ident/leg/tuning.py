"""Gains of the PID: found by hand, as the paper did, and automatically, robust to a plant that is a fifth off."""

from dataclasses import dataclass

import numpy as np

from ..core.progress import steps
from .control import Gains
from .loop import Log, Loop, Scale, Task

Array = np.ndarray
FIRST = Gains(0.1, 0.1, 0.001)
"""Where a person begins: weak gains that do no harm."""
LOWEST, HIGHEST = Gains(0.02, 0.02, 1e-4), Gains(10.0, 100.0, 0.5)
POPULATION, GENERATIONS, KEPT = 64, 6, 12
LOST_DEG = 1e3
"""Stands for the error of a run that has no end."""
_OFF = (("force", 0.8), ("force", 1.2), ("inertia", 0.8), ("inertia", 1.2), ("flow", 0.8), ("flow", 1.2))
PLANTS = (Scale(), *(Scale(**{name: share}) for name, share in _OFF))
"""The plant as it is, and with force, inertia or flow a fifth smaller or larger."""


@dataclass(frozen=True)
class Tuned:
    """Gains, how many runs it took to find them, and the rms error in degrees on the plant as it is and on the worst of
    PLANTS."""

    gains: Gains
    runs: int
    rms_deg: float
    worst_deg: float


def rms_deg(log: Log, task: Task, judged: slice) -> Array:
    """Root mean square tracking error in degrees over the samples judged, shape of the leading axes of the log."""
    error = np.degrees(np.asarray(log.flexion)[..., judged] - np.asarray(task.target)[judged])
    found = np.sqrt(np.mean(error**2, axis=-1))
    return np.where(np.isfinite(found), np.minimum(found, LOST_DEG), LOST_DEG)


def errors(loop: Loop, task: Task, judged: slice, gains: Array, plants: tuple[Scale, ...] = PLANTS) -> Array:
    """Rms errors in degrees of gain sets (k, 3) on each of `plants`, shape (k, plants); `task.ahead` is (N, 2)."""
    count = len(gains) * len(plants)
    rows = Gains(*np.repeat(gains, len(plants), axis=0).T)
    scales = Scale(*np.tile(np.array(plants), (len(gains), 1)).T)
    ahead = np.broadcast_to(np.asarray(task.ahead), (count, *task.ahead.shape))
    log = loop.batch(rows, scales, task._replace(ahead=ahead))
    return rms_deg(log, task, judged).reshape(len(gains), len(plants))


def judge(loop: Loop, task: Task, judged: slice, gains: Gains, runs: int = 0) -> Tuned:
    """Gains with their errors."""
    found = errors(loop, task, judged, np.array([gains]))[0]
    return Tuned(gains, runs, float(found[0]), float(found.max()))


def tune_by_hand(loop: Loop, task: Task, judged: slice) -> Tuned:
    """One gain after the other, doubled as long as the error falls, on the plant as it is: trial and error.

    Proportional first, then derivative, then integral, once through.
    """
    gains = np.array(FIRST)
    best, runs = float(errors(loop, task, judged, gains[None], PLANTS[:1])[0, 0]), 1
    for k in (0, 2, 1):
        while gains[k] < HIGHEST[k]:
            trial = gains * np.where(np.arange(3) == k, 2.0, 1.0)
            found = float(errors(loop, task, judged, trial[None], PLANTS[:1])[0, 0])
            runs += 1
            if found >= best:
                break
            gains, best = trial, found
    return judge(loop, task, judged, Gains(*gains.tolist()), runs)


def tune(loop: Loop, task: Task, judged: slice, known: Gains, seed: int = 1) -> Tuned:
    """Gains with the least rms error on the worst of PLANTS, by the cross-entropy method (Rubinstein 1999, Methodology
    and Computing in Applied Probability 1, 127–190) in the logarithms of the gains; a generation is one batch.

    What comes out is no worse there than the gains `known`, which are tried first.
    """
    rng = np.random.default_rng(seed)
    low, high = np.log(np.array(LOWEST)), np.log(np.array(HIGHEST))
    middle, spread = 0.5 * (low + high), 0.4 * (high - low)
    best = np.array(known)
    least = float(errors(loop, task, judged, best[None]).max())
    for _ in steps(range(GENERATIONS), "tuning"):
        trials = np.clip(middle + spread * rng.standard_normal((POPULATION, 3)), low, high)
        worst = errors(loop, task, judged, np.exp(trials)).max(axis=1)
        order = np.argsort(worst)[:KEPT]
        middle, spread = trials[order].mean(axis=0), trials[order].std(axis=0) + 0.02
        if worst[order[0]] < least:
            best, least = np.exp(trials[order[0]]), float(worst[order[0]])
    return judge(loop, task, judged, Gains(*best.tolist()), (1 + POPULATION * GENERATIONS) * len(PLANTS))
