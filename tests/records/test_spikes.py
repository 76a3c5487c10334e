"""Single readings that leave all others decide nothing: they are left out and told, or stop naming."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import Specimen
from pam_ident.records import read_record, record_from_frame
from pam_ident.records.clipped import clipped_rows
from pam_ident.records.datasets import dataset_record
from pam_ident.records.faulty import spike_rows
from pam_ident.records.gate import doubts_of
from pam_ident.tasks.compare import compare_record
from pam_ident.tasks.diagnose import diagnose_record
from pam_ident.tasks.fit import fit_record
from pam_ident.tasks.gate import GraveDoubt, may_name
from pam_ident.tasks.setup import Setup

HOME = dataset_record("nothing_hidden")
SETUP = Setup("exponential_law")


def spoilt(rows, off):
    """The data set's table with something added to the force of some rows."""
    table = pd.read_csv(HOME)
    table.loc[rows, "force_N"] += off
    return table


@pytest.fixture(scope="module")
def clean():
    return fit_record(read_record(HOME), SETUP).fits["together"]


@pytest.fixture(scope="module")
def some():
    """Rows and what is added there: 0.2 %, by 50 to 500 N to either side, two of them side by side."""
    rng = np.random.default_rng(11)
    rows = rng.choice(4600, 8, replace=False)
    return np.r_[rows, rows[:1] + 1], rng.choice([-1.0, 1.0], 9) * rng.uniform(50.0, 500.0, 9)


@pytest.mark.long
def test_spikes_are_left_out_and_change_no_answer(clean, some, tmp_path):
    table = spoilt(*some)
    record = record_from_frame(table, clean.record.specimen)
    (note,) = record.notes
    assert (note.code, note.rows, note.column) == ("spike", 9, "force_N") and f"row {min(some[0])})" in note.text
    answer = fit_record(record, SETUP)
    assert "spike" in [doubt.code for doubt in answer.warnings]
    for one, good in zip(answer.fits["together"].estimates, clean.estimates, strict=True):
        assert abs(one.value - good.value) < 0.2 * good.stderr, one.name
    assert compare_record(record, SETUP).fit.rmse == pytest.approx(clean.rmse, rel=0.01)
    assert diagnose_record(record, SETUP).verdict == "adequate"
    table.to_csv(tmp_path / "run.csv", index=False)
    in_chunks = fit_record(tmp_path / "run.csv", replace(SETUP, specimen=str(HOME.with_name("specimen.toml"))))
    assert in_chunks.fits["together"].n == len(record) == len(table) - 9


@pytest.mark.parametrize("size", [3e4, -1e6])
def test_what_no_muscle_pulls_is_left_out_and_stops_names(clean, size):
    record = record_from_frame(spoilt([1234], size), clean.record.specimen)
    assert fit_record(record, SETUP).fits["together"].rmse == pytest.approx(clean.rmse, rel=1e-3)
    with pytest.raises(GraveDoubt, match=r"row 1234.* --assume impossible_value"):
        may_name(record, SETUP.model)
    assert [d.code for d in may_name(record, SETUP.model, ("impossible_value",)) if d.grave] == ["impossible_value"]


def test_a_row_that_decides_the_fit_of_a_table_stops_names():
    record = read_record("dmsp20_300")
    setup = Setup("martens_boblan")
    assert not [doubt for doubt in may_name(record, setup.model) if doubt.grave]
    force = record.force.copy()
    force[17] += 300.0
    with pytest.raises(GraveDoubt, match=r"sample 18 reads .* --assume outlier"):
        may_name(replace(record, force=force), setup.model)
    (told,) = [d for d in fit_record(replace(record, force=force), setup).warnings if d.grave]
    assert told.code == "outlier"


TIME = np.arange(400.0)
SHAPES = {
    "sharp turns": 20.0 * np.abs(TIME % 40 - 20),
    "turns with friction": 20.0 * np.abs(TIME % 40 - 20) + 60.0 * (TIME % 40 < 20),
    "a step": 300.0 + 200.0 * (TIME > 200),
    "holds": 300.0 * np.round(np.sin(TIME / 20.0)),
    "a burst": 300.0 + 200.0 * np.exp(-np.maximum(TIME - 150, 0.0) / 5.0) * (TIME >= 150),
    "a tug of four readings": 300.0 + 100.0 * ((TIME >= 100) & (TIME < 104)),
    "a hum": 300.0 + 50.0 * np.sin(1.9 * TIME),
    "a reading in the midst of a turn": 20.0 * np.abs(TIME % 40 - 20) + 99.0 * (TIME > 220) + 50.0 * (TIME == 220),
}


@pytest.mark.parametrize("noise", [0.0, 2.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_what_muscles_and_rigs_do_is_no_spike(shape, noise):
    force = SHAPES[shape] + np.random.default_rng(3).normal(0.0, noise, len(TIME))
    assert not spike_rows({"time": TIME, "force": force})
    force[300] += 900.0
    (found,) = spike_rows({"time": TIME, "force": force}).values()
    assert np.flatnonzero(found).tolist() == [300]


def test_a_reading_between_two_isobars_is_no_spike():
    """The last isobar's force, less with the pressure, before friction turns with the motion; then a loose plug."""
    rng = np.random.default_rng(3)
    force = np.where(TIME < 200, 100.0, 60.0 + np.minimum(2.0 * (TIME - 200), 60.0)) + 25.0 * (TIME > 200)
    pressure = np.where(TIME < 200, 0.4, 0.3) + rng.normal(0.0, 2e-4, len(TIME))
    force += rng.normal(0.0, 1.0, len(TIME))
    assert spike_rows({"time": TIME, "force": force}), "without its pressure it looks like one"
    assert not spike_rows({"time": TIME, "force": force, "pressure": pressure})
    force[300] += 900.0
    pressure[300] += 0.2  # what spoils both is none of a valve's
    found = spike_rows({"time": TIME, "force": force, "pressure": pressure})
    assert {key: np.flatnonzero(rows).tolist() for key, rows in found.items()} == {"force": [300], "pressure": [300]}


@pytest.mark.parametrize("column", ["pressure_MPa", "displacement_mm"])
@pytest.mark.parametrize("reads", ["nothing", "far"])
def test_a_loose_plug_of_any_sensor_costs_its_rows_and_nothing_else(clean, column, reads):
    table = pd.read_csv(HOME)
    at = np.flatnonzero(table["displacement_mm"].between(*table["displacement_mm"].quantile([0.4, 0.6])))[
        [9, 99, 399, 699]
    ]
    broken = table.astype({column: float})
    broken.loc[at, column] = 0.0 if reads == "nothing" else 3.0 * table[column].max()
    found, expected = (record_from_frame(one, clean.record.specimen) for one in (broken, table.drop(index=at)))
    (note,) = [note for note in found.notes if note.code == "spike"]
    assert (note.rows, note.column) == (4, column)
    assert np.array_equal(found.level, expected.level) and np.array_equal(found.stroke, expected.stroke)


@pytest.mark.parametrize("apart", [(2,), (3,), (4,), (6, 11), (1, 11), (12, 24)])
def test_spikes_close_together_do_not_hide_one_another(apart):
    force = 300.0 + np.random.default_rng(3).normal(0.0, 2.0, len(TIME))
    at = np.r_[200, 200 + np.array(apart)]
    force[at] += 200.0 * (-0.7) ** np.arange(len(at))
    (found,) = spike_rows({"time": TIME, "force": force}).values()
    assert np.flatnonzero(found).tolist() == at.tolist()


def test_few_rows_and_many_such_readings_are_taken_as_they_are():
    rng = np.random.default_rng(5)
    short = {"time": TIME[:19], "force": np.where(TIME[:19] == 9, 900.0, 300.0)}
    often = {"time": TIME, "force": np.where(rng.random(400) < 0.1, 900.0, 300.0)}
    assert not spike_rows(short) and not spike_rows(often)
    x = np.arange(30.0)
    frame = pd.DataFrame({"pressure_MPa": 0.2, "displacement_mm": x, "force_N": 300.0 - 5.0 * x})
    frame.loc[7, "force_N"] = 5e4
    record = record_from_frame(frame, Specimen("m", 200.0, 10.0, 25.4, 1.5))
    assert len(record) == 29 and [d.code for d in doubts_of(record) if d.grave] == ["impossible_value"]


def test_a_load_cell_at_its_end_says_only_that_the_force_is_beyond(clean):
    table = pd.read_csv(HOME)
    end = 0.9 * table.force_N.max()
    here = table.force_N > end
    table.loc[here, "force_N"] = end
    specimen = read_record(HOME).specimen
    record = record_from_frame(table, specimen)
    assert [note.code for note in record.notes] == ["clipped"] and record.force.max() < end
    assert here.sum() <= record.notes[0].rows < 2 * here.sum()
    found = fit_record(record, SETUP).fits["together"]
    assert found.rmse == pytest.approx(clean.rmse, rel=0.03)
    table["force_N"] = np.minimum(table.force_N, 0.3 * end)
    assert "force_clipped" in [d.code for d in doubts_of(record_from_frame(table, specimen)) if d.grave]


def test_a_load_cell_is_at_its_end_at_one_length_of_a_locked_muscle_too():
    rng, ramp = np.random.default_rng(2), np.r_[np.linspace(0.2, 0.6, 200), np.linspace(0.6, 0.2, 200)]
    muscle = Specimen("locked", 200.0, 10.0, 25.4, 1.5)
    p, x = np.tile(ramp, 3), np.repeat([0.0, 10.0, 20.0], 400)
    force = muscle.ideal_force(p, x / 200.0) + rng.normal(0.0, 2.0, 1200)
    end = 0.95 * force.max()
    columns = {"time_s": np.arange(1200) * 0.1, "pressure_MPa": p, "displacement_mm": x + rng.normal(0.0, 0.005, 1200)}
    record = record_from_frame(pd.DataFrame(columns | {"force_N": np.minimum(force, end)}), muscle)
    assert [note.code for note in record.notes] == ["clipped"] and record.force.max() < end


def test_few_equal_readings_of_a_fine_gauge_are_its_end_and_of_a_coarse_one_are_not():
    record = read_record(HOME)
    end = np.sort(record.force[record.inputs.moving])[-8]
    force = np.minimum(record.force, end)
    assert (force == end).sum() >= 8
    assert clipped_rows(record.inputs, force)[force == end].all()
    assert not clipped_rows(record.inputs, np.round(force / 5.0) * 5.0).any()


def test_a_hold_and_a_coarse_gauge_are_not_clipped():
    record = read_record(HOME)
    inputs, force = record.inputs, record.force
    assert not clipped_rows(inputs, np.round(force)).any()
    for level in record.levels:  # holds without noise repeat their force
        force = np.where((record.level == level) & ~inputs.moving, np.round(force, -2), force)
    assert not clipped_rows(inputs, force).any()
