"""A unit, a zero or a length that is wrong in one file of several is told with the file's name; good ones are not."""

import numpy as np
import pytest

from pam_ident.diagnosis import compare
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import read_record
from pam_ident.records.gate import doubts_of

KPA = (100.0, 200.0, 300.0, 400.0)
MUSCLE = "[specimen]\nname = 'm'\ninitial_length_mm = 200\ninitial_radius_mm = 10\nbraid_angle_deg = 25\n"
SLIPS = {
    "absolute": (lambda p, x, f: (p + 101.325, x, f), "pressure_absolute", "0.1013 MPa less"),
    "force in kgf": (lambda p, x, f: (p, x, f / 9.80665), "scale", "kgf and N"),
    "force in lbf": (lambda p, x, f: (p, x, f / 4.448222), "scale", "lbf and N"),
    "push": (lambda p, x, f: (p, x, -f), "force_sign", "other sign"),
    "pressure in psi": (lambda p, x, f: (p / 6.894757, x, f), "scale", "psi and kPa"),
    "displacement in cm": (lambda p, x, f: (p, x / 10.0, f), "displacement_scale", "cm and mm"),
    "shorter muscle": (lambda p, x, f: (p, x * 0.75, f), "displacement_scale", "agree with about 150 mm, not 200"),
    "another zero": (lambda p, x, f: (p, x + 25.0, f), "displacement_scale", "agree with about 25 mm less"),
    "displacement turned": (lambda p, x, f: (p, -x, f), "displacement_sign", "other sign"),
}


def isobar(kpa, length_mm=200.0, effect=0.0, seed=3):
    """Pressure, displacement and force, (n, 3), of a braid with a bladder, friction and an `effect` that fades."""
    rng = np.random.default_rng(seed)
    a, b, area = 3.0 / np.tan(np.radians(25.0)) ** 2, 1.0 / np.sin(np.radians(25.0)) ** 2, np.pi * 0.01**2
    time = np.arange(0.0, 40.0, 0.2)
    e = (0.1 + 3e-4 * kpa) * 0.5 * (1.0 - np.cos(0.1 * np.pi * time))
    back = -np.sign(np.sin(0.1 * np.pi * time))
    force = 1e3 * area * kpa * (a * (1.0 - e) ** 2 - b) - 300.0 * e + 6.0 * back
    force += effect * kpa / 400.0 * np.exp(-time / 8.0) * back + rng.normal(0.0, 1.0, len(time))
    return np.column_stack([kpa + rng.normal(0.0, 0.2, len(time)), e * length_mm, force])


def save(folder, runs):
    """The runs as files p0.csv, p1.csv … of one folder."""
    (folder / "specimen.toml").write_text(MUSCLE)
    for k, run in enumerate(runs):
        table = np.column_stack([0.2 * np.arange(len(run)), run])
        head = "time_s,pressure_kPa,displacement_mm,force_N"
        np.savetxt(folder / f"p{k}.csv", table, "%.6g", ",", header=head, comments="")
    return folder


def found(folder):
    return [doubt for doubt in doubts_of(read_record(folder)) if "at odds" in doubt.text]


@pytest.mark.parametrize("wrong", (0, 1, 3))
@pytest.mark.parametrize("slip", SLIPS)
def test_the_file_that_is_wrong_is_named_with_what_would_mend_it(tmp_path, slip, wrong):
    change, code, words = SLIPS[slip]
    runs = [isobar(kpa) for kpa in KPA]
    runs[wrong] = np.column_stack(change(*runs[wrong].T))
    (doubt,) = found(save(tmp_path, runs))
    assert doubt.grave and doubt.code == code
    assert doubt.text.startswith(f"p{wrong}.csv ") and words in doubt.text


@pytest.mark.parametrize("effect", (0.0, 15.0, 60.0))
def test_good_files_are_not_doubted_whatever_the_muscle_does(tmp_path, effect):
    assert found(save(tmp_path, [isobar(kpa, effect=effect) for kpa in KPA])) == []


@pytest.mark.parametrize("zero", (-40.0, 25.0))
def test_a_load_cell_that_was_zeroed_anew_between_two_runs(tmp_path, zero):
    runs = [np.vstack([isobar(kpa, effect=15.0, seed=seed) for kpa in KPA]) for seed in (1, 2)]
    runs[1][:, 2] += zero
    (doubt,) = found(save(tmp_path, runs))
    assert doubt.grave and doubt.code == "force_zero"
    np.testing.assert_allclose(float(doubt.text.split("agree with ")[1].split(" N")[0]), abs(zero), atol=1.0)
    assert f"{'less' if zero > 0.0 else 'more'}: was the cell zeroed anew?" in doubt.text


def test_muscles_of_three_lengths_in_one_folder(tmp_path):
    runs = [np.vstack([isobar(kpa, length) for kpa in KPA]) for length in (150.0, 200.0, 260.0)]
    first, last = found(save(tmp_path, runs))
    told = [float(doubt.text.split("about ")[1].split(" mm")[0]) for doubt in (first, last)]
    assert first.text.startswith("p0.csv") and last.text.startswith("p2.csv")
    np.testing.assert_allclose(told, [150.0, 260.0], rtol=0.01)


def test_two_files_may_be_wrong_each_in_its_own_way(tmp_path):
    runs = [isobar(kpa) for kpa in KPA]
    for k, slip in ((0, "force in kgf"), (2, "absolute")):
        runs[k] = np.column_stack(SLIPS[slip][0](*runs[k].T))
    assert sorted(doubt.text[:6] for doubt in found(save(tmp_path, runs))) == ["p0.csv", "p2.csv"]


def test_one_file_is_not_held_against_itself(tmp_path):
    whole = np.vstack([isobar(kpa) for kpa in KPA])
    whole[200:400, 2] /= 9.80665
    assert found(save(tmp_path, [whole])) == []


def test_a_pause_between_two_files_at_one_pressure_is_no_jump_of_the_clock(tmp_path):
    doubts = doubts_of(read_record(save(tmp_path, [isobar(300.0), isobar(300.0, seed=4)])))
    assert "clock_jumps" not in [doubt.code for doubt in doubts]


def test_compare_tells_the_error_of_each_file(tmp_path):
    runs = [isobar(kpa) for kpa in KPA]
    runs[2] = np.column_stack(SLIPS["force in kgf"][0](*runs[2].T))
    by = compare(fit(Model.build("exponential_law"), read_record(save(tmp_path, runs)))).by["run"]
    assert [part.label for part in by] == ["p0.csv", "p1.csv", "p2.csv", "p3.csv"]
    assert max(by, key=lambda part: part.share).label == "p2.csv"
    assert sum(part.share for part in by) == pytest.approx(1.0)


GOOD = {
    "the same pressure over other parts of the stroke": [(300.0, 0.0, 0.08, 1.0), (300.0, 0.12, 0.2, 1.0)],
    "a weaker day": [(300.0, 0.0, 0.2, 1.0), (300.0, 0.0, 0.2, 0.95)],
    "no pressure in one": [
        (0.0, 0.0, 0.2, 1.0),
        (200.0, 0.0, 0.2, 1.0),
        (300.0, 0.0, 0.2, 1.0),
        (400.0, 0.0, 0.2, 1.0),
    ],
    "weaker muscles": [(300.0, 0.0, 0.2, 0.9), (300.0, 0.0, 0.2, 1.0), (300.0, 0.0, 0.2, 1.08)],
}


@pytest.mark.parametrize("kind", GOOD)
def test_what_the_others_do_not_foretell_is_no_slip(tmp_path, kind):
    """A slack muscle pulls nothing, whatever the line through the other pressures says."""
    runs = []
    for kpa, low, high, strength in GOOD[kind]:
        run = isobar(kpa)
        e = low + (high - low) * run[:, 1] / run[:, 1].max()
        a, b, area = 3.0 / np.tan(np.radians(25.0)) ** 2, 1.0 / np.sin(np.radians(25.0)) ** 2, np.pi * 0.01**2
        force = strength * 1e3 * area * np.maximum(kpa - 40.0, 0.0) * (a * (1.0 - e) ** 2 - b)
        noise = np.random.default_rng(5).normal(0.0, 1.0, len(e))
        runs.append(np.column_stack([run[:, 0], 200.0 * e, np.maximum(force, 0.0) + noise]))
    assert found(save(tmp_path, runs)) == []
