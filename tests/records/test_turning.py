"""Turning points and holds found many samples at a time are those found sample by sample; long runs are parted."""

from itertools import pairwise

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.records import build_record, turning
from pam_ident.records.motion import pieces
from pam_ident.rig import PROTOCOLS, Plan, make_record


def plain_pivots(x, threshold):
    found, furthest, heading = [0], {1: 0, -1: 0}, 0
    for i in range(1, len(x)):
        for side in (1, -1):
            furthest[side] = i if side * (x[i] - x[furthest[side]]) > 0 else furthest[side]
        for side, k in tuple(furthest.items()):
            if heading != -side and side * (x[k] - x[i]) > threshold:
                if heading == side or side * (x[k] - x[0]) > threshold:
                    found.append(k)
                heading, furthest = -side, {1: i, -1: i}
                break
    return found if found[-1] == len(x) - 1 else [*found, len(x) - 1]


def plain_holds(time, x, pace, band):
    held, start = np.zeros(len(x), bool), 0
    while start < len(x):
        stop = start + 1
        while stop < len(x) and np.ptp(x[start : stop + 1]) <= band:
            stop += 1
        middle = (start + stop) // 2
        way = (time[stop - 1] - time[start]) * pace[start:stop].min()
        still = stop - start == 3 and way > 20.0 * band
        if stop - start >= 4 and way > 3.0 * band:
            still = abs(x[middle:stop].mean() - x[start:middle].mean()) < band / 3.0
        held[start:stop] |= still
        start = stop if still else start + 1
    return held


def tracks():
    rng = np.random.default_rng(11)
    for k in range(24):
        n = int(rng.integers(3, 1500))
        clipped = np.clip(1.4 * np.sin(np.arange(n) * (0.01, 0.05, 0.3)[k % 3]), -1.0, 1.0)
        yield np.cumsum(rng.choice([0.01, 0.02], n)), 10.0 * clipped + (0.0, 0.01, 1.0)[k // 8] * rng.standard_normal(n)


def test_pivots_are_those_of_a_plain_loop():
    for _, x in tracks():
        for threshold in (0.0, 0.04, 2.0):
            assert turning.pivots(x, threshold) == plain_pivots(x, threshold)


def test_holds_are_those_of_a_plain_loop():
    found = 0
    for time, x in tracks():
        turns, band, pace = plain_pivots(x, 0.5), 0.1, np.zeros(len(x))
        for begin, end in pairwise(turns):
            part = slice(begin, end + 1)
            pace[part] = np.maximum(pace[part], turning._pace(time[part], x[part]))
        held = turning._holds(time, x, turns, band)
        np.testing.assert_array_equal(held, plain_holds(time, x, pace, band))
        found += int(held.sum())
    assert found > 1000


def test_a_run_longer_than_a_piece_is_parted_where_it_turns(monkeypatch):
    monkeypatch.setattr(turning, "PIECE", 1000)
    x = 20.0 - 20.0 * np.cos(2.0 * np.pi * np.arange(5000) / 300.0)
    time = np.arange(5000.0)
    columns = (time, x, 0.0 * x, 2.0 * x)
    parts = list(pieces(5000, lambda begin, end: tuple(column[begin:end] for column in columns), 0.2, np.inf))
    fresh, *found = zip(*parts, strict=True)
    for one, column in zip(found, (time, x, 2.0 * x), strict=True):
        np.testing.assert_array_equal(np.concatenate(one), column)
    assert fresh == (True, *[False] * (len(parts) - 1))
    assert all(len(when) <= 1000 for when in found[0])
    assert all((when[-1] + 1.0) % 150 == 0 for when in found[0][:-1])


def test_strokes_and_cycles_are_the_same_whole_and_in_pieces(monkeypatch):
    n = 20_000
    t = 0.01 * np.arange(n)
    x = 20.0 - 20.0 * np.cos(0.4 * np.pi * t) + 0.005 * np.random.default_rng(3).standard_normal(n)

    def record():
        return build_record("r", Specimen(), np.full(n, 0.3), x / 200.0, 900.0 - x, time=t)

    whole = record()
    monkeypatch.setattr(turning, "PIECE", 2000)
    parted = record()
    near = np.abs(np.sin(0.4 * np.pi * t)) < 0.1  # where noise says which sample is the turn
    for name in ("direction", "cycle"):
        np.testing.assert_array_equal(getattr(parted.inputs, name)[~near], getattr(whole.inputs, name)[~near])
    assert parted.inputs.cycle.max() == whole.inputs.cycle.max() == 40


@pytest.mark.parametrize("name", ["standard", "six_pressures", "long_holds"])
def test_isobars_are_found_where_noise_makes_many_pressures(name):
    made = make_record(Plan(3, protocol=name))
    column, length = made.column, made.muscle.specimen.initial_length_mm
    given = column("pressure_MPa"), column("displacement_mm") / length, column("force_N")
    found = build_record("r", Specimen(initial_length_mm=length), *given, time=column("time_s"))
    np.testing.assert_allclose(found.levels, PROTOCOLS[name].pressures_MPa, atol=2e-4)
    np.testing.assert_allclose(found.level, column("pressure_set_MPa"), atol=2e-4)


def test_lone_samples_off_the_track_are_no_strokes():
    x = np.concatenate([np.linspace(0, 40, 200), np.linspace(40, 0, 200)] * 3)
    pivots = turning.pivots
    turns = pivots(x, 0.2)
    spiked = x.copy()
    for k in (50, 333, 335, 700, 1010):
        spiked[k] += 0.5 * np.sign(x[k - 1] - x[k])
    assert len(pivots(spiked, 0.2)) > len(turns)
    assert turning.without_spikes(spiked, pivots(spiked, 0.2), 40.0) == turning.without_spikes(x, turns, 40.0) == turns
    zigzag = np.tile([0.0, 40.0], 20)
    assert turning.without_spikes(zigzag, pivots(zigzag, 0.2), 40.0) == pivots(zigzag, 0.2)
