"""`validate` and `predict` ask a saved fit; a law is chosen where none is named; names, widths and exit codes."""

import io
import json

import numpy as np
import pandas as pd
import pytest

from pam_ident.cli import text
from pam_ident.rig import Plan, Secret, make_record, write_case

LAW = ("--law", "exponential_law")


@pytest.fixture(scope="module")
def saved(ask, clean, tmp_path_factory):
    path = tmp_path_factory.mktemp("fit") / "fit.json"
    assert ask("fit", clean, *LAW, "--json", path).exit_code == 0
    return path


def test_validate_on_another_record(answer, saved, clean, rubbing):
    result, found = answer("validate", saved, rubbing)
    assert result.exit_code == 0 and found["schema"] == "pam-ident/validation/1"
    assert found["rmse_N"] == pytest.approx(np.hypot(12.0, 1.0), abs=0.3) and found["coverage"] < 0.1
    assert "So it does not hold for this record. No simpler model does as well" in result.stdout
    _, part = answer("validate", saved, rubbing, "--where", "pressure_MPa > 0.25")
    assert 0 < part["n"] < found["n"]
    _, same = answer("validate", saved, clean)
    assert same["rmse_N"] == pytest.approx(1.0, abs=0.1) and 0.93 < same["coverage"] < 0.98
    assert [one["name"] for one in same["simpler"]] == ["mean_over_pressure", "polynomial"]
    assert all(one["rmse_N"] > same["rmse_N"] for one in same["simpler"])
    assert "own_record" in [one["code"] for one in same["warnings"]]
    assert not {"own_record", "other_specimen"} & {one["code"] for one in found["warnings"]}


def test_validate_on_the_record_that_a_ladder_climbed_is_no_test(ask, answer, rubbing, tmp_path):
    assert ask("ladder", rubbing, *LAW, "--heldout", "refit", "--json", tmp_path / "ladder.json").exit_code == 0
    _, found = answer("validate", tmp_path / "ladder.json", rubbing)
    assert "own_record" in [one["code"] for one in found["warnings"]]


def test_one_record_given_twice_is_no_more_evidence(ask, clean):
    refused = ask("fit", clean, clean, *LAW, "--shared", "all")
    assert refused.exit_code == 2 and "given twice; it would count as twice the evidence" in refused.stderr


def test_validate_on_another_muscle_says_so(answer, saved, rubbing, tmp_path):
    muscle = '[specimen]\nname = "thick"\ninitial_length_mm = 200\ninitial_radius_mm = 12\nbraid_angle_deg = 25\n'
    (tmp_path / "specimen.toml").write_text(muscle, encoding="utf-8")
    _, found = answer("validate", saved, rubbing, "--specimen", tmp_path / "specimen.toml")
    told = {one["code"]: one["text"] for one in found["warnings"]}
    assert "the record of thick (length 200 mm, radius 12 mm, braid angle 25°)" in told["other_specimen"]


def test_a_fit_that_was_not_valid_says_so_elsewhere(ask, answer, saved, clean, tmp_path):
    content = json.loads(saved.read_text())
    content["branches"]["together"]["parameters"]["mu"]["identified"] = False
    (tmp_path / "loose.json").write_text(json.dumps(content))
    (tmp_path / "states.csv").write_text("pressure_bar,contraction_pct\n2.5,0\n", encoding="utf-8")
    asked = ask("predict", tmp_path / "loose.json", "--at", tmp_path / "states.csv")
    assert asked.exit_code == 0 and "the fit is not valid: its record did not determine mu" in asked.stderr
    _, judged = answer("validate", tmp_path / "loose.json", clean)
    assert "undetermined" in [one["code"] for one in judged["warnings"]]
    reading = content["branches"]["together"]["reading"]
    reading.update({key: None for key in reading if key.endswith("_N")})
    (tmp_path / "loose.json").write_text(json.dumps(content))
    (tmp_path / "loads.csv").write_text("pressure_MPa,force_N\n0.25,200\n", encoding="utf-8")
    lengths = ask("predict", tmp_path / "loose.json", "--at", tmp_path / "loads.csv")
    assert "did not determine mu" in lengths.stderr and "how far lengths lie off was not learned" in lengths.stderr


def test_predict_writes_a_table(ask, answer, saved, tmp_path):
    states = tmp_path / "states.csv"
    states.write_text("pressure_bar,contraction_pct\n2.5,0\n2.5,10\n9,10\n", encoding="utf-8")
    result = ask("predict", saved, "--at", states)
    table = pd.read_csv(io.StringIO(result.stdout))
    assert result.exit_code == 0 and table["pressure_MPa"].tolist() == [0.25, 0.25, 0.9]
    force = -190 + 2400 * 0.25 - (900 + 5500 * 0.25) * 0.1 + (20 + 690 * 0.25) * np.exp(-4.5)
    assert table["force_N"][1] == pytest.approx(force, abs=0.5)
    order = ["reading_low_N", "mean_low_N", "force_N", "mean_high_N", "reading_high_N"]
    assert (np.diff(table.loc[1, order].to_numpy(float)) > 0).all()
    assert table["outside"].tolist() == [False, False, True] and "1 row lies outside" in result.stderr
    result, found = answer("predict", saved, "--at", states, "--out", tmp_path / "force.csv")
    assert found["columns"]["force_N"] == pytest.approx(table["force_N"].tolist(), rel=1e-6)
    assert pd.read_csv(tmp_path / "force.csv").shape == (3, 10)


def test_states_are_read_as_records_are_and_what_is_odd_is_said(ask, saved, tmp_path):
    states = tmp_path / "states.csv"
    states.write_text("pressure_bar;contraction;speed\n2,5;0,1;3\n30;0,05;3\n", encoding="utf-8")
    (tmp_path / "columns.toml").write_text("[columns]\npressure_bar = 'P'\nlength_mm = 'L'\nforce_N = 'F'\n")
    result = ask("predict", saved, "--at", states)
    table = pd.read_csv(io.StringIO(result.stdout))
    assert table["pressure_MPa"].tolist() == [0.25, 3.0] and table["contraction"].tolist() == [0.1, 0.05]
    assert "column 'speed' is none of" in result.stderr and "Furthest: 3 MPa, where 0.2 to 0.4" in result.stderr
    states.write_text("pressure_MPa,contraction\n0.25,0.1\n0.25,10\n", encoding="utf-8")
    refused = ask_error(ask, "predict", saved, "--at", states)
    assert refused.exit_code == 4 and "states.csv, row 3, column 'contraction': contraction ratio 10" in refused.stderr
    assert "branch" in ask("predict", "--help").stdout


def test_states_of_a_locked_muscle_need_no_force(ask, tmp_path):
    """Taken as under no load, their friction had the sign of another motion: 11.9 N off where 2.4 N are left."""
    secrets = (Secret("coulomb_friction", "textbook", 4.0),)
    write_case(tmp_path, make_record(Plan(31, "modified_chou_hannaford", secrets, protocol="locked_ramps")))
    record, model = tmp_path / "record.csv", ("--law", "modified_chou_hannaford", "--effect", "coulomb_friction")
    result = ask("fit", record, *model, "--json", tmp_path / "fit.json")
    assert result.exit_code == 0 and "energy of a cycle" not in result.stdout, "the pressure was driven: no isobar"
    assert json.loads((tmp_path / "fit.json").read_text(encoding="utf-8"))["loops"] == []
    assert "std. of p" not in ask("inspect", record).stdout
    table = pd.read_csv(record)
    table.drop(columns="force_N").to_csv(tmp_path / "states.csv", index=False)
    result = ask("predict", tmp_path / "fit.json", "--at", tmp_path / "states.csv")
    force = pd.read_csv(io.StringIO(result.stdout))["force_N"]
    assert np.std(table["force_N"] - force) < 3.0


def test_predict_says_why_its_intervals_are_wide(ask, saved, rubbing, tmp_path):
    states = tmp_path / "states.csv"
    states.write_text("pressure_MPa,contraction\n0.25,0.1\n", encoding="utf-8")
    assert "intervals" not in ask("predict", saved, "--at", states).stderr
    assert ask("fit", rubbing, *LAW, "--json", tmp_path / "fit.json").exit_code == 0
    result = ask("predict", tmp_path / "fit.json", "--at", states)
    assert "leaves more than noise" in result.stderr
    assert pd.read_csv(io.StringIO(result.stdout))["unexplained"].tolist() == [True]


def test_a_saved_fit_with_a_branch_each_asks_for_the_branch(ask, clean, tmp_path):
    assert ask("fit", clean, *LAW, "--branch", "separate", "--json", tmp_path / "fit.json").exit_code == 0
    states = tmp_path / "states.csv"
    states.write_text("pressure_MPa,contraction\n0.25,0.05\n", encoding="utf-8")
    result = ask_error(ask, "predict", tmp_path / "fit.json", "--at", states)
    assert result.exit_code == 2 and "give branch" in result.stderr
    states.write_text("pressure_MPa,contraction,branch\n0.25,0.05,extension\n", encoding="utf-8")
    assert ask("predict", tmp_path / "fit.json", "--at", states).exit_code == 0


@pytest.mark.long
def test_add_and_ladder_are_asked_like_a_fit_and_a_diagnosis_says_how_to_get_one(answer, ask, rubbing, tmp_path):
    states = tmp_path / "states.csv"
    states.write_text("time_s,pressure_MPa,displacement_mm\n0,0.25,10\n1,0.25,20\n2,0.9,24\n", encoding="utf-8")
    effect = ("--effect", "coulomb_friction:held")
    added, climbed, diagnosed = (tmp_path / f"{name}.json" for name in ("add", "ladder", "diagnosis"))
    assert ask("add", rubbing, *LAW, *effect, "--json", added).exit_code == 0
    assert ask("ladder", rubbing, *LAW, "--heldout", "refit", "--json", climbed).exit_code == 0
    result = ask("diagnose", rubbing, *LAW, "--only", "coulomb_friction", "--json", diagnosed)
    command = json.loads(diagnosed.read_text(encoding="utf-8"))["fit_command"]
    assert f"fit it: {command}" in result.stdout
    words = command.replace("fit.json", str(tmp_path / "fit.json")).split()
    assert words[:2] == ["pam-ident", "fit"] and ask(*words[1:]).exit_code == 0, "the line does what it says"
    forces = []
    for path in (tmp_path / "fit.json", added, climbed):
        _, found = answer("predict", path, "--at", states)
        forces.append(found["columns"]["force_N"])
        assert found["columns"]["outside"] == [False, False, True] and found["effects"] == [effect[1]]
        _, judged = answer("validate", path, rubbing)
        assert judged["rmse_N"] == pytest.approx(1.0, abs=0.1)
        assert judged["coverage"] == pytest.approx(0.95, abs=0.02) and len(judged["simpler"]) == 2
        assert ask("export", path, "--to", "python", "--out", tmp_path / "arm.py").exit_code == 0
    assert forces[1] == pytest.approx(forces[0], rel=1e-3) == forces[2]
    refused = ask_error(ask, "predict", diagnosed, "--at", states)
    assert refused.exit_code == 4 and command in refused.stderr


def ask_error(ask, *words):
    return ask(*words)


@pytest.mark.parametrize("verb", ["fit", "compare"])
def test_without_a_law_one_is_chosen_and_it_says_why(answer, verb, clean):
    result, found = answer(verb, clean)
    assert result.exit_code == 0 and found["law"] == "exponential_law" and len(found["law_choice"]["laws"]) == 9
    assert f"law: {found['law_choice']['why']}" in result.stdout and "held-out" in found["law_choice"]["why"]
    _, named = answer(verb, clean, *LAW)
    assert "law_choice" not in named and named["law"] == found["law"]


def test_a_data_set_goes_by_its_name(ask):
    assert "60 samples" in ask("inspect", "dmsp20_300").stdout
    result = ask("inspect", "dmsp20_30")
    assert result.exit_code == 4 and "did you mean the data set dmsp20_300?" in result.stderr


def test_mistyped_names_are_answered_by_those_like_them(ask, clean):
    for words, meant in (
        (("laws", "sarosy"), "sarosi"),
        (("effects", "crep"), "creep"),
        (("fit", clean, "--law", "exponental"), "exponential_law"),
        (("fit", clean, *LAW, "--effect", "coulomb"), "coulomb_friction"),
    ):
        result = ask(*words)
        assert result.exit_code == 2 and f"did you mean {meant}" in result.stderr and len(result.stderr) < 200
    told = ask("fit", "none.csv").stderr
    assert "hidden_effect" in told and "gait" not in told, "what may be asked for is listed"


def test_one_law_and_one_effect_in_full(ask):
    law, effect = ask("laws", "sarosi").stdout, ask("effects", "creep").stdout
    assert "mu (μ)" in ask("laws", "exponential_law").stdout
    assert "F = (s1 p + s2) exp(s3 ε)" in law and "-400 to -1" in law and "chou_hannaford" not in law
    assert "any" in law and "inf" not in law + effect
    assert effect == ask("effects", "show", "creep").stdout and "form textbook" in effect


@pytest.mark.parametrize("method", ["global", "two-stage", "both"])
def test_a_law_at_its_bound_that_nothing_tells_apart_ends_with_3_by_every_method(answer, write_record, method):
    rows, t = ["time_s,pressure_MPa,displacement_mm,force_N"], 0.0
    rng = np.random.default_rng(1)
    for p in (0.2, 0.3, 0.4):
        for start, end in 3 * ((0.0, 24.0), (24.0, 0.0)):
            for x in np.linspace(start, end, 60, endpoint=False):
                e = x / 200.0
                force = -190 + 2400 * p - (900 + 5500 * p) * e + 3000 * e**2 + rng.normal()
                rows.append(f"{t:.3f},{p},{x:.4f},{force:.4f}")
                t += 0.05
    result, found = answer("fit", write_record("\n".join(rows) + "\n"), *LAW, "--method", method)
    parameters = found["branches"]["together"]["parameters"]
    assert result.exit_code == 3 and "does not determine" in result.stderr and ", mu;" in result.stderr
    assert parameters["mu"]["at_bound"] and not parameters["mu"]["identified"] and not parameters["c1"]["identified"]


def test_an_isobar_that_does_not_determine_what_is_printed_of_it_ends_with_3(answer):
    words = ("fit", "nothing_hidden", "--law", "martens_boblan")
    assert answer(*words)[0].exit_code == 0, "all isobars at once"
    result, found = answer(*words, "--method", "two-stage")
    assert result.exit_code == 3 and "0.1 MPa alone" in " ".join(result.stderr.split())
    assert all(one["identified"] for one in found["branches"]["together"]["parameters"].values())


def test_two_stages_of_a_law_without_parameters_are_its_isobars(answer):
    result, found = answer("fit", "nothing_hidden", "--law", "chou_hannaford", "--method", "two-stage")
    assert result.exit_code == 0 and [row["parameters"] for row in found["per_pressure"]] == 5 * [{}]


def test_tables_are_no_wider_than_the_terminal(ask, monkeypatch, rubbing):
    monkeypatch.setattr(text, "columns", lambda: 80)
    for words in (
        ("effects",),
        ("laws",),
        ("fit", rubbing, *LAW, "--method", "two-stage"),
        ("inspect", "nothing_hidden"),
    ):
        lines = ask(*words).stdout.splitlines()
        assert max(map(len, lines)) <= 80, words
    monkeypatch.setenv("COLUMNS", "60")
    for words in (("effects", "coulom_friction"), ("fit", "hiden_effect"), ("fit", "paper_laws", "--law", "chu")):
        lines = ask(*words).stderr.splitlines()
        assert len(lines) > 1 and max(map(len, lines)) <= 60, words
    narrow = text.table(("name", "words"), [("a", "one two three four five six " * 4)], left=(0, 1))
    assert (
        len(narrow) > 2
        and " ".join(" ".join(narrow[1:]).split()) == "a " + ("one two three four five six " * 4).strip()
    )


def test_a_name_stays_whole_on_a_narrow_terminal(monkeypatch):
    monkeypatch.setattr(text, "columns", lambda: 40)
    name = "wickramatunge_leephakpreeda"
    lines = text.table(("rung", "model", "n"), [("0", f"{name} + {name}", "7")], left=(0, 1))
    assert max(map(len, lines)) <= 40 and sum(name in line for line in lines) == 2


@pytest.mark.parametrize(
    ("share", "said"), [(0.995, "> 99 %"), (1.0, "> 99 %"), (0.99, "99 %"), (0.5, "50 %"), (0.004, "< 1 %")]
)
def test_nothing_is_certain(share, said):
    assert text.probability(share) == said


def test_candidates_are_in_order_and_none_are_offered_where_nothing_is_missing(answer, ask, rubbing, clean):
    some = ("--only", "coulomb_friction", "--only", "viscous_damping", "--only", "force_bias", "--only", "creep")
    result, found = answer("diagnose", rubbing, *LAW, *some)
    rows = [line.split() for line in result.stdout.splitlines() if line.endswith(tuple("0123456789")) and "%" in line]
    table = [(row[0], row[-2]) for row in rows if row[0].partition(":")[0] in some]
    assert table[0][0].startswith("coulomb_friction") and [float(n) for _, n in table[1:]] == sorted(
        float(n) for _, n in table[1:]
    )
    judged = [one["effect"] for one in found["ranking"] if one["status"] == "candidate"]
    assert judged == [name.partition(":")[0] for name, _ in table], "JSON has the order of the text"
    assert "candidate" not in ask("diagnose", clean, *LAW, *some).stdout


def test_digits_are_those_of_the_standard_error():
    from types import SimpleNamespace

    def told(value, error):
        return text.value_of(SimpleNamespace(value=value, stderr=error, identified=True, at_bound=False))

    assert told(0.95707, 0.060) == "0.957" and told(-185.7058, 0.7146) == "-185.71" and told(5506.1, 27.0) == "5506"
    assert json.loads(told(1613.228, 11.28)) == 1613 and told(12.0, 0.00995) == "12.000"
    assert told(-0.0105, 0.8) == "-0.01" and told(-0.3, 11.0) == "0"
