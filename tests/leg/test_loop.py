"""The closed loop against the plain statement of the plant under another integrator; a batch against its runs."""

import numpy as np
import pytest
from plain_loop import PlainGait, PlainPid, closed_loop
from scipy.integrate import solve_ivp

from pam_ident.leg.arrays import jax
from pam_ident.leg.control import Gains, Sensor
from pam_ident.leg.loop import CHUNK, Loop, Scale
from pam_ident.leg.pneumatics import ATMOSPHERE

GAINS = Gains(2.0, 1.0, 0.1)
TYPICAL = [1.0, 1.0, 1e5, 1e5, 1e-4, 1e-4, 1.0, 1.0]


def by_dop853(slope, begin, end, state):
    found = solve_ivp(slope, (begin, end), state, method="DOP853", rtol=1e-10, atol=1e-10 * np.array(TYPICAL))
    return found.y[:, -1].tolist()


@pytest.fixture(scope="module")
def both(example, loop, course, task):
    """Log of the loop, states (n, 8) of the plain plant under a plain controller and DOP853 at 1e-10."""
    pair, plain = example
    log = loop.run(pair.muscle.values(), GAINS, Scale(), task)
    states = closed_loop(plain, PlainGait(course.gait), PlainPid(*GAINS), len(task.target), by_dop853)
    return log, np.array(states)


def test_the_loop_is_the_plain_plant_under_a_plain_controller_to_a_millionth_of_a_radian(both):
    log, states = both
    assert np.ptp(states[:, 0]) > 0.2  # the knee has bent and stretched
    assert np.max(np.abs(np.asarray(log.flexion) - states[:, 0])) < 1e-6
    assert np.max(np.abs(np.asarray(log.rate) - states[:, 1])) < 1e-4


def test_so_are_pressures_and_openings(example, both):
    pair, _ = example
    log, states = both
    gauge = (states[:, 2:4] - ATMOSPHERE) * 1e-6
    assert np.ptp(gauge, axis=0).min() > 0.05
    assert np.max(np.abs(np.asarray(log.pressure) - gauge)) < 1e-5
    apart = 1e-5 / pair.full_open_MPa  # what that much pressure opens a valve by
    assert np.max(np.abs(np.asarray(log.opening) - states[:, 6:])) < apart


@pytest.mark.long
def test_the_slopes_agree_with_the_plain_plant_at_any_state(example, loop, course, task):
    """To rounding: no integrator between them. Seeded states, with mass and force, inertia and flow a fifth off."""
    pair, plain = example
    rng = np.random.default_rng(3)
    gait = PlainGait(course.gait)
    scale = Scale(0.8, 1.2, 0.9)
    plain.force_scale, plain.inertia_scale, plain.flow_scale = scale
    try:
        for _ in range(20):
            time = rng.uniform(0.0, 1.0)
            p = rng.uniform(1.5e5, 6.0e5, 2)
            y = [rng.uniform(0.0, 1.2), rng.uniform(-5, 5), *p, *rng.uniform(1e-4, 5e-4, 2), *rng.uniform(-1, 1, 2)]
            reference = rng.uniform(1.5e5, 6.5e5, 2)
            expected = plain.slope(y, reference, *gait.hip_and_ankle(time))
            state, memory, _ = loop.begin(task)
            air = state.air._replace(pressure=np.array(y[2:4]), mass=np.array(y[4:6]), opening=np.array(y[6:]))
            state = state._replace(flexion=np.float64(y[0]), rate=np.float64(y[1]), air=air)
            motion = course.gait.at(time)
            found, _, _ = loop.rates(pair.muscle.values(), scale, memory, time, state, reference, motion)
            flat = np.concatenate([[found.flexion, found.rate], *found.air])
            assert flat == pytest.approx(expected, rel=1e-9, abs=1e-9)
    finally:
        plain.force_scale = plain.inertia_scale = plain.flow_scale = 1.0


@pytest.mark.long
def test_a_batch_beyond_a_chunk_is_its_runs_one_by_one(example, loop, task):
    pair, _ = example
    rng = np.random.default_rng(4)
    count, samples = CHUNK + 1, len(task.target)
    gains = Gains(*(g * rng.uniform(0.5, 2.0, count) for g in GAINS))
    scales = Scale(*rng.uniform(0.8, 1.2, (3, count)))
    ahead = np.asarray(task.ahead) + rng.uniform(-0.05, 0.05, (count, 1, 2))
    together = loop.batch(gains, scales, task._replace(ahead=ahead))
    assert together.flexion.shape == (count, samples) and together.force.shape == (count, samples, 2)
    for k in (0, 1, CHUNK - 1, CHUNK):
        gain, scale = (jax.tree.map(lambda a, k=k: a[k], x) for x in (gains, scales))
        alone = loop.run(pair.muscle.values(), gain, scale, task._replace(ahead=ahead[k]))
        for name, one, other in zip(alone._fields, together, alone, strict=True):
            size = np.max(np.abs(other)) + 1e-9
            assert np.max(np.abs(one[k] - np.asarray(other))) < 1e-12 * size, name
    assert np.ptp(together.flexion[:, -1]) > 1e-3


@pytest.mark.long
def test_one_command_is_a_batch_too(example, loop, task):
    pair, _ = example
    many = Gains(*(np.full(1, g) for g in GAINS))
    log = loop.batch(many, Scale(*np.ones((3, 1))), task._replace(ahead=np.asarray(task.ahead)[None]))
    alone = loop.run(pair.muscle.values(), GAINS, Scale(), task)
    assert log.flexion.shape == (1, len(task.target)) and np.array_equal(log.flexion[0], np.asarray(alone.flexion))


@pytest.mark.long
def test_a_loop_of_another_sensor_sees_its_steps(example, task):
    pair, _ = example
    coarse = Loop(pair, Sensor(bits=8))
    log = coarse.run(pair.muscle.values(), Gains(1.0, 0.0, 0.0), Scale(), task)
    step = (coarse.sensor.highest - coarse.sensor.lowest) / 2**8
    seen = (np.asarray(task.target) - np.asarray(log.split) - coarse.sensor.lowest) / step
    assert np.max(np.abs(seen - np.round(seen))) < 1e-9
