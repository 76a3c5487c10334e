"""A locked muscle that hangs slack pulls with nothing while the pressure changes: those rows tell nothing of a law."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record, read_record
from pam_ident.records.clipped import slack_rows

MUSCLE = Specimen("locked", 200.0, 10.0, 25.4, 1.5)
NOISE = 1.5


def locked(slack_up_to: float, lengths=(0.02, 0.08, 0.12), seed: int = 0):
    """Ramps of the pressure up and down at some contractions; an ideal braid that pulls from a pressure on."""
    rng = np.random.default_rng(seed)
    ramp = np.r_[np.linspace(0.0, 0.5, 400), np.linspace(0.5, 0.0, 400)]
    p, e = np.tile(ramp, len(lengths)), np.repeat(lengths, len(ramp))
    pulls = np.maximum(MUSCLE.ideal_force(p - slack_up_to, e), 0.0)
    force = pulls + NOISE * rng.standard_normal(len(p))
    return p, e, force, np.arange(len(p)) * 0.05


@pytest.mark.parametrize("begins", [0.05, 0.15])
def test_rows_in_which_a_locked_muscle_is_slack_are_found(begins):
    p, e, force, time = locked(begins)
    found = slack_rows(build_record("locked", MUSCLE, p, e, force, time=time))
    slack = p < begins
    assert np.mean(found == slack) > 0.98 and np.mean(found[slack]) > 0.97


def test_a_muscle_that_pulls_from_the_first_pressure_on_has_none():
    p, e, force, time = locked(0.0)
    assert not slack_rows(build_record("locked", MUSCLE, p, e, force, time=time)).any()
    assert not slack_rows(build_record("tared", MUSCLE, p, e, force + 200.0, time=time)).any()


def test_they_are_left_out_and_counted_and_the_law_is_found_without_them(tmp_path):
    p, e, force, time = locked(0.1)
    rows = np.column_stack([time, p, 200.0 * e, force])
    np.savetxt(
        tmp_path / "run.csv", rows, "%.6f", ",", header="time_s,pressure_MPa,displacement_mm,force_N", comments=""
    )
    text = '[specimen]\nname = "locked"\ninitial_length_mm = 200\ninitial_radius_mm = 10\nbraid_angle_deg = 25.4\n'
    (tmp_path / "specimen.toml").write_text(text, encoding="utf-8")
    record = read_record(tmp_path / "run.csv")
    (note,) = record.notes
    assert note.code == "slack" and note.rows == 2400 - len(record) and 0.19 < note.rows / 2400 < 0.22
    left = fit(Model.build("chou_hannaford", ("threshold_pressure",)), record)
    assert left.rmse < 1.05 * NOISE and left.values["threshold_pressure.p_th"] == pytest.approx(0.1, abs=1e-3)
