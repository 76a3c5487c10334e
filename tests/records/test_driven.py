"""Motion and pressure of tests that drive the pressure, beside the course that the rig drove."""

from itertools import pairwise

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.effects import get_effect
from pam_ident.fitting.floor import repeats
from pam_ident.records import read_record
from pam_ident.records.inspection import inspect_record
from pam_ident.records.motion import Motion, find_motion
from pam_ident.records.record import _of_the_braid, build_record
from pam_ident.rig import Plan, make_record, write_case


def driven(name, folder):
    """What the rig drove, on the record's rows, and the record."""
    made = make_record(Plan(5, "exponential_law", protocol=name))
    write_case(folder, made)
    return made.course, read_record(folder / "record.csv")


@pytest.mark.parametrize("name", ["locked_ramps", "locked_stairs", "locked_sweep"])
def test_a_locked_muscle_s_branch_is_the_way_of_its_pressure(name, tmp_path):
    course, record = driven(name, tmp_path)
    moving = course.moving[course.rows]
    clear = (moving != 0) & record.inputs.moving
    assert clear.sum() > 600
    assert np.mean(record.inputs.direction[clear] == moving[clear]) > 0.95  # but where a sweep turns
    assert record.inputs.segment.max() + 1 == 5  # a run for each length
    assert 0.0 < record.inputs.reach_mm < 0.1 * np.ptp(record.inputs.displacement_mm)
    for k in range(5):  # 1.5 mm a kilonewton of the ideal braid
        rows = record.inputs.segment == k
        length = np.full(rows.sum(), record.inputs.contraction[rows].mean())
        force = record.specimen.ideal_force(record.inputs.pressure[rows], length)
        assert np.ptp(record.inputs.way_mm[rows]) == pytest.approx(1.5e-3 * np.ptp(force), rel=0.1)
        assert np.corrcoef(force, record.inputs.way_mm[rows])[0, 1] > 0.999


def test_a_valve_that_leaks_between_its_steps_makes_no_cycles():
    stair = np.linspace(0.05, 0.6, 12)
    steps = [np.r_[np.linspace(p - 0.05, p, 6)[1:], np.linspace(p, p - 0.01, 20)] for p in stair]
    p = np.tile(np.concatenate([*steps, *(one[::-1] for one in steps[::-1])]), 4)
    e = np.repeat([0.0, 0.05], len(p) // 2)
    muscle = Specimen("m", 200.0, 10.0, 25.0)
    record = build_record("t", muscle, p, e, muscle.ideal_force(p, e), time=0.1 * np.arange(len(p)))
    assert record.kind == "isometric" and record.inputs.cycle.max() > 20.0
    assert inspect_record(record).cycles == 2


@pytest.mark.parametrize("name", ["locked_ramps", "locked_stairs", "waves", "switched", "crossed_sines"])
def test_the_rate_of_a_driven_pressure(name, tmp_path):
    course, record = driven(name, tmp_path)
    rate = np.gradient(course.pressure, course.time)[course.rows]
    off = np.abs(record.inputs.pressure_rate - rate)
    assert np.median(off) < 0.05 * np.std(rate)
    assert np.quantile(off, 0.95) < 0.3 * np.std(rate)  # but where a ramp or a run ends


def test_a_pressure_that_is_switched_within_strokes_cuts_none(tmp_path):
    course, record = driven("switched", tmp_path)
    assert record.inputs.segment.max() + 1 == 3
    moving = course.moving[course.rows]
    clear = (moving != 0) & record.inputs.moving
    assert clear.sum() > 1000
    assert np.mean(record.inputs.direction[clear] == moving[clear]) > 0.99  # but at a turn itself


def test_while_the_length_rests_the_braid_slides_with_the_pressure():
    """Ends and threads give, so it slides as in a locked muscle, and keeps its direction while nothing is driven."""
    pieces = [(20.0, 0.2), (20.0, 0.2), (20.0, 0.5), (20.0, 0.5), (20.0, 0.3), (0.0, 0.3), (0.0, 0.4), (0.0, 0.4)]
    course = [np.linspace(one, other, 100, endpoint=False) for one, other in pairwise([(0.0, 0.2), *pieces])]
    x, pressure = np.concatenate(course).T
    muscle = Specimen(initial_length_mm=200.0, initial_radius_mm=10.0, braid_angle_deg=25.0)
    force = muscle.ideal_force(pressure, x / 200.0)
    time = 0.05 * np.arange(len(x))
    inputs = build_record("both", muscle, pressure, x / 200.0, force, time=time, said_kind="dynamic").inputs
    middle = slice(20, 80)  # of each piece
    for k, (direction, moves) in enumerate([(1, 1), (1, 0), (1, 1), (1, 0), (-1, 1), (-1, 1), (1, 1), (1, 0)]):
        part = inputs.take(slice(100 * k, 100 * (k + 1)))
        assert np.all(part.direction[middle] == direction) and np.all(part.moving[middle] == moves), k
        assert np.all(np.sign(part.velocity[middle]) == direction * moves), k
        assert moves or np.ptp(part.way_mm[middle]) < 1e-6
    np.testing.assert_array_equal(inputs.way_mm, inputs.displacement_mm)  # how far it slides is not known
    assert not inputs.locked and inputs.has("driven pressure")


def test_strokes_repeat_each_other_where_pressure_and_length_run_the_same_course(tmp_path):
    _, record = driven("locked_ramps", tmp_path)
    groups = repeats(record, np.ones(len(record), bool))
    assert len(groups) == 5 * 3 * 2 and {len(group) for group in groups} == {2}  # lengths, rates, ways
    for (one, _), (other, _) in groups:
        assert np.abs(record.inputs.pressure[one].mean() - record.inputs.pressure[other].mean()) < 0.01
        assert np.abs(record.inputs.contraction[one].mean() - record.inputs.contraction[other].mean()) < 0.001


def test_each_step_of_a_staircase_is_a_stroke():
    steps = [(0.0, 10.0), (10.0, 20.0), (20.0, 10.0), (10.0, 0.0)]
    x = np.concatenate([np.r_[np.linspace(*step, 20), np.full(20, step[1])] for step in steps])
    time = 0.1 * np.arange(len(x))
    motion = find_motion(time, x, np.zeros(len(x)))
    assert len(np.unique(motion.stroke)) == 4
    runs = motion.moving.reshape(4, 40)
    assert runs[:, 2:18].all() and not runs[:, 22:].any()
    np.testing.assert_allclose(motion.direction.reshape(4, 40)[:, 2:], np.repeat([[1], [1], [-1], [-1]], 38, axis=1))
    speed = np.abs(motion.velocity.reshape(4, 40)[:, 5:15])
    np.testing.assert_allclose(speed, np.full((4, 10), 100.0 / 19.0))


@pytest.mark.parametrize("between", [0, 1])
def test_a_step_between_two_samples_is_a_stroke_that_arrives(between):
    """Slow loggers see a staircase's holds alone."""
    levels = [0.0, 10.0, 20.0, 10.0, 0.0, 10.0]
    x = np.concatenate([np.r_[[0.5 * (a + b)] * between, np.full(20, b)] for a, b in pairwise([0.0, *levels])])
    time = 0.1 * np.arange(len(x))
    motion = find_motion(time, x + 0.01 * np.random.default_rng(1).standard_normal(len(x)), np.zeros(len(x)))
    arrival = (20 + between) * np.arange(1, 6)
    assert np.flatnonzero(motion.moving).tolist() == arrival.tolist()
    np.testing.assert_array_equal(motion.direction[arrival], [1, 1, -1, -1, 1])
    np.testing.assert_array_equal(motion.direction[arrival + 10], [1, 1, -1, -1, 1])
    assert motion.stroke[-1] == 5 and set(motion.cycle) == {1, 2}


def test_gas_that_a_driven_pressure_moves_flows_through_the_line_too(tmp_path):
    """p_abs d ln(p_abs V)/dt is p_abs V̇/V + ṗ, of which a locked muscle has ṗ alone."""
    course, record = driven("locked_ramps", tmp_path)
    textbook = get_effect("pressure_lag")[1]
    column = textbook.columns(record.inputs, {}, np.zeros(len(record)))[:, 0]
    rate = np.gradient(course.pressure, course.time)[course.rows]
    assert np.median(np.abs(column + rate)) < 0.02 * np.std(rate)


@pytest.mark.parametrize(("seed", "noise_mm"), [(0, 0.02), (0, 0.05), (5, 0.02), (5, 0.05)])
def test_a_drive_of_many_sines_never_rests(seed, noise_mm):
    """Where it turns slowly the noise hides the motion, and the pressure, which wavers, had told the way."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 60.0, 0.02)
    rates = np.geomspace(0.03, 1.2, 7) * rng.uniform(0.9, 1.1, 7)
    angle = 2.0 * np.pi * rates * time[:, None] + rng.uniform(0.0, 2.0 * np.pi, 7)
    x, speed = np.sin(angle) @ rates**-0.8, np.cos(angle) @ rates**0.2
    x = 70.0 * (x - x.min()) / np.ptp(x)
    pressure = 0.35 + 0.1 * np.sin(0.3 * time)
    force = pressure * (2400.0 - 30.0 * x) - 8.0 * np.sign(speed) + 3.0 * rng.standard_normal(len(x))
    muscle = Specimen("m", 300.0, 10.0, 25.4, 1.5)
    record = build_record("r", muscle, pressure, (x + noise_mm * rng.standard_normal(len(x))) / 300.0, force, time=time)
    assert record.kind == "dynamic" and np.mean(record.inputs.moving) > 0.99
    assert np.mean(record.inputs.direction != np.sign(speed)) < 0.04  # but at the turns, and on ways that noise hides


@pytest.mark.parametrize(("per_kpa", "moves"), [(0.001, False), (0.1, True)])
def test_a_pressure_drives_the_braid_of_a_muscle_at_rest_if_it_does_so_farther_than_that_may_move(per_kpa, moves):
    still, rows = np.r_[np.zeros(10), np.ones(20), np.zeros(10)] > 0.0, np.ones(40)
    length = Motion(10.0 * ~still, rows, ~still, rows, rows, rows, rows, rows)
    pressure = Motion(-5.0 * rows, -rows, rows > 0.0, rows, 5.0 * rows, -np.arange(40.0), rows, rows)
    found = _of_the_braid(length, pressure, per_kpa * rows, 0.1)
    assert np.all(found.moving[still] == moves) and np.all(found.direction[still] == (-1.0 if moves else 1.0))
