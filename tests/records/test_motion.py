"""Strokes, reversals, holds and cycles found from noisy displacement, against the motion that was commanded."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.records import build_record
from pam_ident.records.motion import find_motion
from pam_ident.records.roughness import noise_around, position_noise
from pam_ident.records.smoothing import noise_only, smooth_stroke

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)
TRAVEL = 40.0


def trapezoid(speed, hold, per_stroke, cycles=3, in_hold=12):
    """(t, x, direction, moving, cycle, speed): up, hold, down, hold; the hold belongs to the stroke before it.

    Corners are left out, so that every sample has one true answer.
    """
    rows, clock = [], 0.0
    for cycle in range(1, cycles + 1):
        for sign in (1.0, -1.0):
            took = TRAVEL / speed
            at = (np.arange(per_stroke) + 0.5) / per_stroke
            x = TRAVEL * at if sign > 0 else TRAVEL * (1.0 - at)
            rows += [(clock + took * a, v, sign, 1.0, cycle, speed) for a, v in zip(at, x, strict=True)]
            clock += took
            end = TRAVEL if sign > 0 else 0.0
            if hold:
                rows += [(clock + hold * b, end, sign, 0.0, cycle, speed) for b in (np.arange(in_hold) + 0.5) / in_hold]
                clock += hold
    return np.array(rows).T


def slow_turns(speed, per_stroke, cycles=3):
    """Strokes that begin and end without speed or acceleration, so that each turn stays in the noise for a while."""
    share = (np.arange(per_stroke) + 0.5) / per_stroke
    way = share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)
    t = np.arange(2 * cycles)[:, None] * TRAVEL / speed + share * TRAVEL / speed
    x = TRAVEL * np.where(np.arange(2 * cycles)[:, None] % 2, 1.0 - way, way)
    return t.ravel(), x.ravel(), np.repeat(np.tile([1.0, -1.0], cycles), per_stroke)


def sine(period, per_cycle, cycles=3):
    """Contraction first; the two samples nearest to each reversal have no sure branch and are not judged."""
    t = (np.arange(per_cycle * cycles) + 0.5) / per_cycle * period
    phase = 2.0 * np.pi * t / period
    return (
        t,
        0.5 * TRAVEL * (1.0 - np.cos(phase)),
        np.sign(np.sin(phase)),
        np.ones_like(t),
        np.floor(t / period) + 1.0,
        0.5 * TRAVEL * 2.0 * np.pi / period * np.sin(phase),
    )


def record_of(t, x, noise, seed=3):
    """A record of one isobar with position noise in mm."""
    seen = x + noise * np.random.default_rng(seed).standard_normal(len(x))
    return build_record("r", MUSCLE, np.full_like(t, 0.3), seen / 200.0, 800.0 - x, time=t)


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.05])
@pytest.mark.parametrize("per_stroke", [12, 40, 400])
@pytest.mark.parametrize("speed", [1.0, 10.0, 100.0])
def test_a_trapezoid_with_holds_is_cut_where_it_was_commanded(speed, per_stroke, noise):
    t, x, direction, moving, cycle, _ = trapezoid(speed, 4.0, per_stroke)
    record = record_of(t, x, noise)
    found = record.inputs
    judged = np.ones(len(t), bool)
    for corner in np.flatnonzero((np.diff(moving) != 0.0) | (np.diff(direction) != 0.0)):
        judged[max(corner - 1, 0) : corner + 3] = False
    wrong = (found.direction != direction)[judged].mean()
    assert wrong == 0.0, f"{wrong:.1%} of the samples on the wrong branch"
    assert (found.moving != (moving == 1.0))[judged].mean() <= 0.01
    assert (found.cycle != cycle)[judged].mean() == 0.0
    going = judged & (moving == 1.0) & found.moving
    assert np.median(np.abs(found.velocity[going])) == pytest.approx(speed, rel=0.02)
    assert np.all(found.velocity[~found.moving] == 0.0)
    assert len(np.unique(record.stroke[found.moving])) == 6


@pytest.mark.parametrize(
    ("speed", "per_stroke", "in_hold", "noise"), [(2.0, 20000, 4000, 0.01), (10.0, 4000, 4000, 0.01)]
)
def test_a_logger_much_faster_than_the_motion_changes_nothing(speed, per_stroke, in_hold, noise):
    """1 kHz at 2 and 10 mm/s: one step of the motion is far below the noise of the position."""
    t, x, direction, moving, cycle, _ = trapezoid(speed, 4.0, per_stroke, in_hold=in_hold)
    record = record_of(t, x, noise)
    found = record.inputs
    assert np.mean(found.direction != direction) < 0.01
    assert np.mean(found.moving != (moving == 1.0)) < 0.01
    assert np.mean(found.cycle != cycle) < 0.01
    assert len(np.unique(record.stroke[found.moving])) == 6


@pytest.mark.parametrize("noise", [0.005, 0.05])
@pytest.mark.parametrize("speed", [10.0, 100.0])
def test_three_samples_make_a_hold_where_a_stroke_would_have_gone_far(speed, noise):
    t, x, direction, moving, _, _ = trapezoid(speed, 4.0, 40, in_hold=3)
    found = record_of(t, x, noise).inputs
    np.testing.assert_array_equal(found.moving, moving == 1.0)
    np.testing.assert_array_equal(found.direction, direction)


@pytest.mark.parametrize("jitter", [0.0, 0.002])
@pytest.mark.parametrize("noise", [0.01, 0.04])
@pytest.mark.parametrize("speed", [2.0, 20.0])
def test_a_slow_turn_is_no_hold(speed, noise, jitter):
    t, x, direction = slow_turns(speed, 50)
    late = jitter * np.random.default_rng(8).standard_normal(len(t))
    found = record_of(t + late, x, noise).inputs
    assert found.moving.all()
    judged = np.abs(np.arange(len(t)) % 50 - 24.5) < 24.0  # beside the turn itself either branch is as good
    np.testing.assert_array_equal(found.direction[judged], direction[judged])


def test_a_stroke_of_few_rows_leaves_slow_turns_what_they_are():
    t, x, _ = slow_turns(20.0, 50)
    short_t, short_x, _ = slow_turns(60.0, 5, cycles=1)
    found = record_of(np.r_[t, t[-1] + 0.04 + short_t], np.r_[x, 0.1 * short_x], 0.04).inputs
    assert found.moving[: len(t)].all()


def test_a_hold_in_which_the_drive_still_brakes_keeps_the_position_of_what_rests():
    t, x, _, moving, _, _ = trapezoid(10.0, 4.0, 40, in_hold=8)
    last = np.flatnonzero((np.diff(moving) < 0.0) & (x[1:] == TRAVEL)) + 1
    x[last] -= 0.06
    steady = record_of(t, x, 0.02).steady
    inside = np.concatenate([last + k for k in range(1, 8)])
    assert np.max(np.abs(steady.displacement_mm[inside] - TRAVEL)) < 0.025


@pytest.mark.parametrize("slow_s", [0.5, 1.0])
def test_a_hold_in_which_the_drive_settles_is_followed_and_a_rest_is_one_place(slow_s):
    """What is nearer to its end than the noise is not there: the same in every hold, it passes for a relaxation."""
    noise, trapezium = 0.2, trapezoid(10.0, 4.0, 12, cycles=10, in_hold=18)
    t, x, *_, moving, _, _ = trapezium
    rest = record_of(t, x, noise)
    assert np.mean(np.diff(rest.steady.displacement_mm[moving == 0.0]) == 0.0) > 0.8
    begun = np.maximum.accumulate(np.where(np.diff(moving, prepend=1.0) != 0.0, t, 0.0))
    short = 3.0 * noise * np.exp(-(t - begun) / slow_s) * (moving == 0.0) * np.where(x > 0.5 * TRAVEL, -1.0, 1.0)
    off = record_of(t, x + short, noise).steady.displacement_mm - (x + short)
    up = (moving == 0.0) & (x > 0.5 * TRAVEL)
    at = np.round((t - begun)[up], 3)
    alike = [off[up][at == one].mean() for one in np.unique(at)]
    assert np.sqrt(np.mean(np.square(alike))) < 0.4 * noise


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("per_stroke", [15, 100])
def test_reversals_without_holds_are_found_and_nothing_is_called_a_hold(per_stroke, noise):
    t, x, direction, _, cycle, _ = trapezoid(10.0, 0.0, per_stroke)
    record = record_of(t, x, noise)
    found = record.inputs
    turns = np.flatnonzero(np.diff(direction))
    judged = np.ones(len(t), bool)
    judged[np.concatenate([turns, turns + 1])] = False
    np.testing.assert_array_equal(found.direction[judged], direction[judged])
    np.testing.assert_array_equal(found.cycle[judged], cycle[judged])
    assert found.moving.all()


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("per_cycle", [24, 100, 1000])
@pytest.mark.parametrize("period", [0.5, 5.0, 60.0])
def test_a_sine_is_cut_at_its_turning_points_and_its_speed_followed(period, per_cycle, noise):
    t, x, direction, _, cycle, velocity = sine(period, per_cycle)
    record = record_of(t, x, noise)
    found = record.inputs
    sure = np.abs(velocity) > 0.25 * np.abs(velocity).max()
    np.testing.assert_array_equal(found.direction[sure], direction[sure])
    np.testing.assert_array_equal(found.cycle[sure], cycle[sure])
    assert found.moving[sure].all()
    error = found.velocity[sure] - velocity[sure]
    assert np.sqrt(np.mean(error**2)) < (0.15 if per_cycle < 50 else 0.03) * np.abs(velocity).max()


def test_several_speeds_in_one_run_keep_their_own_speed():
    parts, clock = [], 0.0
    for speed in (2.0, 10.0, 40.0):
        t, *rest = trapezoid(speed, 4.0, 40, cycles=2)
        parts.append(np.array([t + clock, *rest]))
        clock += t[-1] + 0.2
    t, x, _, moving, _, speed = np.concatenate(parts, axis=1)
    found = record_of(t, x, 0.01).inputs
    for value in (2.0, 10.0, 40.0):
        of = found.stroke_speed[(speed == value) & (moving == 1.0)]
        assert np.median(of) == pytest.approx(value, rel=0.03)
        assert np.mean(np.abs(of / value - 1.0) < 0.1) > 0.95
    assert set(np.unique(found.cycle)) == {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}


def test_isobars_are_separate_segments_and_cycles_start_anew_on_each():
    t, x, *_ = trapezoid(10.0, 2.0, 30, cycles=2)
    time = np.concatenate([t, t + t[-1] + 30.0])
    pressure = np.repeat([0.3, 0.1], len(t)) + 1e-4 * np.random.default_rng(1).standard_normal(2 * len(t))
    record = build_record("r", MUSCLE, pressure, np.tile(x, 2) / 200.0, np.zeros(2 * len(t)), time=time)
    np.testing.assert_allclose(record.levels, [0.1, 0.3], atol=1e-4)
    np.testing.assert_array_equal(record.inputs.segment, np.repeat([0, 1], len(t)))
    assert record.inputs.cycle[len(t)] == 1.0
    assert len(np.unique(record.block)) == 4 and record.block_kind == "cycle"


def test_a_run_that_begins_at_rest_after_a_contraction_counts_as_extension_next():
    t, x, *_ = trapezoid(10.0, 2.0, 30, cycles=1)
    still = np.arange(-20, 0) * 0.1
    record = record_of(np.r_[still, t], np.r_[np.zeros(20), x], 0.005)
    assert not record.inputs.moving[:19].any()
    np.testing.assert_array_equal(record.inputs.direction[:19], -1.0)
    np.testing.assert_array_equal(record.inputs.direction[22:50], 1.0)


def test_noise_of_the_position_is_estimated_from_the_track_itself():
    x = sine(10.0, 1000)[1]
    for noise in (0.01, 0.1):
        seen = x + noise * np.random.default_rng(5).standard_normal(len(x))
        assert position_noise(seen) == pytest.approx(noise, rel=0.15)
    assert position_noise(np.arange(4.0)) == 0.0


def test_a_turn_of_few_samples_is_no_noise_of_the_position():
    """Once fast strokes read by few samples made it 1.9 mm in place of 0.014, and a ripple passed for the noise."""
    there = np.linspace(0.0, 40.0, 6)[:-1]
    x, run = np.tile(np.r_[there, 40.0 - there], 40), np.repeat(np.arange(80), 5)
    time, noise = np.arange(len(x)) * 0.05, 0.01
    seen = x + noise * np.random.default_rng(6).standard_normal(len(x))
    assert noise_around(seen, time).max() > 1.0
    assert np.sqrt(np.mean(noise_around(seen, time, run) ** 2)) == pytest.approx(noise, rel=0.15)


def test_a_record_that_never_moves_is_read_and_holds_no_motion():
    t = np.arange(40) * 0.1
    record = build_record("r", MUSCLE, np.full(40, 0.3), np.full(40, 0.1), np.full(40, 500.0), time=t)
    assert np.all(record.inputs.velocity == 0.0)
    assert np.isfinite(record.inputs.direction).all()


def test_one_sample_is_a_record():
    one = np.ones(1)
    assert len(build_record("r", MUSCLE, 0.3 * one, 0.1 * one, one, time=one)) == 1


@pytest.mark.parametrize("speed", [2.0, 10.0, 40.0])
def test_a_drive_that_speeds_up_and_brakes_within_a_few_samples_is_read_as_it_moves(speed):
    share, stroke, n = 0.1, 50.0, 40
    duration = stroke / speed / (1.0 - share)
    u = np.linspace(0.0, 1.0, n)
    rising, falling = u**2 / (2 * share), 1.0 - share - (1.0 - u) ** 2 / (2 * share)
    way = np.where(u < share, rising, np.where(u > 1.0 - share, falling, u - share / 2)) / (1.0 - share)
    pace = speed * np.minimum(1.0, np.minimum(u, 1.0 - u) / share)
    rest = np.linspace(0.1, 4.0, 12)
    t = np.r_[u * duration, duration + rest, duration + 4.05 + u * duration, 2 * duration + 4.05 + rest]
    x = stroke * np.r_[way, np.ones(12), 1.0 - way, np.zeros(12)]
    inputs = record_of(t, x, 0.01, seed=3).inputs
    true = np.r_[pace, np.zeros(12), -pace, np.zeros(12)]
    assert np.max(np.abs(inputs.velocity - true)) < 0.13 * speed
    assert np.sqrt(np.mean((inputs.velocity - true) ** 2)) < 0.04 * speed


@pytest.mark.parametrize("rests", [True, False], ids=["ticks at rest", "slides already"])
def test_the_force_tells_whether_the_last_sample_of_a_hold_still_rests(rests):
    """A clock ticks through holds and strokes; friction turns after that sample, or at it."""
    tick, rng = np.arange(16, dtype=float), np.random.default_rng(5)
    up = np.r_[2.5 * tick, np.full(10, TRAVEL)]
    x, sign = np.tile(np.r_[up, TRAVEL - up], 4), np.tile(np.repeat([1.0, -1.0], 26), 4)
    begins = (np.arange(len(x)) % 26 == 0) & (np.arange(len(x)) > 0)
    slides = np.where(begins & rests, -sign, sign)
    force = 900.0 - 12.0 * x - 8.0 * slides + 0.5 * rng.standard_normal(len(x))
    noisy = x + 0.02 * rng.standard_normal(len(x))
    made = build_record("r", MUSCLE, np.full(len(x), 0.3), noisy / 200.0, force, time=0.1 * np.arange(len(x)))
    assert made.inputs.moving[begins].tolist() == [not rests] * 7
    assert made.inputs.direction[begins].tolist() == slides[begins].tolist()
    assert (made.inputs.velocity[begins] == 0.0).all() == rests


@pytest.mark.parametrize(("noise", "rows"), [(0.001, 3), (0.04, 3)])
def test_a_stroke_with_stops_in_few_rows_rests_there_and_is_read_as_it_arrives(noise, rows):
    rng = np.random.default_rng(5)
    time, x, moves, now, place = [0.0], [0.0], [False], 0.0, 0.0
    for speed in (1.6, 5.6, 19.5):
        for way in [*[7.5] * 5, *[-7.5] * 5] * 3:
            for k in range(rows):
                time.append(now + 7.5 / speed * (k + 1) / rows)
                x.append(place + way * (k + 1) / rows)
                moves.append(True)
            now, place = time[-1], x[-1]
            for _ in range(3):
                now += 0.5
                time.append(now)
                x.append(place)
                moves.append(False)
    time, x, moves = np.array(time), np.array(x), np.array(moves)
    found = find_motion(time, x + noise * rng.standard_normal(len(x)), np.full(len(x), 0.3))
    corner = ~moves & np.r_[moves[1:], False]  # the last of a rest lies on the next stroke's line, too
    assert np.mean((found.moving == moves)[~corner]) > 0.98
    speeds = np.abs(found.velocity[found.moving & moves])
    assert np.median(speeds) == pytest.approx(5.6, rel=0.02) and np.quantile(speeds, 0.1) == pytest.approx(1.6, rel=0.1)


@pytest.mark.parametrize(("rows", "between"), [(2, ()), (3, ()), (3, (38.6,))])
def test_a_way_back_in_a_single_step_is_a_stroke(rows, between):
    """A short way out in some rows, and back to the same rest at once, or over one sample: friction turns twice."""
    up = np.linspace(0.0, 40.0, 60)
    dip = np.r_[np.linspace(40.0, 38.0, rows + 1)[1:], between]
    x = np.r_[up, np.full(30, 40.0), dip, np.full(30, 40.0), up[::-1], np.zeros(30)]
    x = x + 0.01 * np.random.default_rng(1).standard_normal(len(x))
    found = find_motion(0.1 * np.arange(len(x)), x, np.full(len(x), 0.3))
    again = slice(90 + len(dip) + 1, 120 + len(dip))
    assert np.all(found.direction[91 : 90 + rows] == -1.0)
    assert np.all(found.direction[again] == 1.0) and not found.moving[again].any()


def test_slow_turns_beside_strokes_with_holds_are_no_rests():
    """Sines of 10 s, and then a trapezoid, which no smooth strokes describe: it rests, and the sines do not."""
    rng, slow = np.random.default_rng(4), np.arange(0.0, 40.0, 0.005)
    sines = 15.0 - 15.0 * np.cos(0.2 * np.pi * slow)
    clock, x, _, moving, *_ = trapezoid(40.0, 1.0, 200, in_hold=200)
    time, x = np.r_[slow, 40.0 + clock], np.r_[sines, 0.75 * x]
    found = find_motion(time, x + 0.01 * rng.standard_normal(len(x)), np.full(len(x), 0.3))
    turned = time[1:][np.diff(found.direction) != 0.0]
    np.testing.assert_allclose(turned[turned < 38.0], np.arange(5.0, 38.0, 5.0), atol=0.1)
    assert np.mean(found.moving[: len(slow) - 200]) == 1.0
    assert np.mean(found.moving[len(slow) :] == moving) > 0.99


@pytest.mark.parametrize("seed", range(3))
def test_a_stroke_within_the_noise_from_rest_to_rest_turns_the_direction(seed):
    """2.5 mm, where a sample is off by 0.5 mm: two levels of many samples tell, and friction turns between them."""
    out, back = np.linspace(2.0, 32.0, 60), np.linspace(29.5, 2.0, 55)
    once = np.r_[out, np.full(40, 32.0), np.linspace(32.0, 29.5, 6)[1:], np.full(40, 29.5), back, np.full(40, 2.0)]
    x = np.tile(once, 4) + 0.5 * np.random.default_rng(seed).standard_normal(4 * len(once))
    found = find_motion(0.05 * np.arange(len(x)), x, np.full(len(x), 0.3))
    at = np.arange(len(x)) % len(once)
    assert np.mean(found.direction[(at > 65) & (at < 95)] == 1.0) > 0.9
    assert np.mean(found.direction[(at > 108) & (at < 140)] == -1.0) > 0.98
    assert np.mean(found.moving[(at > 110) & (at < 138)]) < 0.02
    assert found.moving.reshape(4, -1)[:, 98:106].any(axis=1).all()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_record_that_begins_with_a_wait_before_loops_without_holds_rests_there(seed):
    """A smooth first stroke would describe wait and ramp to the noise; but no turn is so slow."""
    rng = np.random.default_rng(seed)
    turns = np.column_stack([rng.uniform(20.0, 50.0, 8), rng.uniform(3.0, 18.0, 8)]).ravel()
    way = [np.full(34, 2.5)]
    for end in turns:
        begin = way[-1][-1]
        way.append(np.linspace(begin, end, max(int(abs(end - begin) / 0.6), 4) + 1)[1:])
    x = np.concatenate(way)
    x = x + 0.8 * rng.standard_normal(len(x))
    found = find_motion(0.06 * np.arange(len(x)), x, np.full(len(x), 0.3))
    assert not found.moving[:30].any() and found.moving[40:].mean() > 0.95


def test_a_muscle_at_rest_while_the_pressure_goes_up_in_a_ramp_leans_the_way_it_came():
    """A ramp is many levels of a few samples each: none of them is a stroke, whichever way their noise goes."""
    once = np.r_[np.linspace(0.0, 30.0, 60), np.full(100, 30.0)]
    x = np.r_[once, once[::-1], once[:1].repeat(60)] + 0.3 * np.random.default_rng(1).standard_normal(380)
    level = np.full(len(x), 0.2)
    level[100:150] = 0.2 + 0.002 * np.arange(50)
    level[150:] = 0.3
    found = find_motion(0.1 * np.arange(len(x)), x, level)
    assert not found.moving[105:145].any() and np.all(found.direction[70:150] == 1.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_drive_of_many_sines_turns_slowly_and_rests_nowhere(seed):
    rng, time = np.random.default_rng(seed), np.arange(0.0, 60.0, 0.01)
    rates, phases = rng.uniform(0.15, 2.0, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
    angle, size = 2.0 * np.pi * rates * time[:, None] + phases, 20.0 / (1.0 + rates)
    x, speed = np.sin(angle) @ size, np.cos(angle) @ (2.0 * np.pi * rates * size)
    found = find_motion(time, x + 0.17 * rng.standard_normal(len(x)), np.full(len(x), 0.3))
    assert found.moving.mean() > 0.99
    fast = np.abs(speed) > 4.0
    assert np.mean(found.direction[fast] == np.sign(speed[fast])) > 0.985


@pytest.mark.parametrize("soft", [2, 3, 4])
def test_a_stroke_has_the_speeds_of_a_drive_that_speeds_up_and_brakes_within_samples(soft):
    """A polynomial swings over the stroke, and slopes over many neighbours know no corner: that passed for a force
    which follows the speed."""
    fine = np.linspace(0.0, 28.0, 2801)
    speed = 3.0 * np.minimum(1.0, np.minimum(fine, 28.0 - fine) / soft)
    way = 0.07 * np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]))] / 100.0
    time, x = 0.07 * fine[::100], way[::100]
    noise = 0.02 * np.random.default_rng(3).standard_normal((20, len(x)))
    off = [smooth_stroke(time, x + one, 0.02)[1] - speed[::100] for one in noise]
    assert np.sqrt(np.mean(np.square(off))) < 0.1 * 3.0


@pytest.mark.parametrize(("cut", "noise_alone"), [(0.0, True), (0.7, False)])
def test_what_a_curve_misses_at_a_kink_is_no_noise(cut, noise_alone):
    """It is as small as noise, but neighbours are off in the same sense."""
    phase = np.linspace(0.0, 6.0 * np.pi, 400)
    off = np.random.default_rng(3).standard_normal(400) + cut * 2.0**0.5 * np.sin(phase)
    assert noise_only(off, 1.0, 8) is noise_alone
    assert off @ off < 1.25**2 * 392  # by its size alone it would be
