"""`export`: from a record and from what `fit --json` and `ladder --json` wrote, whole or not at all."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from pam_ident.core import DataError
from pam_ident.export.fitted import Fitted
from pam_ident.fitting import fit
from pam_ident.leg.muscle import Muscle
from pam_ident.model import Model
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record
from pam_ident.tasks.law_choice import choose_law
from pam_ident.tasks.setup import AUTO, Setup

RECORD = Path(__file__).parents[2] / "datasets" / "paper_laws" / "reconstructed.csv"
LAW = ("--law", "exponential_law")
SUFFIX = {"c": ".h", "matlab": ".m", "python": ".py", "mujoco": ".xml", "json": ".json"}


def ask(*words):
    from pam_ident.cli import app

    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def stored(tmp_path_factory) -> Path:
    """A fit of both branches apart, as JSON."""
    path = tmp_path_factory.mktemp("stored") / "fit.json"
    assert ask("fit", RECORD, *LAW, "--branch", "separate", "--json", path).exit_code == 0
    return path


def force_in(path: Path):
    defined: dict = {}
    exec(path.read_text(encoding="utf-8"), defined)
    return defined[path.stem]


@pytest.mark.parametrize("to", SUFFIX)
def test_a_record_is_fitted_and_written(tmp_path, to):
    path = tmp_path / f"arm{SUFFIX[to]}"
    result = ask("export", RECORD, "--to", to, "--out", path, *LAW)
    assert result.exit_code == 0, result.output
    assert f"wrote {path}" in result.stdout and path.is_file()
    assert ((tmp_path / "arm.py").is_file()) == (to in ("python", "mujoco"))
    text = path.read_text(encoding="utf-8")
    assert str(RECORD) in text
    if to in ("c", "matlab", "python"):
        assert "Valid where it was fitted: 0.1 to 0.5 MPa" in text and "exp(−μ ε)" in text and "MPa" in text


def test_what_is_written_is_the_fit_of_the_record(tmp_path):
    path = tmp_path / "arm.py"
    assert ask("export", RECORD, "--to", "python", "--out", path, *LAW).exit_code == 0
    record = read_record(RECORD)
    one = fit(Model.build("exponential_law"), record)
    arm = force_in(path)
    found = arm(record.inputs.pressure, record.inputs.contraction)
    np.testing.assert_allclose(found, one.force, rtol=0.0, atol=1e-12 * np.abs(one.force).max())
    errors = {e.name: e.stderr for e in one.estimates}
    assert f"± {errors['mu']:.2g}" in path.read_text(encoding="utf-8")


def test_branches_apart_are_the_printed_laws_by_the_direction(stored, tmp_path):
    """Equations (4) and (5) of the paper, from which the record was made."""
    path = tmp_path / "arm.py"
    assert ask("export", stored, "--to", "python", "--out", path).exit_code == 0
    arm, p, e = force_in(path), 0.4, 0.12
    shorten = 2442 * p - 197.8 - (5464 * p + 1735) * e + (688.3 * p - 9.3) * np.exp(-45 * e)
    lengthen = 2554 * p - 344.5 - (8430 * p - 43.2) * e + (899.2 * p + 43.24) * np.exp(-45 * e)
    assert arm(p, e, 1.0) == pytest.approx(shorten, rel=1e-6)
    assert arm(p, e, -1.0) == pytest.approx(lengthen, rel=1e-6)
    assert arm(p, e, 0.0) == pytest.approx(0.5 * (shorten + lengthen), rel=1e-6)


def test_a_ladder_gives_its_last_rung(root, tmp_path):
    ladder = root / "datasets" / "leg_muscle" / "ladder.json"
    last = json.loads(ladder.read_text(encoding="utf-8"))["rungs"][-1]
    stored = json.loads(ladder.read_text(encoding="utf-8"))
    del stored["range"]
    ladder = tmp_path / "ladder.json"
    ladder.write_text(json.dumps(stored), encoding="utf-8")
    result = ask("export", ladder, "--to", "c", "--out", tmp_path / "arm.h")
    assert result.exit_code == 0, result.output
    text = (tmp_path / "arm.h").read_text(encoding="utf-8")
    assert all(f"+ {label}: " in text for label in last["effects"])
    assert "The range of the record is not known" in text


@pytest.mark.long
def test_the_export_is_the_muscle_that_runs_in_the_leg(root, tmp_path):
    """Along a swing, instant by instant, with the direction that the leg's muscles have."""
    ladder = root / "datasets" / "leg_muscle" / "ladder.json"
    assert ask("export", ladder, "--to", "python", "--out", tmp_path / "arm.py").exit_code == 0
    arm, muscle = force_in(tmp_path / "arm.py"), Muscle.read(ladder)[-1]
    values, memory, state = muscle.values(), muscle.start(np.array([0.3]), np.array([0.1])), None
    _, state = arm(0.3, 0.1, 0.0, 0.0, 0.0, state)
    for t in np.arange(0.005, 0.5, 0.005):
        p, e, v = 0.3 + 0.1 * np.sin(9.0 * t), 0.1 + 0.05 * np.sin(20.0 * t), 200.0 * np.cos(20.0 * t)
        expected, memory = muscle.force(values, memory, t, np.array([p]), np.array([e]), np.array([v]))
        force, state = arm(p, e, v, np.tanh(v / 0.2), 0.0, state)
        assert force == pytest.approx(float(expected[0]), rel=1e-10)


def test_mujoco_says_what_its_plain_actuator_misses(stored, tmp_path):
    result = ask("export", stored, "--to", "mujoco", "--out", tmp_path / "arm.xml")
    assert result.exit_code == 0 and "N rms" in result.stdout and "arm.py" in result.stdout


def test_a_file_beside_that_nobody_named_replaces_only_one_of_its_kind(stored, tmp_path):
    python, actuator = tmp_path / "arm.py", tmp_path / "arm.xml"
    assert ask("export", stored, "--to", "python", "--out", python).exit_code == 0
    before = python.read_bytes()
    refused = ask("export", stored, "--to", "mujoco", "--out", actuator)
    assert refused.exit_code == 2 and f"--out {tmp_path / 'arm_mujoco.xml'}" in refused.stderr
    assert python.read_bytes() == before and not actuator.exists()
    python.unlink()
    for _ in range(2):
        assert ask("export", stored, "--to", "mujoco", "--out", actuator).exit_code == 0


def test_a_file_of_this_version_is_read_back(stored):
    content = json.loads(stored.read_text(encoding="utf-8"))
    found = Fitted.read(stored)
    assert content["schema"] == "pam-ident/fit/1"
    for branch in ("contraction", "extension"):
        saved = content["branches"][branch]["parameters"]
        assert found.values(branch) == {name: saved[name]["value"] for name in found.model.names}
        assert [p.stderr for p in found.branches[branch]] == [saved[name]["stderr"] for name in found.model.names]
    assert found.span is not None and found.span.pressure_MPa == (0.1, 0.5)


@pytest.mark.parametrize("schema", ["pam-ident/fit/2", "pam-ident/ladder/13"])
def test_a_file_of_a_newer_version_is_refused_as_such(stored, tmp_path, schema):
    content = json.loads(stored.read_text(encoding="utf-8"))
    newer = tmp_path / "newer.json"
    newer.write_text(json.dumps(content | {"schema": schema}), encoding="utf-8")
    with pytest.raises(DataError, match=r"newer pam-ident; update"):
        Fitted.read(newer)
    assert ask("export", newer, "--to", "c", "--out", tmp_path / "arm.h").exit_code == 4
    assert not (tmp_path / "arm.h").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c["branches"]["contraction"]["parameters"].pop("mu"), "contraction lacks mu"),
        (lambda c: c["branches"].pop("contraction") and c["branches"].update(other={}), "branches"),
        (lambda c: c.pop("specimen"), "specimen"),
    ],
)
def test_a_file_that_lacks_something_is_refused_by_its_name(stored, tmp_path, change, words):
    content = json.loads(stored.read_text(encoding="utf-8"))
    change(content)
    broken = tmp_path / "broken.json"
    broken.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(DataError, match=words):
        Fitted.read(broken)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--to", "fortran", "--out", "arm.f"), "c, fmu, fmu3, matlab, mujoco, python, json"),
        (("--to", "c", "--out", "arm.m"), ".h"),
        (("--to", "c", "--out", "2nd.h"), "begins with a letter"),
        (("--to", "json", "--out", "arm.json"), "JSON already"),
        (("--to", "c", "--out", "arm.h", "--effect", "creep"), "--law"),
        (("--to", "c", "--out", "no/arm.h"), "no folder"),
    ],
)
def test_a_wrong_request_is_refused_and_nothing_is_written(stored, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    result = ask("export", stored, *words)
    assert result.exit_code == 2 and message in result.stderr and len(result.stderr.splitlines()) <= 2
    assert not list(tmp_path.iterdir())


def test_a_record_without_a_law_gets_the_one_that_is_chosen(tmp_path):
    choice = choose_law(read_record(RECORD), Setup(AUTO))
    for name, words in (("chosen.json", ()), ("named.json", ("--law", choice.law))):
        result = ask("export", RECORD, *words, "--to", "json", "--out", tmp_path / name)
        assert result.exit_code == 0 and (choice.why in result.stdout) == (not words)
    assert (tmp_path / "chosen.json").read_text() == (tmp_path / "named.json").read_text()


def test_a_fit_that_is_not_valid_is_written_with_a_warning(tmp_path):
    """A load cell's bias beside a law that has an intercept: neither is determined."""
    path = tmp_path / "arm.h"
    result = ask("export", RECORD, "--to", "c", "--out", path, *LAW, "--effect", "force_bias")
    assert result.exit_code == 3 and "force_bias.F_b" in result.stderr
    assert "// Warning: together: the record does not determine" in path.read_text(encoding="utf-8")


def test_a_model_that_follows_the_motion_says_what_its_error_holds_for(tmp_path):
    told = "That error is for a position without noise within a stroke"
    rubbing = dataset_record("hidden_effect"), "--effect", "pressure_friction:bending"
    for asked, number in ((rubbing, 1), ((RECORD,), 0)):
        result = ask("export", *asked, "--to", "c", "--out", tmp_path / "arm.h", *LAW)
        assert result.exit_code == 0 and result.stdout.count(told) == number
        header = " ".join((tmp_path / "arm.h").read_text(encoding="utf-8").replace("//", " ").split())
        assert header.count(told) == number
