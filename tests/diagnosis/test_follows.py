"""What the error follows, by shares: planted dependences of forms that no effect has, and none in noise."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis.follows import Following
from pam_ident.diagnosis.schedule import way_is_time
from pam_ident.diagnosis.sentence import told
from pam_ident.diagnosis.steady import steadied
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record, read_record
from pam_ident.rig import Plan, Protocol, make_record, write_case

SPECIMEN = Specimen("bench", 200.0, 10.0, 25.4, 1.5)


def record_with(hidden, seed=3, colour=0.0):
    """Three isobars of four cycles at two speeds in turn, with holds, warming, and noise of 1 N."""
    travel, level, cycle = [], [], []
    for p in (0.2, 0.35, 0.5):
        for k in range(4):
            step = (0.4, 1.6)[k % 2]
            rise = np.arange(step, 40.0 + step / 2, step)
            there = np.r_[rise, np.full(15, 40.0)]
            travel.append(np.r_[there, 40.0 - there])
            level.append(np.full(2 * len(there), p))
            cycle.append(np.full(2 * len(there), k + 1.0))
    x, pressure, cycle = (np.concatenate(v) for v in (travel, level, cycle))
    time, e = 0.1 * np.arange(len(x)), x / SPECIMEN.initial_length_mm
    warm = 20.0 + 12.0 * (1.0 - np.exp(-time / 60.0)) + 4.0 * np.sin(time / 15.0)
    noise = np.random.default_rng(seed).standard_normal(len(x))
    for k in range(1, len(noise)):
        noise[k] = colour * noise[k - 1] + np.sqrt(1.0 - colour**2) * noise[k]
    force = pressure * (2400.0 - 9000.0 * e) - 150.0 - 600.0 * e + noise
    record = build_record("rig", SPECIMEN, pressure, e, force, time=time, cycle=cycle, temperature=warm)
    i = record.inputs
    at = {"p": i.pressure, "e": i.contraction, "s": i.direction * i.moving, "v": np.abs(i.velocity), "n": i.cycle}
    return replace(record, force=force + hidden(at | {"t": time, "T": warm - warm[0]}))


PLANTED = {
    "direction": lambda at: -6.0 * at["s"] * (0.4 + 15.0 * at["e"] ** 2 + at["p"]),
    "speed": lambda at: -0.8 * at["s"] * at["v"] ** 0.8 * (1.0 - 2.0 * at["e"]),
    "temperature": lambda at: -0.5 * at["T"] * (0.3 + 4.0 * at["e"]),
    "cycle": lambda at: 12.0 * np.exp(-(at["n"] - 1.0) / 0.8) * (0.2 + 3.0 * at["e"] * at["p"]),
    "clock": lambda at: 8.0 * np.sqrt(at["t"] / at["t"].max()),
    "map": lambda at: 25.0 * np.cos(25.0 * at["e"]) * (1.0 - at["p"]),
}


def shares(record):
    return {one.what: one.share for one in Following.of(fit(Model.build("exponential_law"), record)).shares()}


@pytest.mark.parametrize("size", [20.0, -15.0])
def test_a_single_step_is_told_as_one_and_hides_nothing_else(size):
    """A load cell zeroed late: smooth surfaces over rest and clock would take the step, and what follows the motion."""
    found = record_with(lambda at: PLANTED["direction"](at) + np.where(at["t"] < 100.0, -size, 0.0))
    following = Following.of(fit(Model.build("exponential_law"), found))
    share = {one.what: one.share for one in following.shares()}
    assert following.leap.moment == pytest.approx(100.0, abs=1.0)
    assert following.leap.size_N == pytest.approx(size, rel=0.25)
    assert share["step"] > 0.3 and share["direction"] > 0.1 and share["step"] + share["direction"] > 0.85
    assert f"follows a single step of the force, by {following.leap.size_N:.3g} N at" in told(following.shares())


def test_no_step_is_seen_in_what_turns_with_the_motion_or_in_noise():
    for hidden in (PLANTED["direction"], PLANTED["clock"], lambda at: 0.0 * at["t"]):
        assert "step" not in shares(record_with(hidden))


@pytest.mark.parametrize("seed", [50, 51])
def test_a_rough_gauge_beside_a_weak_regulator_makes_the_error_follow_nothing(tmp_path, seed):
    """Its noise was in the columns and, by the slope of the force, in the error: the direction had 6 and 7 %."""
    weak = Protocol(breathing=0.02)
    write_case(tmp_path, make_record(Plan(seed, protocol=weak, gauges="noisy_pressure", sigma_N=1.0)))
    assert set(shares(read_record(tmp_path / "record.csv"))) == {"noise"}


def test_the_rate_of_a_driven_pressure_is_told_from_the_speed():
    t = 0.05 * np.arange(4000)
    turns = 2.0 * np.pi / np.array([23.0, 7.3])
    p = 0.4 + 0.1 * np.sin(np.outer(t, turns)).sum(axis=1)
    e = 0.1 - 0.1 * np.cos(2.0 * np.pi * t / 9.0)
    law = p * (2400.0 - 9000.0 * e) - 150.0 - 600.0 * e
    force = law + np.random.default_rng(4).standard_normal(len(t))
    rate = 0.1 * np.cos(np.outer(t, turns)) @ turns
    record = build_record("rig", SPECIMEN, p, e, force, time=t)
    found = shares(replace(record, force=force + 1000.0 * rate**2))
    others = sum(share for name, share in found.items() if name not in ("pressure_rate", "noise"))
    assert record.kind == "dynamic" and found["pressure_rate"] > 0.5 and others < 0.1 * found["pressure_rate"], found


@pytest.mark.parametrize("what", PLANTED)
def test_what_was_planted_has_the_largest_share(what):
    found = shares(record_with(PLANTED[what]))
    assert sum(found.values()) == pytest.approx(1.0)
    others = sum(share for name, share in found.items() if name not in (what, "noise"))
    assert found[what] > 0.3 and others < 0.1 * found[what], found


@pytest.mark.parametrize(("hold_s", "words"), [(0.0, "relaxation"), (3.0, "rest and relaxation")])
def test_rest_is_told_only_where_something_rests(hold_s, words):
    t = 0.1 * np.arange(800)
    way = np.cumsum(t % 10.0 >= hold_s) * 0.2 % 40.0
    p, e = 0.2 + 0.1 * (t > 40.0), 0.06 - 0.06 * np.cos(2.0 * np.pi * way / 20.0)
    relaxed = np.zeros(len(t))
    for k in range(1, len(t)):
        relaxed[k] = relaxed[k - 1] + 0.02 * (e[k] - relaxed[k - 1])
    force = SPECIMEN.ideal_force(p, e) + 400.0 * relaxed + np.random.default_rng(2).standard_normal(len(t))
    record = build_record("rig", SPECIMEN, p, e, force, time=t)
    found = Following.of(fit(Model.build("chou_hannaford"), record)).shares()
    assert [one.text for one in found if one.what == "rest"] == [words]


@pytest.mark.parametrize("grown", [2.0, 3.0])
def test_what_grows_faster_than_the_warming_follows_the_temperature(grown):
    """Of the warming alone as its state rest and relaxation had a part of it."""
    found = shares(record_with(lambda at: -24.0 * (at["T"] / 12.0) ** grown * (0.3 + 4.0 * at["e"])))
    assert found["temperature"] > 0.9 and set(found) == {"temperature", "noise"}, found


def test_two_causes_have_a_share_each():
    found = shares(record_with(lambda at: 0.3 * PLANTED["direction"](at) + PLANTED["clock"](at)))
    assert found["direction"] > 0.2 and found["clock"] > 0.1
    assert found["direction"] + found["clock"] + found["noise"] > 0.97


def test_what_several_could_explain_is_the_likeliest_ones():
    """Alone the speed would explain most of it, too, as strokes are of two speeds."""
    planted = ("direction", "speed", "clock")
    found = shares(record_with(lambda at: sum(s * PLANTED[w](at) for s, w in zip((3, 0.5, 0.3), planted, strict=True))))
    assert found["direction"] > 0.9 and sum(found.values()) == pytest.approx(1.0), found


@pytest.mark.parametrize("colour", [0.0, 0.7])
@pytest.mark.parametrize("seed", range(4))
def test_noise_follows_nothing(seed, colour):
    found = shares(record_with(lambda at: 0.0 * at["t"], seed, colour))
    assert found["noise"] > 0.98, found


@pytest.mark.parametrize("what", ["direction", "speed", "map"])
@pytest.mark.parametrize("seed", range(3))
def test_what_is_slow_in_noise_follows_no_driver_beside_what_is_there(what, seed):
    found = shares(record_with(lambda at: 0.4 * PLANTED[what](at), seed, 0.9))
    assert set(found) == {what, "noise"}, found


def test_what_comes_back_and_follows_nothing_is_told_apart_from_noise():
    comb = record_with(lambda at: 6.0 * np.sign(np.sin(at["e"] * 200.0 * 2.0 * np.pi / 3.1)))
    found = Following.of(fit(Model.build("exponential_law"), comb)).shares()
    by_name = {one.what: one.share for one in found}
    assert by_name["repeats"] > 0.5
    assert "comes back with every repeat" in told(found)


def test_of_a_motion_that_smoothing_bends_nothing_is_taken_off():
    """Up to fourteen waves in 40 samples, five times at each pressure, by a position sensor that is off by 0.05 mm."""
    rng = np.random.default_rng(1)
    phase, turn = rng.uniform(0.0, 2.0 * np.pi, (14, 1)), 2.0 * np.pi * np.arange(40) / 40
    x = np.sum(np.cos(np.arange(1, 15)[:, None] * turn + phase), axis=0)
    x = np.tile(40.0 * (x - x.min()) / np.ptp(x), 10)
    pressure, e = np.repeat((0.2, 0.4), 200), x / SPECIMEN.initial_length_mm
    force = pressure * (2400.0 - 9000.0 * e) - 600.0 * e + rng.standard_normal(400)
    seen = e + 0.05 / SPECIMEN.initial_length_mm * rng.standard_normal(400)
    record = build_record("rig", SPECIMEN, pressure, seen, force, time=0.1 * np.arange(400))
    found = fit(Model.build("exponential_law"), record)
    steady, _ = steadied(record, found.model, found.values)
    assert np.std(record.steady.displacement_mm - x) > 5.0  # by smoothing alone
    assert np.std(steady.inputs.displacement_mm - x) == pytest.approx(0.05, rel=0.1)
    assert [one.what for one in Following.of(found).shares()] == ["noise"]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_imitates_two_drivers_does_not_hide_them(seed):
    """A loop at each of two speeds: relaxation alone follows them nearly as well as the map and the direction do."""
    rise = np.linspace(0.0, 1.0, 18)[1:]
    x = np.tile(np.r_[rise, rise[-2::-1], 0.0], 6)
    side = np.tile(np.repeat([1.0, -1.0], 17), 6)
    time = np.cumsum(np.tile(np.repeat([1.0, 0.3], 34), 3)) + np.repeat([0.0, 100.0, 200.0], 68)
    p, e = np.repeat([0.4, 0.6, 0.2], 68), 0.25 * x
    noise = 1.2 * np.random.default_rng(seed).standard_normal(len(x))
    force = SPECIMEN.ideal_force(p - 0.04, e) - 3.0 * side + noise
    record = build_record("short", SPECIMEN, p, e, force, time=time)
    found = Following.of(fit(Model.build("modified_chou_hannaford"), record)).shares()
    assert {one.what for one in found} == {"map", "direction", "noise"}


def strokes(hidden, speeds=(1.0,), hold=0, seed=1, noise=1.0, pressures=(0.2, 0.4)):
    """Triangles of three amplitudes on each isobar, `hold` rows at each turn, and what is hidden of the way gone."""
    ends, track = (0.0, 40.0, 5.0, 25.0, 0.0, 40.0, 12.0, 30.0, 0.0), [np.zeros(1)]
    for k, (begin, end) in enumerate(pairwise(ends)):
        rows = round(abs(end - begin) / speeds[k % len(speeds)])
        track += [np.linspace(begin, end, rows + 1)[1:], np.full(hold, end)]
    x = np.tile(np.concatenate(track), len(pressures))
    p, e = np.repeat(pressures, len(x) // len(pressures)), x / SPECIMEN.initial_length_mm
    rng = np.random.default_rng(seed)
    force = SPECIMEN.ideal_force(p, e) + hidden(x) + noise * rng.standard_normal(len(x))
    time = 0.1 * np.arange(len(x)) + 20.0 * (p > pressures[0])
    return build_record("strokes", SPECIMEN, p, e, force, time=time)


def dahl(x):
    """Friction of 12 N that builds up over 6 mm."""
    z = np.zeros(len(x))
    for k, step in enumerate(np.diff(x), start=1):
        z[k] = np.sign(step) + (z[k - 1] - np.sign(step)) * np.exp(-abs(step) / 6.0)
    return -12.0 * z


def likely(record):
    return Following.of(fit(Model.build("chou_hannaford"), record)).likely


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_friction_that_builds_up_along_the_way_follows_the_way(seed):
    """By straight courses over the way alone relaxation was likelier."""
    found = likely(strokes(dahl, seed=seed, hold=3))
    assert found >= {"way", "direction"} and "rest" not in found


def test_where_nothing_rests_at_one_speed_way_and_relaxation_are_one():
    assert way_is_time(strokes(dahl))
    assert not way_is_time(strokes(dahl, hold=10)) and not way_is_time(strokes(dahl, speeds=(0.5, 2.0, 1.0)))
    assert "rest" in likely(strokes(dahl)) and "rest" not in likely(strokes(dahl, hold=3))


@pytest.mark.parametrize("seed", [2, 3])
def test_another_driver_that_could_stand_in_the_place_of_one_is_likely(seed):
    """A slight drift in one run: the cycle, or relaxation, is as likely, and the clock was not tried beside them."""

    def drifting(x):
        return -0.8 * np.gradient(x, 0.1) - 0.012 * np.arange(len(x))

    assert likely(strokes(drifting, speeds=(0.4, 1.6, 0.9), seed=seed, pressures=(0.3,))) >= {"speed", "clock"}
