"""The prototype under control: MuJoCo moves the leg, the muscles and their air are stepped beside it."""

import numpy as np

from .arrays import Array, jax, jnp
from .control import SAMPLE_S, SIGN, Control, Gains, pid, start
from .gait import Gait
from .loop import STEP_S, STEPS, Log, Loop, Task, runge_kutta
from .muscle import Memory
from .pair import Air
from .pneumatics import ATMOSPHERE
from .prototype import Angles, Prototype


def co_simulate(loop: Loop, gait: Gait, task: Task, gains: Gains) -> tuple[Log, list[Angles]]:
    """One run of `task` (its `ahead` (N, 2)) in the prototype, and its angles at the N samples.

    In each step of the plant the muscles pull as they do at its begin, and their air sees the sprocket turn at the rate
    that it has there. Raises UsageError where MuJoCo is missing.
    """
    pair, sensor = loop.pair, loop.sensor
    prototype = Prototype(pair.leg, gait, STEP_S)
    state, memory = loop.begin(task)
    prototype.reset(float(state.flexion), float(state.rate))
    air = state.air
    values = pair.muscle.values()

    @jax.jit
    def step(
        memory: Memory, air: Air, time: Array, angle: Array, rate: Array, reference: Array
    ) -> tuple[Air, Array, Memory]:
        contraction, speed = pair.stroke(angle, rate)
        force, memory = pair.pull(values, memory, time, air, contraction, speed)
        stretch = speed / pair.muscle.specimen.initial_length_mm

        def slope(share: float, k: Air) -> Air:
            point = jax.tree.map(lambda y, d: y + share * STEP_S * d, air, k)
            return pair.rates(point, reference * 1e6 + ATMOSPHERE, contraction + share * STEP_S * stretch, speed, 1.0)

        k1 = slope(0.0, jax.tree.map(jnp.zeros_like, air))
        k2 = slope(0.5, k1)
        k3 = slope(0.5, k2)
        return runge_kutta(air, k1, k2, k3, slope(1.0, k3)), force, memory

    @jax.jit
    def correct(control: Control, flexion: Array, target: Array, ahead: Array) -> tuple[Array, Array, Control]:
        error = target - sensor.read(flexion)
        split, control = pid(gains, control, error, 0.5 * (ahead[0] - ahead[1]), pair.reach_MPa)
        return split, jnp.clip(ahead + split * SIGN, pair.lowest_MPa, pair.highest_MPa), control

    rows, seen = [], []
    control = start(task.target[0] - sensor.read(state.flexion))
    for k, (target, ahead) in enumerate(zip(np.asarray(task.target), np.asarray(task.ahead), strict=True)):
        now = prototype.angles()
        seen.append(now)
        split, reference, control = correct(control, now.knee, target, ahead)
        before, pulls = air, []
        for i in range(STEPS):
            time = k * SAMPLE_S + i * STEP_S
            at = prototype.angles()
            air, force, memory = step(memory, air, time, at.sprocket, at.sprocket_rate, reference)
            pulls.append(np.asarray(force))
            prototype.step(float(pulls[-1][0] - pulls[-1][1]) * pair.leg.sprocket_radius_m, time)
        gauge = (before.pressure - ATMOSPHERE) * 1e-6
        rows.append((now.knee, now.knee_rate, gauge, reference, pulls[0], before.opening, split))
    return Log(*(np.array([np.asarray(row[i]) for row in rows]) for i in range(len(Log._fields)))), seen
