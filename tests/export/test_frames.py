"""Results as pandas tables, and records from them."""

import subprocess
import sys
from dataclasses import fields

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import DataError, Specimen, UsageError
from pam_ident.diagnosis import compare
from pam_ident.export.frames import residuals, to_frame
from pam_ident.leg.muscle import Muscle
from pam_ident.leg.track import Track, Tracking, TrackRung
from pam_ident.records import read_record, record_from_frame
from pam_ident.records.datasets import dataset_path
from pam_ident.schema.diagnosis import candidates as shown
from pam_ident.schema.diagnosis import diagnosis_json

SHORT = """time_s,pressure_MPa,displacement_mm,force_N
0.0,0.3,0.0,700.0
0.1,0.3,1.0,650.0
0.2,0.3,2.0,610.0
0.3,0.3,3.0,580.0
"""


def same(one, other) -> None:
    """Samples, branches, isobars, strokes and blocks of two records."""
    for name in ("force", "level", "stroke", "block"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for field in fields(one.inputs):
        a, b = getattr(one.inputs, field.name), getattr(other.inputs, field.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_allclose(b, a, rtol=1e-12, atol=1e-12)


def test_a_table_with_other_units_is_the_file_with_them(tmp_path):
    """What `read_record` makes of a CSV, from the same rows in bar, cm and kN."""
    path = tmp_path / "made.csv"
    path.write_text(SHORT, encoding="utf-8")
    specimen = Specimen("m", 200.0)
    columns = np.array([[float(cell) for cell in line.split(",")] for line in SHORT.splitlines()[1:]]).T
    frame = pd.DataFrame(
        {
            "time_s": columns[0],
            "Pressure [bar]": 10.0 * columns[1],
            "displacement_cm": columns[2] / 10.0,
            "Force (kN)": columns[3] / 1000.0,
        },
        index=[7, 5, 3, 1],
    )
    made = record_from_frame(frame, specimen, "made")
    same(read_record(path, specimen), made)
    assert made.name == "made" and made.columns["pressure"] == "Pressure [bar]"


def test_samples_come_back_as_the_record_they_were(record, table):
    for one in (record, table):
        frame = to_frame(one)
        assert len(frame) == len(one)
        same(one, record_from_frame(frame, one.specimen, one.name))


def test_what_is_wrong_with_a_table_is_told_with_its_row_and_column(record):
    frame = to_frame(record)
    frame.loc[12, "force_N"] = np.nan
    left = record_from_frame(frame, record.specimen, "mine")
    assert len(left) == len(record) - 1 and "table 'mine', row 12" in left.notes[0].text
    frame.loc[12, "force_N"] = np.inf
    with pytest.raises(DataError, match=r"table 'mine', row 12, column 'force_N': holds 'inf'"):
        record_from_frame(frame, record.specimen, "mine")
    with pytest.raises(DataError, match="no force column"):
        record_from_frame(frame.drop(columns="force_N"), record.specimen)
    with pytest.raises(DataError, match="no rows"):
        record_from_frame(frame[:0], record.specimen)


def test_a_fit_is_a_table_of_parameters_and_of_residuals(diagnosis):
    one = diagnosis.best
    frame = to_frame(one).set_index("parameter")
    assert list(frame.index) == list(one.model.names)
    assert frame.loc["coulomb_friction.F_c", "value"] == pytest.approx(8.0, abs=0.1)  # N, what the record was made with
    assert frame.loc["coulomb_friction.F_c", "unit"] == "N"
    rows = residuals(one)
    np.testing.assert_allclose(rows["force_N"] - rows["model_N"], rows["residual_N"])
    assert rows["residual_N"].std() == pytest.approx(0.5, rel=0.1) and rows["fitted"].all()


def test_a_comparison_is_a_table_of_cells_whose_shares_add_up(diagnosis):
    frame = to_frame(compare(diagnosis.base))
    assert set(frame["branch"]) == {"contraction", "extension"} and set(frame["pressure_MPa"]) == {0.3, 0.5}
    assert frame["share"].sum() == pytest.approx(1.0)
    means = frame.groupby("branch")["mean_N"].mean()
    assert means["contraction"] < -6.0 and means["extension"] > 6.0  # 8 N of friction against the motion
    assert (frame["contraction_high"] > frame["contraction_low"]).all()


def test_a_diagnosis_and_a_ladder_are_tables_in_their_order(diagnosis, ladder):
    frame = to_frame(diagnosis)
    candidates = ["coulomb_friction", "creep", "viscous_damping"]
    assert list(frame["effect"]) == [*candidates, "force_bias", "thermal_softening"]
    assert [one["effect"] for one in diagnosis_json("made up", diagnosis)["ranking"]] == list(frame["effect"])
    assert [one.effect for one in shown(diagnosis)] == candidates, "JSON, text and tables have one order"
    assert list(frame["selected"]) == [True] + [False] * 4 and np.isnan(frame["heldout_rmse_after_N"][2])
    assert frame["probability"][0] == 0.97
    steps = to_frame(ladder)
    assert list(steps["effects"]) == ["", "coulomb_friction"] and steps["rmse_N"].is_monotonic_decreasing
    assert list(steps["heldout_rmse_N"]) == [8.3, 0.55]


def test_a_track_is_a_table_of_controllers():
    def run(size):
        time = 0.005 * np.arange(200)
        both = np.zeros((200, 2))
        return Tracking(time, np.zeros(200), size * np.sin(2.0 * np.pi * time), both, both)

    muscle = Muscle.read(dataset_path("leg_muscle") / "ladder.json")[0]
    found = Track(
        None, None, None, None, run(4.0), run(2.0), (TrackRung(muscle, run(1.0), (0.3, 0.5)),), run(0.5), None
    )
    frame = to_frame(found)
    assert list(frame["rms_deg"]) == pytest.approx(np.array([4.0, 2.0, 1.0, 0.5]) / np.sqrt(2.0))
    assert list(frame["controller"])[2] == "PID + chou_hannaford" and frame["rms_high_deg"][2] == 0.5


def test_what_is_no_result_has_no_table():
    with pytest.raises(UsageError, match="no table of a int"):
        to_frame(3)


@pytest.mark.long
def test_a_table_of_a_record_imports_neither_jax_nor_matplotlib():
    code = (
        "import sys, pandas as pd\n"
        "frame = pd.DataFrame({'pressure_MPa': [0.1, 0.2], 'contraction': [0.0, 0.1], 'force_N': [9.0, 8.0]})\n"
        "from pam_ident.core import Specimen\n"
        "from pam_ident.export.frames import to_frame\n"
        "from pam_ident.records import record_from_frame\n"
        "to_frame(record_from_frame(frame, Specimen()))\n"
        "print([name for name in ('jax', 'matplotlib', 'scipy') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
