"""A gait as a task for the controller: what is wanted at its samples, what the stand does meanwhile."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from .arrays import jax, jnp
from .control import SAMPLE_S, SIGN, Gains
from .feed_forward import FeedForward, PressurePlan
from .gait import Gait, LegAngles, Window
from .learning import PROBE, Lesson, inverse_of, series
from .loop import STEP_S, STEPS, Loop, Scale, Task

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Course:
    """A stride to run in, `lessons` strides to learn from, then the one that is judged, or a window of it."""

    gait: Gait
    window: Window | None = None
    lessons: int = 0

    @cached_property
    def time(self) -> Array:
        """Times of the controller's samples in s, shape (N,)."""
        stride = 1.0 / self.gait.cadence_Hz
        judged = stride if self.window is None else self.window.start_s + self.window.duration_s
        return SAMPLE_S * np.arange(round(((1 + self.lessons) * stride + judged) / SAMPLE_S))

    @cached_property
    def judged(self) -> slice:
        """The samples whose error counts."""
        count = (1.0 / self.gait.cadence_Hz if self.window is None else self.window.duration_s) / SAMPLE_S
        return slice(len(self.time) - round(count), len(self.time))

    @cached_property
    def imposed(self) -> LegAngles:
        """The gait at begin, middle and end of all steps of the plant, arrays of shape (N, STEPS, 3)."""
        steps = self.time[:, None] + STEP_S * np.arange(STEPS)
        return self.gait.at(jnp.asarray(steps[..., None] + STEP_S * np.array([0.0, 0.5, 1.0])))

    def plans(self, forward: FeedForward, sets: Any) -> PressurePlan:
        """Pressures for the middle of each interval of control, because a command rests until its end; for k sets of
        parameters, NumPy arrays with the k in front."""
        middle = jnp.asarray(self.time + 0.5 * SAMPLE_S)
        return jax.tree.map(np.asarray, forward.plans(sets, middle, self.gait.at(middle)))

    def task(self, ahead: Array) -> Task:
        """The task with gauge pressures `ahead` in MPa, (…, N, 2) or (2,), commanded before any correction."""
        target = self.gait.at(jnp.asarray(self.time)).knee.angle
        whole = np.broadcast_shapes(ahead.shape, (len(self.time), 2))
        return Task(target, np.broadcast_to(ahead, whole), self.imposed)

    def lesson(self, loop: Loop, ahead: Array, gains: Gains) -> Lesson:
        """How to learn where the plant is taken for `loop`, run with these pressures ahead (MPa, (N, 2))."""
        plain = replace(self, window=None, lessons=0)
        terms = series(plain.time * self.gait.cadence_Hz).T
        splits = PROBE * np.vstack([0.0 * terms[:1], terms])
        task = plain.task(ahead[: len(plain.time)] + splits[..., None] * SIGN)
        runs = len(splits)
        log = loop.batch(
            Gains(*(np.full(runs, gain) for gain in gains)), Scale(*np.ones((len(Scale._fields), runs))), task
        )
        stride = np.asarray(log.flexion)[:, plain.judged]
        inverse = inverse_of((stride[1:] - stride[0]).T / PROBE)
        phase = self.time * self.gait.cadence_Hz + 1e-9
        gain = inverse.T[(phase % 1.0 * stride.shape[1]).astype(int)]
        ends = np.append(np.diff(np.floor(phase)) > 0.0, False)
        return Lesson(series(phase), np.where(phase[:, None] < 1.0, 0.0, gain), ends)
