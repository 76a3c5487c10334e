"""`diagnose --protocol` writes what `rig --protocol` runs."""

import json

import pytest

LAW = ("--law", "exponential_law")
POOR = "[protocol]\npressures_MPa = [0.1, 0.2, 0.3, 0.4, 0.5]\nspeeds_mm_s = [10]\n"
DAMPED = (*LAW, "--effect", "viscous_damping", "--size", "2", "--seed", "62")


@pytest.mark.long
def test_a_poor_record_its_protocol_and_the_run_that_decides(ask, answer, tmp_path):
    poor, better, file = tmp_path / "poor", tmp_path / "better", tmp_path / "next.toml"
    (tmp_path / "poor.toml").write_text(POOR)
    assert ask("rig", poor, "--protocol", tmp_path / "poor.toml", *DAMPED).exit_code == 0
    result, found = answer("diagnose", poor / "record.csv", *LAW, "--protocol", file)
    assert result.exit_code == 0 and f"protocol: {file}" in result.stdout
    experiment = found["next_experiment"]
    assert set(experiment) == {"vary", "text", "predicted", "minutes", "protocol"} and "speed" in experiment["vary"]
    told = {one["rival"]: one["standard_errors"] for one in experiment["predicted"]}
    assert told["coulomb_friction"] > 5 and file.read_text().startswith("# To tell viscous damping from")
    assert ask("rig", better, "--protocol", file, *DAMPED).exit_code == 0
    _, again = answer("diagnose", better / "record.csv", *LAW)
    assert again["selected"] == ["viscous_damping"] and again["groups"] == []
    assert json.loads((better / "truth.json").read_text())[0]["truth"] == ["viscous_damping"]


def test_where_nothing_is_open_no_protocol_is_written(ask, clean, tmp_path):
    result = ask("diagnose", clean, *LAW, "--protocol", tmp_path / "next.toml")
    assert result.exit_code == 0 and "no protocol written: nothing is open here" in result.stdout
    assert not (tmp_path / "next.toml").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("diagnose", "a.csv", "b.csv", *LAW, "--protocol", "next.toml"), "give one record"),
        (("diagnose", "a.csv", *LAW, "--protocol", "next.txt"), "expected a file name ending in .toml"),
        (("rig", "x", "--size", "2"), "--size without --protocol"),
        (("rig", "x", "--repeat", "3"), "--repeat without --protocol"),
        (("rig", "x", "--effect", "creep"), "--effect without --protocol"),
        (("rig", "x", "--protocol", "none.toml"), "give its --law"),
        (("rig", "x", "--protocol", "none.toml", *LAW, "--only", "blunt"), "no --only"),
        (("rig", "x", "--protocol", "none.toml", *LAW), "no such file"),
    ],
)
def test_what_does_not_fit_together_is_refused(ask, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    result = ask(*words)
    assert result.exit_code == 2 and said in result.stderr
    assert not (tmp_path / "x").exists()
