"""A record as a Data Package: the same record comes back, with all that is known of it."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from pam_ident.core import DataError, Sensors, Specimen
from pam_ident.export.package import write_package
from pam_ident.records import read_record, read_specimen
from pam_ident.records.datasets import bundled, dataset_names
from pam_ident.records.package import told
from pam_ident.records.specimen_file import read_kind, specimen_toml
from pam_ident.report.tables import source

METADATA = """
operator = "Ada"
date = 2026-11-23
licence = "CC BY 4.0"
rig = { load_cell = "S2M", channels = ["a", "b"] }
[calibration.force]
gain = 1.002
on = 2026-10-01T10:00:00Z
"""


def ask(*words):
    from pam_ident.cli import app

    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture
def packed(tmp_path):
    (tmp_path / "known.toml").write_text(METADATA, encoding="utf-8")
    words = ("pack", "hidden_effect", "--out", tmp_path / "package", "--metadata", tmp_path / "known.toml")
    assert ask(*words, "--json", tmp_path / "pack.json").exit_code == 0
    return tmp_path / "package"


@pytest.mark.parametrize("name", [name for name in dataset_names() if bundled(name)])
def test_the_same_record_comes_back_to_the_last_bit(name, tmp_path):
    record = read_record(name)
    write_package(record, tmp_path / "package")
    again = read_record(tmp_path / "package")
    assert_same(again, record)
    assert (again.name, again.said_kind) == (record.name, record.said_kind)


def assert_same(again, record):
    """Sample by sample, strokes and isobars included."""
    assert again.specimen == record.specimen
    for part in ("force", "level", "stroke", "block"):
        np.testing.assert_array_equal(getattr(again, part), getattr(record, part))
    for part, values in vars(record.inputs).items():
        if isinstance(values, np.ndarray):
            np.testing.assert_array_equal(getattr(again.inputs, part), values, err_msg=part)
            np.testing.assert_array_equal(getattr(again.steady, part), getattr(record.steady, part), err_msg=part)


def test_runs_of_one_test_are_one_file(tmp_path):
    """The clock begins anew in each, and one of the muscles is shorter."""
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "specimen.toml").write_text(specimen_toml(Specimen("m")), encoding="utf-8")
    runs = '[runs."1.csv"]\ninitial_length_mm = 200\n[runs."2.csv"]\ninitial_length_mm = 180\n'
    (tmp_path / "runs" / "columns.toml").write_text(runs, encoding="utf-8")
    for name, pressure in (("1.csv", 2.1), ("2.csv", 3.3)):
        x = 20.0 * np.sin(0.1 * np.arange(300)) ** 2
        rows = [f"{0.1 * k:.1f},{pressure},{x[k]:.3f},{500 - 20 * x[k]:.2f}\n" for k in range(300)]
        text = "time_s,Pressure [bar],displacement_mm,force_N\n" + "".join(rows)
        (tmp_path / "runs" / name).write_text(text, encoding="utf-8")
    record = read_record(tmp_path / "runs")
    write_package(record, tmp_path / "package")
    assert_same(read_record(tmp_path / "package"), record)
    notes = json.loads((tmp_path / "package" / "datapackage.json").read_text(encoding="utf-8"))["notes"]
    assert any("180 to 180 mm" in note for note in notes)


def test_what_is_known_is_kept_told_and_stands_in_the_report(packed, tmp_path):
    known = json.loads((tmp_path / "pack.json").read_text(encoding="utf-8"))["metadata"]
    assert known["calibration"]["force"] == {"gain": 1.002, "on": "2026-10-01T10:00:00+00:00"}
    assert read_record(packed).metadata == known
    text = ask("inspect", packed, "--json", tmp_path / "inspect.json").stdout
    assert "rig: channels: a, b" in text and "operator: Ada" in text
    assert json.loads((tmp_path / "inspect.json").read_text(encoding="utf-8"))["metadata"] == known
    assert ("calibration: force: gain", "1.002") in source(read_record(packed)).rows
    assert list(told({"a_b": {"c": ["\x1b[2Jx\n", 1]}})) == [("a b: c", "[2Jx , 1")]


def test_a_package_is_valid_for_frictionless(packed):
    frictionless = pytest.importorskip("frictionless", reason="frictionless is not installed")
    found = frictionless.validate(str(packed / "datapackage.json"))
    assert found.valid, found.flatten(["title", "message"])
    fields = (
        frictionless.Package(str(packed / "datapackage.json")).get_resource("record").schema.to_descriptor()["fields"]
    )
    assert {field["name"]: field["unit"] for field in fields}["force_N"] == "N"


def test_metadata_beside_a_record_are_read_without_a_package(tmp_path, packed):
    (packed / "datapackage.json").unlink()
    (packed / "metadata.toml").write_text('operator = "Grace"\n', encoding="utf-8")
    assert read_record(packed / "record.csv").metadata == {"operator": "Grace"}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: "{", "no readable Data Package"),
        (lambda text: text.replace("record.csv", "gone.csv"), "no file gone.csv"),
        (lambda text: text.replace("record.csv", "../known.csv"), "no file known.csv in this folder"),
        (lambda text: text.replace("record.csv", "record.bin"), "no resource is a record"),
    ],
)
def test_a_package_that_is_none_is_refused(packed, change, words):
    (packed.parent / "known.csv").write_text("time_s\n", encoding="utf-8")
    path = packed / "datapackage.json"
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(DataError, match=words):
        read_record(packed)


def test_a_folder_with_something_in_it_stays_as_it_is(packed):
    before = sorted(path.name for path in packed.parent.iterdir())
    result = ask("pack", "hidden_effect", "--out", packed)
    assert result.exit_code == 2 and "not empty" in result.stderr
    result = ask("pack", packed / "gone.csv", "--out", packed.parent / "other")
    assert result.exit_code == 4 and sorted(path.name for path in packed.parent.iterdir()) == before


def test_a_specimen_is_written_as_it_is_read(tmp_path):
    specimen = Specimen('a "muscle" ü\n', 200.5, 10.25, 25.4, None, Sensors(1.5, 0.0005))
    (tmp_path / "specimen.toml").write_text(specimen_toml(specimen, "isometric"), encoding="utf-8")
    assert read_specimen(tmp_path / "specimen.toml") == specimen
    assert read_kind(tmp_path / "specimen.toml") == "isometric"
