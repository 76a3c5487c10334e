"""Each trouble is told with the moment it happens: on logs made for it, and in runs of a leg that is asked too much."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.leg.anatomy import LEG
from pam_ident.leg.control import Gains
from pam_ident.leg.course import Course
from pam_ident.leg.feed_forward import FeedForward, PressurePlan
from pam_ident.leg.gait import winter
from pam_ident.leg.loop import Log, Loop, Scale, Task
from pam_ident.leg.pneumatics import ATMOSPHERE, Supply
from pam_ident.leg.trouble import WORDS, plan_troubles, troubles

N, JUDGED = 100, slice(20, 100)


def log_of(**given):
    """A run in which nothing is wrong, but for what is given."""
    pairs = np.ones((N, 2))
    calm = Log(np.zeros(N), np.zeros(N), 0.3 * pairs, 0.3 * pairs, 200.0 * pairs, 0.1 * pairs, np.zeros(N))
    return calm._replace(**given)


def plan_made(**given):
    pairs = np.ones((N, 2))
    return PressurePlan(0.1 * pairs, 0.3 * pairs, 0.3 * pairs, np.full(N, 10.0), np.zeros(N), 0.1 * pairs)._replace(
        **given
    )


def from_sample(calm, first, bad, last=N, muscle=None):
    """`calm` everywhere but from sample `first` on, of one muscle or of all."""
    values = np.array(calm, float)
    values[(slice(first, last),) if muscle is None else (slice(first, last), muscle)] = bad
    return values


@pytest.fixture
def pair(example):
    return example[0]


def found(pair, log):
    return {t.kind: t for t in troubles(pair, log, Task(np.zeros(N), np.zeros((N, 2)), None), JUDGED)}


PAIRS = np.ones((N, 2))


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("unstable", {"flexion": from_sample(np.zeros(N), 60, np.radians(31.0))}),
        ("unstable", {"flexion": from_sample(np.zeros(N), 60, np.nan)}),
        ("slack", {"force": from_sample(200.0 * PAIRS, 60, 0.0, muscle=1)}),
        ("supply", {"reference": from_sample(0.3 * PAIRS, 60, 0.6, muscle=0)}),
        ("flow", {"opening": from_sample(0.1 * PAIRS, 60, -1.0, muscle=1)}),
    ],
)
def test_a_run_tells_what_went_wrong_and_when(pair, kind, given):
    told = found(pair, log_of(**given))
    assert list(told) == [kind]
    assert told[kind].time_s == pytest.approx(0.3) and told[kind].share == pytest.approx(0.5)
    text = str(told[kind])
    assert text.startswith("from 0.300 s, 50 % of the time: ") and WORDS[kind] in text and told[kind].advice in text


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("torque", {"missing": from_sample(np.zeros(N), 60, -0.2)}),
        ("flow", {"opening": from_sample(0.1 * PAIRS, 60, 1.1, muscle=0)}),
        ("stroke", {"contraction": from_sample(0.1 * PAIRS, 60, 0.26, muscle=1)}),
        ("stroke", {"contraction": from_sample(0.1 * PAIRS, 60, -0.04, muscle=0)}),
    ],
)
def test_a_plan_tells_what_it_cannot_reach_and_when(kind, given):
    told = plan_troubles(plan_made(**given), JUDGED)
    assert [t.kind for t in told] == [kind]
    assert told[0].time_s == pytest.approx(0.3) and told[0].share == pytest.approx(0.5)


def test_nothing_is_told_of_calm_nor_of_a_glitch_nor_of_what_is_not_judged(pair):
    assert not troubles(pair, log_of(), Task(np.zeros(N), np.zeros((N, 2)), None), JUDGED)
    assert not plan_troubles(plan_made(), JUDGED)
    assert not found(pair, log_of(force=from_sample(200.0 * PAIRS, 60, 0.0, last=62)))
    assert not found(pair, log_of(force=from_sample(200.0 * PAIRS, 5, 0.0, last=20)))
    assert not plan_troubles(plan_made(missing=from_sample(np.zeros(N), 60, 0.05)), JUDGED)  # half a percent


def test_a_weak_supply_is_told_below_the_muscles_limit(pair):
    weak = replace(pair, supply=replace(pair.supply, pressure_Pa=0.4e6 + ATMOSPHERE))
    log = log_of(reference=from_sample(0.3 * PAIRS, 60, 0.45))
    assert not found(pair, log) and found(weak, log)["supply"].time_s == pytest.approx(0.3)


def kinds_of_plan(pair, cadence=1.0):
    course = Course(winter(cadence))
    sets = {branch: {k: np.full(1, v) for k, v in one.items()} for branch, one in pair.muscle.values().items()}
    plan = course.plans(FeedForward(pair), sets)
    return {t.kind: t for t in plan_troubles(PressurePlan(*(a[0] for a in plan)), course.judged)}, course


def test_a_heavy_load_asks_torque_that_is_missing(pair):
    told, course = kinds_of_plan(replace(pair, leg=replace(LEG, load_mass_kg=50.0)))
    assert "torque" in told and course.time[course.judged][0] <= told["torque"].time_s < 2.0


@pytest.mark.long
def test_a_fast_gait_asks_air_that_the_valve_does_not_let_through(pair):
    assert "flow" in kinds_of_plan(pair, cadence=1.5)[0]
    assert not kinds_of_plan(pair, cadence=0.5)[0]


def test_a_large_sprocket_asks_stroke_that_the_muscle_does_not_have(pair):
    told, course = kinds_of_plan(replace(pair, leg=replace(LEG, sprocket_radius_m=0.06)))
    # the flexor passes 25 % with the first sample of the stride at which 0.028 + R s / L0 does
    sprocket = LEG.knee.at(course.gait.at(course.time + 0.0025).knee.angle).sprocket
    beyond = (0.028 + 0.06 * sprocket / 0.2 > 0.25) | (0.2155 - 0.06 * sprocket / 0.2 < -0.03)
    first = next(k for k in range(course.judged.start, len(beyond)) if beyond[k : k + 3].all())
    assert told["stroke"].time_s == pytest.approx(0.005 * first)


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("slack", {"mean_MPa": 0.2}),
        ("supply", {"supply": Supply(0.25e6 + ATMOSPHERE)}),
    ],
)
def test_a_run_of_a_leg_that_is_asked_too_much(pair, task, kind, changes):
    """The moment is the first of three samples in a row of its own log."""
    leg = replace(pair, **changes)
    log = Log(*map(np.asarray, Loop(leg).run(leg.muscle.values(), Gains(2.0, 1.0, 0.1), Scale(), task)))
    told = {t.kind: t for t in troubles(leg, log, task, slice(0, 110))}
    where = {"slack": log.force.min(axis=1) == 0.0, "supply": log.reference.max(axis=1) > 0.25}[kind]
    first = next(k for k in range(108) if where[k : k + 3].all())
    assert told[kind].time_s == pytest.approx(0.005 * first) and told[kind].share == pytest.approx(where.mean())


@pytest.mark.long
def test_gains_without_damping_make_the_loop_unstable(loop, course):
    """It swings from stop to stop; the first sample beyond 30° is told, and what to do."""
    pair = loop.pair
    task = course.task(np.full(2, pair.mean_MPa))
    log = Log(*map(np.asarray, loop.run(pair.muscle.values(), Gains(10.0, 0.0, 0.0), Scale(), task)))
    told = troubles(pair, log, task, course.judged)[0]
    off = np.degrees(np.abs(log.flexion - np.asarray(task.target)))
    k = round(told.time_s / 0.005)
    assert told.kind == "unstable" and "gains" in told.advice
    assert off[k] >= 30.0 and np.all(off[course.judged.start : k] < 30.0)
