"""The contract's page names every command, and the very keys that the program writes."""

import json
import re
import shutil
from dataclasses import replace
from types import SimpleNamespace

import pandas as pd
import pytest
from typer.main import get_command
from typer.testing import CliRunner

from pam_ident.cli import app
from pam_ident.rig import Plan, Protocol, Secret, make_record, write_case
from pam_ident.tasks.demo import STAGES
from pam_ident.validation.selftest import Recovery

NAMED = {
    "parameters": "NAME",
    "branches": "BRANCH",
    "correlation": "BRANCH",
    "kinds": "KIND",
    "by": "KEY",
    "tuning": "HOW",
    "columns": "QUANTITY",
    "polynomial": "NAME",
    "errors": "RECORD",
}
SHORT = Protocol((0.2, 0.3, 0.4), (5.0, 20.0), 2, move_rows=30, hold_rows=10)
POOR = "[protocol]\npressures_MPa = [0.3, 0.4]\nspeeds_mm_s = [10.0]\ncycles_per_speed = 4\n"
PLAIN = {"methods[].parameters.NAME", "per_pressure[].parameters.NAME"}


@pytest.fixture(scope="module")
def page(root):
    return (root / "docs" / "contract.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def documented(page):
    """Keys by heading, from the first column of each table."""
    sections = re.split(r"^### ", page, flags=re.M)[1:]
    keys = {part.splitlines()[0]: re.findall(r"^\| `([^`]+)` \|", part.split("\n## ")[0], re.M) for part in sections}
    assert all(len(set(found)) == len(found) for found in keys.values())
    return {name: set(found) for name, found in keys.items()}


def leaves(value, path="", under=""):
    """(path, value) of all that holds no further keys, names of parameters and the like written in capitals."""
    if isinstance(value, dict) and value and not path.endswith("protocol"):
        for key, item in value.items():
            name = NAMED.get(under, key)
            if under == "correlation":
                yield from ((f"{path}.{name}.NAME", x) for x in item.values())
            else:
                yield from leaves(item, f"{path}.{name}" if path else name, key)
    elif isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
        for item in value:
            yield from leaves(item, f"{path}[]", "")
    else:
        yield path, value


@pytest.fixture(scope="module")
def written(tmp_path_factory, one_process):
    """What the program wrote, objects by schema: runs that together fill every key."""
    folder = tmp_path_factory.mktemp("contract")
    law, few = ("--law", "exponential_law"), ("--only", "pressure_friction")
    clean, rubbing, rub, doubtful = (folder / name / "record.csv" for name in ("clean", "rubbing", "rub", "doubtful"))
    write_case(clean.parent, make_record(Plan(44, law[1], protocol=SHORT)))
    write_case(rubbing.parent, make_record(Plan(44, law[1], secrets=(Secret("pressure_friction"),), protocol=SHORT)))
    write_case(rub.parent, make_record(Plan(44, law[1], unknown=Secret("rub", "fold", 2.0))))
    shutil.copytree(rubbing.parent, doubtful.parent)
    table = pd.read_csv(rubbing)
    table.assign(displacement_mm=table["displacement_mm"] - 6.0).to_csv(doubtful, index=False)  # it is stretched
    (folder / "poor.toml").write_text(POOR, encoding="utf-8")
    poor = folder / "poor" / "record.csv"
    run("rig", poor.parent, "--protocol", folder / "poor.toml", *law, "--effect", "viscous_damping", "--seed", 62)
    tree = folder / "tree"
    shutil.copytree(poor.parent, tree)
    (tree / "bad.csv").write_text("time_s,force_N\n0,1\n", encoding="utf-8")
    run("fit", poor, *law, "--json", folder / "fit.json")
    weights = folder / "weights" / "record.csv"
    write_case(weights.parent, make_record(Plan(4, law[1], protocol="weight_ramps")))
    run("fit", weights, *law, "--json", folder / "weights.json")
    (folder / "loads.csv").write_text("pressure_MPa,force_N\n0.3,100\n", encoding="utf-8")
    asked = [
        ("fit", weights, *law),
        ("compare", weights),
        ("ladder", weights, *law, *few, "--heldout", "refit"),
        ("diagnose", weights, *law, *few),
        ("validate", folder / "weights.json", weights),
        ("predict", folder / "weights.json", "--at", folder / "loads.csv"),
        ("fit", rubbing, "--method", "both"),
        ("fit", rubbing, *law, "--method", "two-stage"),
        ("compare", rubbing),
        ("diagnose", poor, *law),
        ("diagnose", rub, *few),
        ("add", rubbing, "--effect", "pressure_friction"),
        ("ladder", clean, "--heldout", "refit"),
        ("ladder", clean, *law, "--heldout", "cycle"),
        ("against", clean, rubbing),
        ("validate", folder / "fit.json", rubbing),
        ("predict", folder / "fit.json", "--at", poor, "--out", folder / "force.csv"),
        ("selftest",),
        ("challenge", "--n", 1, "--quiet"),
        ("inspect", rubbing),
        ("pack", rubbing, "--out", folder / "package"),
        ("export", rubbing, *law, "--to", "c", "--out", folder / "muscle.h"),
        ("laws",),
        ("effects",),
        ("demo", "--out", folder / "demo"),
        ("rig", folder / "set", "--n", 1, "--only", "null"),
        ("batch", tree, "--out", folder / "results"),
    ]
    for verb in ("fit", "compare", "diagnose", "ladder", "add", "inspect"):
        more = {"inspect": (), "add": (*law, "--effect", "bladder_elasticity"), "ladder": (*law, "--heldout", "refit")}
        asked.append((verb, doubtful, *more.get(verb, law)))
    asked += [("validate", folder / "fit.json", doubtful), ("against", rubbing, doubtful, *law)]
    answers = {}
    with pytest.MonkeyPatch.context() as patch:
        name, setup, about = STAGES[1]  # all three take half a minute
        patch.setattr("pam_ident.tasks.demo.STAGES", [(name, replace(setup, heldout="refit"), about)])
        patch.setattr("pam_ident.tasks.demo.render", lambda story: "")  # its page has tests of its own
        patch.setattr("pam_ident.validation.challenge.answer_case", guess)
        patch.setattr("pam_ident.validation.selftest._recover", lambda: Recovery(1.0, "adequate", "creep", ("creep",)))
        for words in asked:
            run(*words, "--json", folder / "answer.json")
            answer = json.loads((folder / "answer.json").read_text(encoding="utf-8"))
            answers.setdefault(answer["schema"], []).append(answer)
    run("fit", clean, rubbing, *law, "--shared", "mu", "--json", folder / "both.json")
    lines = (folder / "both.json").read_text(encoding="utf-8").splitlines()
    answers["pam-ident/fit/1"] += [json.loads(line) for line in lines]
    return answers | {
        "pam-ident/track/1": [made_up_track()],
        "pam-ident/refusal/1": [refused(tree / "bad.csv", folder / "refused.json")],
        "pam-ident/workbench/1": [served(folder / "served.json")],
        "pam-ident/effects/1": [*answers["pam-ident/effects/1"], checked(folder)],
    }


def guess(folder, case, law):
    """An answer to a case without a diagnosis."""
    ranking = [{"effect": "creep", "status": "candidate", "probability": 0.2}]
    return {"record": f"{case}/record.csv", "verdict": "adequate", "selected": [], "ranking": ranking}


def checked(folder):
    """The answer about an effect that does not keep its promises."""
    run("effects", "new", folder / "mine.py")
    text = (folder / "mine.py").read_text(encoding="utf-8")
    (folder / "mine.py").write_text(text.replace("    return ", '    return float("nan") * '), encoding="utf-8")
    CliRunner().invoke(app, ["effects", "check", str(folder / "mine.py"), "--json", str(folder / "checked.json")])
    return json.loads((folder / "checked.json").read_text(encoding="utf-8"))


def refused(record, file):
    """What is written of a record that cannot be read."""
    assert CliRunner().invoke(app, ["fit", str(record), "--json", str(file)]).exit_code == 4
    return json.loads(file.read_text(encoding="utf-8"))


def served(file):
    """What the workbench says of its address; it is stopped as soon as it has said so."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pam_ident.workbench.serve", lambda make, port, show, ready: ready("http://127.0.0.1:1"))
        run("workbench", "--no-browser", "--json", file)
    return json.loads(file.read_text(encoding="utf-8"))


def run(*words):
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, result.output


def made_up_track():
    """The real writer's answer to a run of one rung: a run itself takes a minute."""
    from pam_ident.leg.mismatch import Mismatch
    from pam_ident.records.doubt import Doubt
    from pam_ident.schema.track import track_json

    tuned = SimpleNamespace(gains=(1.0, 2.0, 3.0), runs=1, rms_deg=1.0, worst_deg=2.0)
    trouble = SimpleNamespace(kind="slack", time_s=0.1, share=0.5)
    time = [0.0, 0.2]
    course = SimpleNamespace(rms_deg=1.0, peak_deg=2.0, troubles=[trouble], time=time)
    model = SimpleNamespace(law=SimpleNamespace(name="sarosi"), labels=["creep"])
    muscle = SimpleNamespace(model=model, rmse=1.2)
    gait = SimpleNamespace(name="winter", cadence_Hz=1.0)
    budget = SimpleNamespace(structure=0.1, tuning=0.2, muscle=0.3, by_hand=1.0, automatic=0.8)
    return track_json(
        SimpleNamespace(
            course=SimpleNamespace(gait=gait, lessons=2),
            off=Mismatch(),
            ground=None,
            doubts=(Doubt("outside_range", "flexor", "pressure_MPa"),),
            pid=course,
            pid_by_hand=course,
            ideal=course,
            rungs=[SimpleNamespace(muscle=muscle, tracking=course, band=(0.9, 1.1))],
            by_hand=tuned,
            automatic=tuned,
            budget=budget,
            prototype=False,
            agreement_deg=None,
        )
    )


def keys_of(answers, documented):
    """Leaves of all answers, those of a parameter and of a choice of a law apart."""
    found, parameter, choice = {}, set(), set()
    for answer in answers:
        for path, value in leaves(answer):
            if path.startswith("law_choice."):
                choice.add(path.partition(".")[2])
                path = "law_choice"
            head, inside, rest = path.partition("parameters.NAME")
            if inside and rest and head + inside not in PLAIN:
                parameter.add(rest[1:])
                path = head + inside
            found.setdefault(path, []).append(value)
    return found, parameter, choice


def test_every_command_is_named(page):
    commands = get_command(app).commands
    for name, command in commands.items():
        assert f"`pam-ident {name}" in page, name
        for sub in getattr(command, "commands", {}):
            assert f"`{name} {sub}" in page, f"{name} {sub}"


@pytest.mark.long
def test_every_schema_has_a_table(written, documented):
    assert set(written) == set(documented) - {"A parameter", "A choice of a law"}


@pytest.mark.long
def test_every_written_key_is_documented_and_every_documented_key_is_written(written, documented):
    chosen = set()
    for schema, answers in written.items():
        found, parameter, choice = keys_of(answers, documented)
        listed = documented[schema]
        missing = {
            path
            for path, values in found.items()
            if path not in listed
            and not (all(not v for v in values) and any(one.startswith((f"{path}.", f"{path}[]")) for one in listed))
        }
        assert not missing, f"{schema}: written, but not in docs/contract.md"
        assert not listed - set(found), f"{schema}: in docs/contract.md, but not written"
        assert parameter in (set(), documented["A parameter"]), schema
        chosen |= choice
    assert chosen == documented["A choice of a law"]


def test_exit_codes_are_those_of_the_errors(page):
    from pam_ident.core import DataError, FitError, UsageError

    codes = dict(re.findall(r"^\| (\d) \| ([^|]+) \|", page, re.M))
    assert codes.keys() == {"0", "2", "3", "4"}
    assert "wrongly" in codes[str(UsageError.exit_code)]
    assert "fit is not valid" in codes[str(FitError.exit_code)]
    assert "bad data" in codes[str(DataError.exit_code)]
