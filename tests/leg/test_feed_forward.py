"""The plan of pressures against the plain plant: it gives the torque, the torque gives the motion, the air obeys."""

from dataclasses import replace

import numpy as np
import pytest
from plain_loop import PlainGait

from pam_ident.leg.anatomy import LEG
from pam_ident.leg.arrays import jax
from pam_ident.leg.control import SAMPLE_S, Gains
from pam_ident.leg.course import Course
from pam_ident.leg.feed_forward import FeedForward
from pam_ident.leg.gait import winter
from pam_ident.leg.loop import Scale
from pam_ident.leg.pneumatics import ATMOSPHERE, GAS
from pam_ident.leg.tuning import rms_deg


def plan_of(pair, course):
    """Plan of the pair's own model."""
    sets = jax.tree.map(lambda v: np.full(1, v), pair.muscle.values())
    return jax.tree.map(lambda a: a[0], course.plans(FeedForward(pair), sets))


@pytest.fixture(scope="module")
def plan(example, course):
    return plan_of(example[0], course)


def test_the_pressures_pull_the_leg_along_its_gait(example, course, plan):
    """Contraction, force and acceleration are the plain plant's; the gait's acceleration is what must come out."""
    _, plain = example
    gait, middle = PlainGait(course.gait), course.time + 0.5 * SAMPLE_S
    knee = course.gait.at(middle).knee
    assert np.max(np.abs(plan.missing)) < 1e-4
    for k in range(3, len(middle), 17):
        angle, ratio = plain.sprocket(knee.angle[k])
        pulls = []
        for m, sign in enumerate((1.0, -1.0)):
            e = plain.leg.rest_contraction[m] + sign * plain.leg.sprocket_radius_m * angle * 1e3 / plain.length_mm
            assert plan.contraction[k, m] == pytest.approx(e, abs=1e-12)
            speed = sign * 1e3 * plain.leg.sprocket_radius_m * ratio * knee.rate[k]
            pulls.append(plain.pull(plan.pressure[k, m], e, speed))
        torque = (pulls[0] - pulls[1]) * plain.leg.sprocket_radius_m
        assert torque == pytest.approx(plan.torque[k], abs=1e-4)
        motion = gait.hip_and_ankle(middle[k])
        found = plain.flexion_acceleration(knee.angle[k], knee.rate[k], torque, *motion)
        assert found == pytest.approx(knee.acceleration[k], abs=1e-2)


def test_the_openings_let_the_pressures_come_about(example, course, plan):
    """Equation (9) of the plain plant with these openings gives the pressures' own slope."""
    _, plain = example
    gait, middle = PlainGait(course.gait), course.time + 0.5 * SAMPLE_S
    knee = course.gait.at(middle).knee
    absolute = plan.pressure * 1e6 + ATMOSPHERE
    checked = 0
    for k in range(2, len(middle) - 2, 11):
        if np.max(np.abs(plan.opening[k])) > 1.0:
            continue
        mass = [absolute[k, m] * plain.volume(plan.contraction[k, m])[0] / (GAS * 293.15) for m in (0, 1)]
        state = [knee.angle[k], knee.rate[k], *absolute[k], *mass, *plan.opening[k]]
        rise = np.array(plain.slope(state, absolute[k], *gait.hip_and_ankle(middle[k]))[2:4])
        wanted = (absolute[k + 1] - absolute[k - 1]) / (2.0 * SAMPLE_S)
        assert rise == pytest.approx(wanted, rel=1e-6, abs=10.0)
        checked += 1
    assert checked > 20 and np.max(np.abs(plan.opening)) > 0.1


def test_the_references_lead_by_opening_and_lag(example, plan):
    """So far ahead of the pressure that a valve of that lag stands at the opening: u + lag·du/dt, times its band."""
    pair, _ = example
    slope = (plan.opening[2:] - plan.opening[:-2]) / (2.0 * SAMPLE_S)
    lead = np.clip(plan.opening[1:-1] + pair.valve.lag_s * slope, -1.0, 1.0)
    assert plan.reference[1:-1] - plan.pressure[1:-1] == pytest.approx(pair.full_open_MPa * lead, abs=1e-12)


@pytest.mark.long
def test_with_the_plants_own_model_ahead_the_knee_follows_to_a_twentieth_of_a_degree(example, loop, course, plan):
    pair, _ = example
    task = course.task(plan.reference)
    log = loop.run(pair.muscle.values(), Gains(2.0, 1.0, 0.1), Scale(), task)
    assert np.degrees(np.ptp(np.asarray(task.target))) > 60.0
    assert rms_deg(log, task, course.judged) <= 0.05


@pytest.mark.long
def test_many_sets_are_planned_as_each_alone(example, plan):
    pair, _ = example
    course = Course(winter(1.0))
    short = jax.tree.map(lambda v: np.array([v, 1.1 * v]), pair.muscle.values())
    both = course.plans(FeedForward(pair), short)
    assert both.pressure[0] == pytest.approx(plan.pressure, abs=1e-12)
    moved = replace(pair.muscle, contraction=(more := {k: 1.1 * v for k, v in pair.muscle.contraction.items()}))
    other = plan_of(replace(pair, muscle=replace(moved, extension=more)), course)
    assert both.pressure[1] == pytest.approx(other.pressure, abs=1e-9)
    assert np.max(np.abs(both.pressure[1] - both.pressure[0])) > 1e-3


def test_torque_that_the_pair_cannot_give_is_missing(example, course):
    """50 kg at the foot: what the pair gives at its limits and what is missing make up the torque that is needed."""
    pair, plain = example
    heavy = replace(pair, leg=replace(LEG, load_mass_kg=50.0))
    plan = plan_of(heavy, course)
    worst = int(np.argmax(np.abs(plan.missing)))
    assert abs(plan.missing[worst]) > 10.0
    split = 0.5 * (plan.pressure[worst, 0] - plan.pressure[worst, 1])
    assert abs(split) == pytest.approx(pair.reach_MPa, abs=1e-6)
    knee = course.gait.at(course.time[worst] + 0.5 * SAMPLE_S).knee
    speed = 1e3 * plain.leg.sprocket_radius_m * plain.sprocket(knee.angle)[1] * knee.rate
    pulls = [plain.pull(plan.pressure[worst, m], plan.contraction[worst, m], s * speed) for m, s in ((0, 1), (1, -1))]
    given = (pulls[0] - pulls[1]) * plain.leg.sprocket_radius_m
    assert given + plan.missing[worst] == pytest.approx(plan.torque[worst], abs=1e-4)
