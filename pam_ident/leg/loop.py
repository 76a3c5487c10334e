"""The closed loop: reduced leg, two muscles with their valves, a sampled controller; Runge–Kutta of fourth order."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .arrays import Array, jax, jnp
from .control import SAMPLE_S, SIGN, Control, Gains, Sensor, pid, start
from .gait import LegAngles
from .joint import acceleration
from .learning import advised, after, nothing
from .muscle import ByBranch, Memory
from .pair import Air, Pair
from .pneumatics import ATMOSPHERE

T = TypeVar("T")
SENSOR = Sensor()
STEPS = 10
"""Steps of the integrator in one interval of control."""
STEP_S = SAMPLE_S / STEPS
CHUNK = 56
"""Runs that are computed side by side."""


class State(NamedTuple):
    """Knee flexion (rad), its rate (rad/s), and the air of the pair."""

    flexion: Array
    rate: Array
    air: Air


class Task(NamedTuple):
    """What the controller is to do at N samples: flexion wanted (rad, (N,)), gauge pressures that are commanded before
    any correction (MPa, (N, 2)), the gait at begin, middle and end of all steps (N, STEPS, 3), of which hip and ankle
    are imposed on the plant, and how the controller learns from its errors, if it does."""

    target: Array
    ahead: Array
    motion: LegAngles
    lesson: Any = ()


class Scale(NamedTuple):
    """Factors on the plant: force of the muscles, inertia and weight of the leg, area of the valves."""

    force: Array | float = 1.0
    inertia: Array | float = 1.0
    flow: Array | float = 1.0


class Log(NamedTuple):
    """What happened, at the N samples: flexion and its rate (N,), gauge pressures, references (MPa) and forces (N) of
    both muscles (N, 2), valve openings (N, 2), split of the correction in MPa (N,)."""

    flexion: Array
    rate: Array
    pressure: Array
    reference: Array
    force: Array
    opening: Array
    split: Array


@dataclass(frozen=True, eq=False)
class Loop:
    """A plant under control. `run` and `batch` are compiled at their first call."""

    pair: Pair
    sensor: Sensor = SENSOR

    @cached_property
    def run(self) -> Callable[[ByBranch, Gains, Scale, Task], Log]:
        """One run; values of the muscle's parameters as `Muscle.values` gives them."""
        return jax.jit(self._run)

    @cached_property
    def _together(self) -> Callable[[ByBranch, Gains, Scale, Task, Array], Log]:
        def one(values: ByBranch, gains: Gains, scale: Scale, task: Task, ahead: Array) -> Log:
            return self._run(values, gains, scale, task._replace(ahead=ahead))

        return jax.jit(jax.vmap(one, in_axes=(None, 0, 0, None, 0)))

    def batch(self, gains: Gains, scales: Scale, task: Task) -> Log:
        """k runs of the plant's own muscle, with NumPy arrays (k,) of gains and scales and `task.ahead` (k, N, 2); the
        log has the k in front. CHUNK at a time: one compilation serves every k, and the states stay in the cache."""
        values, count = self.pair.muscle.values(), len(task.ahead)
        if count == 1:
            gain, scale, ahead = (jax.tree.map(lambda a: a[0], x) for x in (gains, scales, task.ahead))
            return jax.tree.map(
                lambda a: np.asarray(a)[None], self.run(values, gain, scale, task._replace(ahead=ahead))
            )
        logs = []
        for begin in range(0, count, CHUNK):
            rows = np.minimum(np.arange(begin, begin + CHUNK), count - 1)
            some, scale = (jax.tree.map(lambda a, rows=rows: a[rows], x) for x in (gains, scales))
            logs.append(self._together(values, some, scale, task._replace(ahead=task.ahead[0]), task.ahead[rows]))
        return jax.tree.map(lambda *parts: np.concatenate(parts)[:count], *logs)

    def rates(
        self,
        values: ByBranch,
        scale: Scale,
        memory: Memory,
        time: Array,
        state: State,
        reference_Pa: Array,
        motion: LegAngles,
    ) -> tuple[State, Array, Memory]:
        """Time derivative of the state, forces of the muscles in N (2,), and their memory at this point."""
        pair = self.pair
        posture = pair.leg.knee.at(state.flexion)
        contraction, speed = pair.stroke(posture.sprocket, posture.ratio * state.rate)
        force, memory = pair.pull(values, memory, time, state.air.gauge_MPa, contraction, speed)
        force = force * scale.force
        torque = pair.torque(force) / scale.inertia
        faster = acceleration(pair.leg, state.flexion, state.rate, torque, motion)
        return (
            State(state.rate, faster, pair.rates(state.air, reference_Pa, contraction, speed, scale.flow)),
            force,
            memory,
        )

    def _run(self, values: ByBranch, gains: Gains, scale: Scale, task: Task) -> Log:
        state, memory, control = self.begin(task)

        def sample(carry: tuple[State, Memory, Control], given: tuple[Array, Task]) -> tuple[Any, Log]:
            state, memory, control = carry
            time, now = given
            split, reference, control = self.command(gains, control, state.flexion, now.target, now.ahead, now.lesson)

            def step(carry: tuple[State, Memory], given: tuple[Array, LegAngles]) -> tuple[tuple[State, Memory], Array]:
                return self._step(values, scale, carry, reference * 1e6 + ATMOSPHERE, *given)

            times = time + STEP_S * jnp.arange(STEPS)
            (after, memory), force = jax.lax.scan(step, (state, memory), (times, now.motion))
            air = state.air
            log = Log(state.flexion, state.rate, air.gauge_MPa, reference, force[0], air.opening, split)
            return (after, memory, control), log

        times = SAMPLE_S * jnp.arange(len(task.target))
        return jax.lax.scan(sample, (state, memory, control), (times, task))[1]

    def command(
        self, gains: Gains, control: Control, flexion: Array, target: Array, ahead: Array, lesson: Any = ()
    ) -> tuple[Array, Array, Control]:
        """What the controller does at a sample: its split and the references (2,) in MPa, and what it remembers."""
        pair = self.pair
        error = target - self.sensor.read(flexion)
        if lesson:
            ahead = ahead + advised(lesson, control.learned)
            control = control._replace(learned=after(lesson, control.learned, error))
        split, control = pid(gains, control, error, 0.5 * (ahead[0] - ahead[1]), pair.reach_MPa)
        return split, jnp.clip(ahead + split * SIGN, pair.lowest_MPa, pair.highest_MPa), control

    def begin(self, task: Task) -> tuple[State, Memory, Control]:
        """The leg on the target, air at rest at the first pressures commanded, a controller that remembers nothing."""
        gauge = jnp.clip(task.ahead[0], self.pair.lowest_MPa, self.pair.highest_MPa)
        contraction, _ = self.pair.stroke(self.pair.leg.knee.at(task.target[0]).sprocket, jnp.zeros(()))
        rate = (task.target[1] - task.target[0]) / SAMPLE_S
        state = State(task.target[0], rate, self.pair.at_rest(gauge, contraction))
        control = start(task.target[0] - self.sensor.read(state.flexion))
        control = control._replace(learned=nothing() if task.lesson else ())
        return state, self.pair.muscle.start(gauge, contraction), control

    def _step(
        self,
        values: ByBranch,
        scale: Scale,
        carry: tuple[State, Memory],
        reference: Array,
        time: Array,
        motion: LegAngles,
    ) -> tuple[tuple[State, Memory], Array]:
        """One step; `motion` at its begin, middle and end. The memory moves on to the step's begin, from where all
        stages look ahead."""
        state, memory = carry
        first, middle, last = (jax.tree.map(lambda a, k=k: a[k], motion) for k in range(3))
        k1, force, memory = self.rates(values, scale, memory, time, state, reference, first)

        def slope(share: float, point: State) -> State:
            at = middle if share < 1.0 else last
            return self.rates(values, scale, memory, time + share * STEP_S, point, reference, at)[0]

        return (runge_kutta(state, k1, slope), memory), force


def runge_kutta(state: T, k1: T, slope: Callable[[float, T], T]) -> T:
    """The state one step on by the classical method: `k1` is its slope now, `slope` that at a share of the step and a
    state there."""

    def ahead(share: float, k: T) -> T:
        return slope(share, jax.tree.map(lambda y, d: y + share * STEP_S * d, state, k))

    k2 = ahead(0.5, k1)
    k3 = ahead(0.5, k2)
    k4 = ahead(1.0, k3)
    return jax.tree.map(lambda y, a, b, c, d: y + STEP_S / 6.0 * (a + 2.0 * (b + c) + d), state, k1, k2, k3, k4)
