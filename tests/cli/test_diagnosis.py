"""`compare`, `diagnose`, `add` and `ladder` answer in words, in tables and by the contract."""

import json

import pytest

LAW = ("--law", "exponential_law")
DIAGNOSIS = {
    "schema", "record", "law", "n", "rmse_N", "noise_floor_N", "verdict", "selected", "groups", "ranking",
    "rmse_after_N", "heldout_rmse_N", "heldout_rmse_after_N", "heldout", "follows", "pattern", "next_experiment",
    "fit_command", "warnings",
}  # fmt: skip


@pytest.fixture(scope="session")
def hidden(root):
    return root / "datasets" / "hidden_effect" / "record.csv"


@pytest.fixture(scope="session")
def nothing(root):
    return root / "datasets" / "nothing_hidden" / "record.csv"


def test_compare_says_where_the_error_lies(answer, rubbing):
    result, found = answer("compare", rubbing, *LAW)
    assert result.exit_code == 0 and found["schema"] == "pam-ident/comparison/1"
    shares = found["odd_share"], found["even_share"], found["rest_share"]
    assert sum(shares) == pytest.approx(1.0) and min(shares) >= 0.0 and shares[0] > 10.0 * shares[1]
    assert "changes sign with the branch" in result.stdout
    for coordinate in ("pressure_MPa", "contraction", "branch", "speed_mm_s", "cycle"):
        assert sum(one["share"] for one in found["by"][coordinate]) == pytest.approx(1.0, abs=1e-6), coordinate
    for head in ("by pressure", "by branch", "by speed"):
        assert head in result.stdout
    _, better = answer("compare", rubbing, *LAW, "--effect", "coulomb_friction:held")
    assert better["rmse_N"] < 0.2 * found["rmse_N"] and better["odd_share"] < 0.2


@pytest.mark.parametrize(("name", "start"), [("map.svg", b"<"), ("map.png", b"\x89PNG")])
def test_compare_saves_its_picture(ask, rubbing, tmp_path, name, start):
    result = ask("compare", rubbing, *LAW, "--out", tmp_path / name)
    assert result.exit_code == 0 and (tmp_path / name).read_bytes().startswith(start)
    assert len((tmp_path / name).read_bytes()) > 2000


def test_diagnose_names_the_friction_that_is_there(answer, rubbing):
    result, found = answer("diagnose", rubbing, *LAW)
    assert result.exit_code == 0 and set(found) == DIAGNOSIS
    assert found["schema"] == "pam-ident/diagnosis/1" and found["record"] == str(rubbing) and found["n"] == 1200
    assert found["verdict"] == "missing_effect" and found["selected"] == ["coulomb_friction"]
    assert all(set(group) & set(found["selected"]) == {"coulomb_friction"} for group in found["groups"])
    assert found["rmse_after_N"] == pytest.approx(1.0, abs=0.1) and found["rmse_N"] > 5
    assert found["heldout_rmse_after_N"] < 0.3 * found["heldout_rmse_N"]
    assert found["follows"][0]["what"] == "direction" and found["follows"][0]["share"] > 0.8
    assert sum(one["share"] for one in found["follows"]) == pytest.approx(1.0)
    for one in found["ranking"]:
        assert set(one) == {"effect", "status", "probability", "rmse_after_N", "heldout_rmse_after_N"}
        assert one["status"] in ("candidate", "absorbed_by_law", "not_excited")
    assert "verdict: missing effect" in result.stdout and "Coulomb friction (coulomb_friction" in result.stdout


def test_diagnose_finds_nothing_where_nothing_is(answer, clean):
    result, found = answer("diagnose", clean, *LAW)
    assert result.exit_code == 0
    assert found["verdict"] == "adequate" and found["selected"] == [] and found["groups"] == []


def test_diagnose_with_the_effect_in_the_model_is_adequate(answer, rubbing):
    _, found = answer("diagnose", rubbing, *LAW, "--effect", "coulomb_friction:held")
    assert found["verdict"] == "adequate" and found["selected"] == []


@pytest.mark.long
def test_several_records_get_a_line_each_and_a_bad_one_stops_none(ask, rubbing, clean, write_record, tmp_path):
    bad = write_record("time_s,force_N\n0,1\n")
    out = tmp_path / "answers.jsonl"
    result = ask("diagnose", rubbing, bad, clean, *LAW, "--json", out)
    assert result.exit_code == 4 and len(result.stderr.strip().splitlines()) == 1 and str(bad) in result.stderr
    found = [json.loads(line) for line in out.read_text().splitlines()]
    assert [one["record"] for one in found] == [str(rubbing), str(bad), str(clean)]
    assert [one["verdict"] for one in found] == ["missing_effect", "unknown_effect", "adequate"]


@pytest.mark.long
def test_each_record_takes_its_own_specimen(ask, clean, write_record, tmp_path):
    text = (clean.parent / "specimen.toml").read_text().replace("200.0", "400.0")
    other = write_record(clean.read_text(), specimen=text)
    out = tmp_path / "answers.jsonl"
    law = ("--law", "chou_hannaford")
    assert ask("diagnose", clean, other, *law, "--json", out).exit_code == 0
    near, far = [json.loads(line)["rmse_N"] for line in out.read_text().splitlines()]
    assert near != pytest.approx(far, rel=1e-3)


def test_an_unknown_law_stops_all_records(ask, rubbing, clean):
    result = ask("diagnose", rubbing, clean, "--law", "hooke")
    assert result.exit_code == 2 and result.stdout == ""


@pytest.mark.long
def test_the_hidden_effect_of_the_data_sets_is_found_first(answer, hidden, nothing):
    _, found = answer("diagnose", hidden, *LAW)
    assert found["verdict"] == "missing_effect" and found["selected"][0] == "pressure_friction"
    assert found["rmse_after_N"] < 1.1 * 2.08
    _, twin = answer("diagnose", nothing, *LAW)
    assert twin["verdict"] == "adequate" and twin["selected"] == []


def test_add_shows_before_and_after(answer, rubbing):
    result, found = answer("add", rubbing, *LAW, "--effect", "coulomb_friction:held")
    assert result.exit_code == 0 and found["schema"] == "pam-ident/add/1"
    assert found["effects"] == ["coulomb_friction:held"]
    for side in ("before", "after"):
        assert set(found[side]) == {"rmse_N", "heldout_rmse_N", "max_error_N"}
    for name in ("rmse_N", "heldout_rmse_N", "max_error_N"):
        assert found["after"][name] < 0.5 * found["before"][name]
    size = found["parameters"]["coulomb_friction.F_c"]
    assert abs(size["value"] - 12.0) < 4 * size["stderr"]
    assert "held-out data" in result.stdout and "largest error" in result.stdout


def test_adding_what_is_not_there_does_not_help_on_held_out_data(answer, clean):
    _, found = answer("add", clean, *LAW, "--effect", "viscous_damping")
    assert found["after"]["heldout_rmse_N"] > 0.99 * found["before"]["heldout_rmse_N"]


def test_adding_what_the_law_has_absorbed_is_not_valid(answer, clean):
    result, found = answer("add", clean, *LAW, "--effect", "force_bias")
    assert result.exit_code == 3 and "does not determine" in result.stderr
    bias = [one for name, one in found["parameters"].items() if name.startswith("force_bias.")]
    assert [one["identified"] for one in bias] == [False] and bias[0]["stderr"] is None


@pytest.mark.long
def test_the_ladder_falls_to_the_floor_and_stops(answer, rubbing):
    result, found = answer("ladder", rubbing, *LAW)
    assert result.exit_code == 0
    keys = {"schema", "record", "law", "specimen", "free_geometry", "range", "rungs", "noise_floor_N", "verdict"}
    keys |= {"warnings", "heldout", "nested", "groups"}
    assert set(found) == keys and found["heldout"] == "nested" and found["free_geometry"] is False
    assert found["schema"] == "pam-ident/ladder/1" and found["verdict"] == "adequate"
    assert found["rungs"][0]["effects"] == [] and len(found["rungs"]) == 2
    keys = {"effects", "rmse_N", "heldout_rmse_N", "refit_rmse_N", "shares_N", "parameters", "covariance"}
    assert [set(one) for one in found["rungs"]] == [keys, keys | {"reading", "simpler"}]
    assert found["rungs"][-1]["effects"][0].startswith("coulomb_friction")
    assert found["groups"] == []
    assert found["rungs"][-1]["rmse_N"] < 1.1 * found["noise_floor_N"] < 0.3 * found["rungs"][0]["rmse_N"]
    assert "step" in result.stdout and "verdict: adequate" in result.stdout


@pytest.mark.long
def test_the_ladder_of_a_good_law_has_one_rung(one_process, answer, clean):
    _, found = answer("ladder", clean, *LAW)
    assert found["verdict"] == "adequate" and [one["effects"] for one in found["rungs"]] == [[]]


@pytest.mark.long
def test_an_effect_is_tried_that_is_asked_for(answer, rubbing, ask):
    result, found = answer("diagnose", rubbing, *LAW, "--also", "end_contact")
    assert result.exit_code == 0 and "end_contact" in {one["effect"] for one in found["ranking"]}
    assert "--also end_contact" in ask("effects", "end_contact").stdout
    refused = ask("ladder", rubbing, *LAW, "--also", "end_contract")
    assert refused.exit_code == 2 and "end_contact" in refused.stderr
