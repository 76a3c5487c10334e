"""A test that is logged throughout holds its isobars, though its pressure takes its time from one to the next."""

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import Specimen
from pam_ident.records import record_from_frame

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 1.5)
LOOP = np.r_[np.zeros(10), np.linspace(0.0, 30.0, 40), np.linspace(30.0, 0.0, 40), np.zeros(10)]


def logged(ramp, pressures=(0.4, 0.1, 0.3), at_mm=0.0):
    """Two loops on each isobar, between which the pressure goes in `ramp` rows while the muscle rests at `at_mm`."""
    rng = np.random.default_rng(3)
    p, x = [np.empty(0)], [np.empty(0)]
    for before, level in zip((pressures[0], *pressures), pressures, strict=False):
        p += [np.linspace(before, level, ramp + 2)[1:-1], np.full(200, level)]
        x += [np.full(ramp, at_mm), np.tile(LOOP, 2)]
    p, x = np.concatenate(p), np.concatenate(x)
    p = p + 0.0003 * rng.standard_normal(len(p))
    table = {
        "time_s": 0.1 * np.arange(len(p)),
        "pressure_MPa": p,
        "displacement_mm": x,
        "force_N": 1000.0 * p - 4.0 * x,
    }
    return record_from_frame(pd.DataFrame(table), MUSCLE)


@pytest.mark.parametrize("ramp", [3, 8, 15])
def test_rows_between_isobars_are_left_out_and_make_none(ramp):
    record = logged(ramp)
    assert record.kind == "isobaric"
    assert record.levels == pytest.approx([0.1, 0.3, 0.4], abs=1e-3)
    (note,) = [one for one in record.notes if one.code == "between"]
    assert note.rows == 2 * ramp
    assert len(record) == 600 + ramp  # the first way leads nowhere, so all of it is an isobar's
    assert np.all(np.abs(record.inputs.pressure - record.level) < 0.005)


def test_direction_and_clock_go_on_over_what_is_left_out():
    record = logged(8)
    whole = np.flatnonzero(np.diff(record.inputs.time) > 0.15)
    assert np.diff(record.inputs.time)[whole] == pytest.approx([0.9, 0.9])
    assert np.all(record.inputs.direction[whole] == record.inputs.direction[whole + 1])


def test_a_pressure_that_is_driven_has_no_rows_between_isobars():
    assert logged(60).kind == "dynamic"
    assert not logged(60).notes


def test_a_pressure_that_dips_and_comes_back_stays():
    record = logged(3, pressures=(0.3, 0.3))
    dipped = record.inputs.pressure - 0.1 * np.isin(np.arange(len(record)), range(100, 106))
    columns = {"time_s": record.inputs.time, "pressure_MPa": dipped, "displacement_mm": record.inputs.displacement_mm}
    found = record_from_frame(pd.DataFrame(columns | {"force_N": record.force}), MUSCLE)
    assert len(found) == len(record) and not found.notes


def locked(ramp, seed=3, moved_at=0.1, apart=12.0, noise=0.05, gives=0.0):
    """Three lengths in turn, so many mm apart, at each the pressure up and down twice in steps, and `ramp` samples at
    `moved_at` MPa on the way to the next. The fixture `gives` so many mm at the largest pressure."""
    rng = np.random.default_rng(seed)
    p = np.tile(np.r_[np.linspace(0.1, 0.5, 40), np.linspace(0.5, 0.1, 40)], 2)
    p = p if gives == 0.0 else np.round(8.0 * p) / 8.0
    lengths = 2.0 + apart * np.arange(3)
    x = np.concatenate([np.r_[np.full(160, at), np.linspace(at, at + apart, ramp)] for at in lengths])
    pressure = np.tile(np.r_[p, np.full(ramp, moved_at)], 3)
    x = x + gives * (pressure - 0.1) / 0.4
    table = {
        "time_s": 0.1 * np.arange(len(x)),
        "pressure_MPa": pressure + 0.0003 * rng.standard_normal(len(x)),
        "displacement_mm": x + noise * rng.standard_normal(len(x)),
        "force_N": 1000.0 * pressure - 4.0 * x,
    }
    return record_from_frame(pd.DataFrame(table), MUSCLE)


@pytest.mark.parametrize("ramp", [5, 15])
def test_rows_in_which_a_locked_muscle_is_moved_are_left_out(ramp):
    record = locked(ramp)
    assert record.kind == "isometric"
    (note,) = [one for one in record.notes if one.code == "between_lengths"]
    assert note.column == "displacement_mm"
    assert 2 * (ramp - 3) <= note.rows <= 2 * ramp + 2
    held = np.unique(record.steady.displacement_mm.round(1))
    assert held[:3] == pytest.approx([2.0, 14.0, 26.0], abs=0.2)


@pytest.mark.parametrize(("apart", "noise", "ramp"), [(1.6, 0.05, 8), (2.0, 0.05, 5), (6.0, 0.25, 8)])
def test_lengths_that_lie_close_or_are_read_badly_are_as_many(apart, noise, ramp):
    """They ran together to one by readings on the way from one to the next."""
    record = locked(ramp, apart=apart, noise=noise)
    held = np.unique(record.steady.displacement_mm.round(2))
    assert held[:3] == pytest.approx(2.0 + apart * np.arange(3), abs=2.0 * noise)


def test_a_coarse_gauge_between_two_of_its_steps_reads_one_length():
    record = locked(15, noise=0.0)
    read = np.repeat(np.random.default_rng(5).random(len(record) // 12 + 1) < 0.3, 12)[: len(record)] * 0.5
    columns = {"time_s": record.inputs.time, "pressure_MPa": record.inputs.pressure, "force_N": record.force}
    table = pd.DataFrame(columns | {"displacement_mm": record.inputs.displacement_mm + read})
    held = np.unique(record_from_frame(table, MUSCLE).steady.displacement_mm.round(2))
    assert held[held < 30.0] == pytest.approx([2.0, 14.0, 26.0])


def test_where_a_fixture_gives_way_to_the_pressure_there_is_no_other_length():
    record = locked(15, noise=0.01, gives=0.7)
    assert record.kind == "isometric"
    assert len(np.unique(record.steady.displacement_mm.round(2))) == 3


def test_a_length_that_is_driven_with_the_pressure_is_not_left_out():
    record = locked(40, moved_at=np.linspace(0.1, 0.4, 40))
    assert not [one for one in record.notes if one.code == "between_lengths"]
