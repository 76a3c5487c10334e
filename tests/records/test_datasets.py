"""The data sets that come with the program: found, readable, as their READMEs say, and made again to the byte."""

import subprocess
import sys

import numpy as np
import pytest

from pam_ident.core import UsageError
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_names, dataset_path, dataset_record

RECORDS = ("dmsp20_300", "paper_laws", "festo_dmsp20_catalogue", "hidden_effect", "nothing_hidden", "leg_muscle")


def test_every_data_set_is_found_by_name_and_explains_itself():
    assert set(dataset_names()) == {*RECORDS, "gait"}
    for name in dataset_names():
        text = (dataset_path(name) / "README.md").read_text(encoding="utf-8")
        assert len(text) > 300 and ("masked" in text or name == "gait")


def test_an_unknown_data_set_is_refused_with_the_known_ones():
    with pytest.raises(UsageError, match=r"'moon'.*dmsp20_300.*paper_laws"):
        dataset_path("moon")
    with pytest.raises(UsageError, match=r"no force record.*README\.md"):
        dataset_record("gait")


@pytest.mark.parametrize("name", RECORDS)
def test_every_force_record_can_be_read(name):
    assert len(read_record(dataset_record(name))) >= 60


def test_the_measured_map_masks_its_slack_and_keeps_sixty_points():
    record = read_record(dataset_record("dmsp20_300"))
    assert (len(record), record.masked, record.block_kind) == (60, 66, "length")
    assert record.force.min() > 0.0 and record.force.max() == 1653.5
    assert record.inputs.contraction.min() == pytest.approx(4.0 / 300.0)
    assert len(np.unique(record.block)) == 5


def test_the_virtual_rig_twins_differ_in_force_alone():
    hidden, nothing = (read_record(dataset_record(name)) for name in ("hidden_effect", "nothing_hidden"))
    np.testing.assert_array_equal(hidden.inputs.contraction, nothing.inputs.contraction)
    np.testing.assert_array_equal(hidden.inputs.pressure, nothing.inputs.pressure)
    law = Model.build("exponential_law")
    assert fit(law, nothing, detail=False).rmse < 2.1
    assert fit(law, hidden, detail=False).rmse > 6.0


def test_sarosi_and_the_catalogue_differ_as_their_readme_says():
    a = dict.fromkeys(("a1", "a2", "a3", "a4", "a5", "a6"))
    lines = (dataset_path("festo_dmsp20_catalogue") / "sarosi.csv").read_text(encoding="utf-8").splitlines()
    a = dict(zip(lines[0].split(",")[1:], map(float, lines[1].split(",")[1:]), strict=True))
    assert (a["a1"] * 6 + a["a2"]) + a["a5"] * 6 + a["a6"] == pytest.approx(1752, abs=1)
    record = read_record(dataset_record("festo_dmsp20_catalogue"))
    at = (record.inputs.contraction == 0.0) & (record.level == 0.6)
    assert record.force[at].tolist() == [1515.0]


@pytest.mark.parametrize(
    ("script", "written"),
    [
        ("paper_laws", ["reconstructed.csv"]),
        ("hidden_effect", ["hidden_effect/record.csv", "nothing_hidden/record.csv", "hidden_effect/specimen.toml"]),
    ],
)
def test_the_scripts_write_the_very_files_again(script, written, tmp_path, root):
    make = dataset_path(script) / "make.py"
    subprocess.run([sys.executable, "-B", make, tmp_path], check=True, cwd=root, env={"PYTHONPATH": str(root)})
    for name in written:
        kept = dataset_path(script) / name if script == "paper_laws" else dataset_path(script).parent / name
        again, before = ((x / y).read_text() for x, y in ((tmp_path, name), (kept.parent, kept.name)))
        if again != before:  # another processor may round the last digit of a figure differently
            assert len(again.splitlines()) == len(before.splitlines())
            old, new = (np.genfromtxt(t.splitlines()[1:], delimiter=",")[:, :3] for t in (before, again))
            np.testing.assert_allclose(new, old, rtol=1e-12)
