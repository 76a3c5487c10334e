"""Run fitted models in the leg: plain PID, then PID with the feed-forward of every rung of a ladder."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..core.progress import steps, tell
from ..records.doubt import Doubt
from .arrays import jax
from .budget import Budget, budget
from .control import Gains
from .course import Course
from .feed_forward import FeedForward
from .loop import CHUNK, Log, Loop, Scale, Task
from .mismatch import AS_KNOWN, Mismatch
from .muscle import Muscle
from .pair import Pair
from .treadmill import Treadmill
from .trouble import Trouble, outside, plan_troubles, troubles
from .tuning import Tuned, judge, rms_deg, tune, tune_by_hand

if TYPE_CHECKING:
    from .prototype import Angles

Array = np.ndarray


@dataclass(frozen=True)
class Tracking:
    """A run, over the samples judged: time (s), flexion wanted and reached (deg, (N,)), gauge pressures (MPa) and
    forces (N) of flexor and extensor (N, 2)."""

    time: Array
    target: Array
    flexion: Array
    pressure: Array
    force: Array
    troubles: tuple[Trouble, ...] = ()

    @property
    def error(self) -> Array:
        """Flexion wanted minus reached in degrees, shape (N,)."""
        return self.target - self.flexion

    @property
    def rms_deg(self) -> float:
        """Root mean square of the error."""
        return float(np.sqrt(np.mean(self.error**2)))

    @property
    def peak_deg(self) -> float:
        """Largest absolute error."""
        return float(np.max(np.abs(self.error)))


@dataclass(frozen=True)
class TrackRung:
    """PID with the feed-forward of one model: the model, the run, and the 95 % band of the rms error in degrees that
    the uncertainty of its parameters leads to, None where that is not known."""

    muscle: Muscle
    tracking: Tracking
    band: tuple[float, float] | None = None


@dataclass(frozen=True)
class Track:
    """Plain PID tuned in both ways, PID with each model ahead, where the error comes from.

    `ideal` is PID with the plant's own muscle ahead: what sampling, sensor and valves leave to any model. Gains and
    budget are those of the leg that the controller knows, bands those of the reduced one. Where there is a `motion`,
    the other runs are the prototype's; it is what the prototype did under the last rung, and `agreement_deg` is the
    rms difference between both legs there. `off` is what the plant is off, `doubts` where the last rung leaves what
    its fit has seen.
    """

    loop: Loop
    course: Course
    by_hand: Tuned
    automatic: Tuned
    pid_by_hand: Tracking
    pid: Tracking
    rungs: tuple[TrackRung, ...]
    ideal: Tracking
    budget: Budget
    motion: "tuple[Angles, ...]" = ()
    agreement_deg: float | None = None
    off: Mismatch = AS_KNOWN
    ground: Treadmill | None = None
    doubts: tuple[Doubt, ...] = ()

    @property
    def prototype(self) -> bool:
        """Whether the runs are those of the multibody prototype."""
        return bool(self.motion)


def track(
    known: Loop,
    controllers: Sequence[Muscle],
    course: Course,
    gains: Gains | None = None,
    prototype: bool = False,
    seed: int = 1,
    off: Mismatch = AS_KNOWN,
    ground: Treadmill | None = None,
) -> Track:
    """Tune, run, and take the error apart. `controllers` are the models that the feed-forward knows, a rung each.

    Gains are tuned, and the budget is made, on the loop that is `known`; the runs are those of a plant that may be
    `off`, in a `prototype` on a `ground`, too. All rungs run with the gains of the plain PID: those found
    automatically, or `gains`; where the course has lessons, they learn, and the plain PID does not. Raises UsageError
    where a `prototype` is asked for and MuJoCo is missing.
    """
    plant = known if off == AS_KNOWN else replace(known, pair=off.plant(known.pair, course.gait.cadence_Hz))
    bench = _Prototype(plant, course, known, ground) if prototype else _Reduced(plant, course, known)
    mean = np.full((1, len(course.time), 2), known.pair.mean_MPa)
    plain = replace(course, lessons=0)
    task, judged = plain.task(mean[0, : len(plain.time)]), plain.judged
    tell("tuning by hand")
    by_hand = tune_by_hand(known, task, judged)
    chosen = tune(known, task, judged, by_hand.gains, seed) if gains is None else judge(known, task, judged, gains)
    slow, pid = (bench.run(course.task(mean), tuned.gains) for tuned in (by_hand, chosen))
    ideal = bench.rung(plant.pair, chosen.gains, seed).tracking
    rungs = tuple(
        bench.rung(replace(known.pair, muscle=muscle), chosen.gains, seed)
        for muscle in steps(controllers, "running each step")
    )
    tell("sharing the error out")
    found = budget(known, task, judged, by_hand, chosen)
    doubts = tuple(d for rung in rungs[-1:] for d in outside(known.pair, rung.muscle, course, rung.tracking.pressure))
    agreed = bench.motion, bench.agreement_deg
    return Track(plant, course, by_hand, chosen, slow, pid, rungs, ideal, found, *agreed, off, ground, doubts)


SAMPLES = CHUNK - 1
"""Draws of a model's parameters for its band; with the fit itself they fill a batch."""


@dataclass
class _Reduced:
    """Runs in the reduced leg."""

    plant: Loop
    course: Course
    known: Loop
    ground: Treadmill | None = None
    motion: "tuple[Angles, ...]" = ()
    agreement_deg: float | None = None

    def run(self, task: Task, gains: Gains) -> Tracking:
        """The first of the task's commands, `task.ahead` (k, N, 2)."""
        return self.judged(self.log(task, gains), task)

    def log(self, task: Task, gains: Gains) -> Log:
        """All of the task's commands, with the k in front."""
        count = len(task.ahead)
        many = Gains(*(np.full(count, gain) for gain in gains))
        return self.plant.batch(many, Scale(*np.ones((len(Scale._fields), count))), task)

    def judged(self, logs: Log, task: Task) -> Tracking:
        """The part that counts of the first run, with its troubles."""
        part = self.course.judged
        log = jax.tree.map(lambda a: a[0], logs)
        wanted, reached = (np.degrees(np.asarray(a)[part]) for a in (task.target, log.flexion))
        found = tuple(troubles(self.plant.pair, log, task, part))
        return Tracking(self.course.time[part], wanted, reached, log.pressure[part], log.force[part], found)

    def rung(self, model: Pair, gains: Gains, seed: int) -> TrackRung:
        """PID with the inverse of `model` ahead, and what its parameters' uncertainty does to the error."""
        sets = model.muscle.draws(SAMPLES, seed)
        certain = jax.tree.map(lambda value: np.full(1, value), model.muscle.values())
        plans = self.course.plans(FeedForward(model), certain if sets is None else sets)
        task = self.course.task(plans.reference)
        if self.course.lessons:
            own = replace(self.known, pair=model)
            task = task._replace(lesson=self.course.lesson(own, plans.reference[0], gains))
        logs = self.log(task, gains)
        first = self.first(logs, task, gains)
        missed = plan_troubles(jax.tree.map(lambda a: a[0], plans), self.course.judged)
        known = {trouble.kind for trouble in first.troubles}
        first = replace(first, troubles=(*first.troubles, *(one for one in missed if one.kind not in known)))
        if sets is None:
            return TrackRung(model.muscle, first)
        low, high = np.quantile(rms_deg(logs, task, self.course.judged)[1:], (0.025, 0.975))
        return TrackRung(model.muscle, first, (float(low), float(high)))

    def first(self, logs: Log, task: Task, gains: Gains) -> Tracking:
        """The run of the parameters as they were fitted."""
        return self.judged(logs, task)


class _Prototype(_Reduced):
    """Runs in the multibody leg; what needs many runs stays with the reduced one."""

    def run(self, task: Task, gains: Gains) -> Tracking:
        from .co_simulation import co_simulate

        log, motion = co_simulate(self.plant, self.course.gait, task._replace(ahead=task.ahead[0]), gains, self.ground)
        self.motion = tuple(motion[self.course.judged])
        return self.judged(jax.tree.map(lambda a: a[None], log), task)

    def first(self, logs: Log, task: Task, gains: Gains) -> Tracking:
        found, reduced = self.run(task, gains), self.judged(logs, task)
        self.agreement_deg = float(np.sqrt(np.mean((found.flexion - reduced.flexion) ** 2)))
        return found
