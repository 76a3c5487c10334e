"""The prototype under control: MuJoCo moves the leg, the muscles and their air are stepped beside it."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from .arrays import Array, jax
from .control import SAMPLE_S, Control, Gains
from .gait import Gait
from .loop import STEP_S, STEPS, Log, Loop, Task, runge_kutta
from .muscle import Memory
from .pair import Air
from .pneumatics import ATMOSPHERE
from .prototype import Angles, Prototype
from .treadmill import Treadmill


@lru_cache(maxsize=2)
def _compiled(
    loop: Loop,
) -> tuple[Callable[..., tuple[Air, Array, Memory]], Callable[..., tuple[Array, Array, Control]]]:
    """A step of the muscles and their air, and a sample of the controller, for all runs of a loop."""
    pair = loop.pair
    values = pair.muscle.values()

    @jax.jit
    def step(
        memory: Memory, air: Air, time: Array, angle: Array, rate: Array, reference: Array
    ) -> tuple[Air, Array, Memory]:
        contraction, speed = pair.stroke(angle, rate)
        force, memory = pair.pull(values, memory, time, air.gauge_MPa, contraction, speed)
        stretch = speed / pair.muscle.specimen.initial_length_mm

        def slope(share: float, point: Air) -> Air:
            return pair.rates(point, reference * 1e6 + ATMOSPHERE, contraction + share * STEP_S * stretch, speed, 1.0)

        return runge_kutta(air, slope(0.0, air), slope), force, memory

    return step, jax.jit(loop.command)


def co_simulate(
    loop: Loop, gait: Gait, task: Task, gains: Gains, ground: Treadmill | None = None
) -> tuple[Log, list[Angles]]:
    """One run of `task` (its `ahead` (N, 2)) in the prototype, perhaps on a ground, and its angles at the N samples.

    In each step of the plant the muscles pull as they do at its begin, and their air sees the sprocket turn at the rate
    that it has there. Raises UsageError where MuJoCo is missing.
    """
    pair = loop.pair
    prototype = Prototype(pair.leg, gait, STEP_S, ground)
    state, memory, control = loop.begin(task)
    prototype.reset(float(state.flexion), float(state.rate))
    air = state.air
    step, command = _compiled(loop)
    rows, seen = [], []
    for k in range(len(task.target)):
        target, ahead, lesson = jax.tree.map(lambda a, k=k: np.asarray(a)[k], (task.target, task.ahead, task.lesson))
        now = prototype.angles()
        seen.append(now)
        split, reference, control = command(gains, control, now.knee, target, ahead, lesson)
        before, pulls = air, []
        for i in range(STEPS):
            time = k * SAMPLE_S + i * STEP_S
            at = prototype.angles()
            air, force, memory = step(memory, air, time, at.sprocket, at.sprocket_rate, reference)
            pulls.append(np.asarray(force))
            prototype.step(float(pair.torque(pulls[-1])), time)
        rows.append((now.knee, now.knee_rate, before.gauge_MPa, reference, pulls[0], before.opening, split))
    return Log(*(np.array([np.asarray(row[i]) for row in rows]) for i in range(len(Log._fields)))), seen
