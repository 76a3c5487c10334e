"""Several files that are one record, and real files with a mapping of five lines at most."""

import numpy as np
import pytest
from corpus import DISPLACEMENT, FORCE, HEADERS, PRESSURE, TIME, as_text, assert_right, values
from scipy.io import savemat

from pam_ident.core import DataError
from pam_ident.records import file_sha256, read_record
from pam_ident.records.columns import read_columns
from pam_ident.records.mapping import read_mapping
from pam_ident.records.text_table import read_text


def refusal(path, *words):
    with pytest.raises(DataError) as caught:
        read_record(path)
    message = str(caught.value)
    assert str(path) in message and len(message.splitlines()) <= 2
    for word in words:
        assert word in message, message


def test_a_file_for_each_isobar_by_pattern_or_folder(put, tmp_path):
    for k, name in enumerate(("run10.csv", "run2.csv")):
        rows = values()[12:] if k == 0 else values()[:12]
        put(as_text(rows=rows * [1, 1, 1, 1] - [rows[0, 0], 0, 0, 0]), f"runs/{name}")
    (tmp_path / "runs" / "specimen.toml").write_text((tmp_path / "specimen.toml").read_text())
    for name in ("README.txt", "source.TXT", "Read me.txt", "notes.txt"):
        (tmp_path / "runs" / name).write_text("Measured on a Monday, with care.\nThe valve hisses.\n")
    pattern = f"{tmp_path}/runs/*.csv"
    for given in (pattern, tmp_path / "runs"):
        record = read_record(given)
        np.testing.assert_allclose(record.force, FORCE)
        np.testing.assert_allclose(record.inputs.pressure, PRESSURE)
        np.testing.assert_allclose(record.inputs.displacement_mm, DISPLACEMENT, atol=1e-9)
        assert np.all(np.diff(record.inputs.time) > 0.0) and record.inputs.time[12] - record.inputs.time[11] >= 60.0
        assert record.name == "m1" and record.source == str(given)
    one = read_record(tmp_path / "runs" / "run2.csv")
    assert one.sha256 == file_sha256(tmp_path / "runs" / "run2.csv") != record.sha256


def test_two_runs_at_one_pressure_stay_apart(put, tmp_path):
    for k in range(2):
        put(as_text(rows=values()[:12]), f"r{k}.csv")
    record = read_record(f"{tmp_path}/r*.csv")
    assert len(record) == 24 and list(np.unique(record.inputs.segment)) == [0, 1]


def test_files_may_differ_in_units_and_format(put, tmp_path):
    put(as_text(rows=values()[:12]), "a1.csv")
    savemat(tmp_path / "a2.mat", dict(zip(HEADERS, values()[12:].T, strict=True)))
    record = read_record(tmp_path)
    assert_right(record)
    assert record.columns["force"] == "force_N"


def test_files_that_are_not_one_test_are_refused(put, tmp_path):
    put(as_text(), "a1.csv")
    put(as_text((*HEADERS, "temperature_C"), np.column_stack([values(), TIME])), "a2.csv")
    refusal(tmp_path, "temperature")
    put("time_s,pressure_MPa\n", "a2.csv")
    refusal(tmp_path / "a2.csv", "no rows")
    refusal(tmp_path, "a2.csv", "no rows")
    put("rows of text\n", "a2.csv")
    refusal(tmp_path, "a2.csv")


def test_a_pattern_or_folder_without_files_is_refused(tmp_path):
    refusal(tmp_path, "folder without a record", ".csv")
    refusal(tmp_path / "*.csv", "no file fits")


# --- real files --------------------------------------------------------------------------------------------------

SPECIMENS = {"psu": (274.0, 10.0, 25.4), "mit": (300.0, 5.0, 23.0), "map": (300.0, 10.0, 25.4)}


@pytest.fixture
def mapped(root):
    """Reads a real file by one of the mappings beside this file."""
    from pam_ident.core import Specimen

    def read(path, mapping, specimen):
        file = root / "tests" / "records" / "mappings" / f"{mapping}.toml"
        assert len(file.read_text().splitlines()) <= 5
        return read_record(path, Specimen(specimen, *SPECIMENS[specimen]), file)

    return read


def test_raw_logger_files_without_a_header(realdata, mapped, root):
    files = sorted((realdata / "psu_festo20mm_isometric" / "raw").glob("*.csv.gz"))
    assert len(files) == 3
    for file in files[:1]:
        record = mapped(file, "psu_logger", "psu")
        assert len(record) == 29000 and np.all(record.inputs.contraction == 0.0)
    mapping = read_mapping(root / "tests" / "records" / "mappings" / "psu_logger.toml")
    spikes = [322, 1833, 3599, 4191, 5134, 12193, 12897, 13000, 23262]  # single readings 9 N and more off the others
    for file in files:
        raw = np.genfromtxt(file, delimiter=",")
        raw = np.delete(raw, spikes, axis=0) if "Test9" in file.name else raw
        (table,) = read_text(file, mapping)
        (run,) = read_columns(table, mapping.sources(table), 274.0)
        np.testing.assert_allclose(run["force"], raw[:, 0], rtol=1e-12)
        np.testing.assert_allclose(run["pressure"], raw[:, 1] * 1e-3, rtol=1e-12)
        first = np.diff(raw[:, 2], prepend=-1.0) > 0.0  # a reading of the clock that is repeated is spread to the next
        np.testing.assert_array_equal(run["time"][first], raw[first, 2])
        assert np.all(np.diff(run["time"]) > 0.0)


def test_plateaus_and_sines_of_a_hand_made_muscle(realdata, mapped):
    home = realdata / "mit2151_mckibben300mm"
    raw = np.genfromtxt(home / "plateaus.csv", delimiter=",", names=True)
    record = mapped(home / "plateaus.csv", "mit_plateaus", "mit")
    np.testing.assert_allclose(record.force, raw["F_N"])
    np.testing.assert_allclose(record.inputs.pressure, raw["p_kPa_span12bar"] * 1e-3)
    np.testing.assert_allclose(record.inputs.displacement_mm, raw["contraction_mm"], atol=1e-12)
    for file in sorted((home / "freq_noload_amp50pct").glob("*.csv")):
        raw = np.genfromtxt(file, delimiter=",", names=True)
        record = mapped(file, "mit_sine", "mit")
        np.testing.assert_allclose(record.inputs.displacement_mm, 137.3906 - raw["x_mm"], atol=1e-9)
        np.testing.assert_allclose(record.inputs.time, raw["t_s"])


def test_the_published_map_by_its_own_names(root, mapped, put):
    source = (root / "datasets" / "dmsp20_300" / "record.csv").read_text().splitlines()
    rows = [line.split(",") for line in source[1:]]
    kept = [source[0].split(",").index(name) for name in ("length_mm", "pressure_kPa", "force_N", "slack")]
    path = put(as_text(("L_mm", "p_kPa", "F_N", "slack_zero"), [[row[k] for k in kept] for row in rows]), "map.csv")
    record = mapped(path, "martens_boblan", "map")
    assert (len(record), record.masked, record.force.max()) == (60, 66, 1653.5)
