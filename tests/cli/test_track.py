"""`track`: what it writes, what it says, and how it refuses."""

import json

import pytest

from pam_ident.records.datasets import dataset_path

FIT = dataset_path("leg_muscle") / "plant.json"
GIVEN = ("--kp", "2.7", "--ki", "1.7", "--kd", "0.26")


@pytest.fixture(scope="module")
def ran(ask, tmp_path_factory):
    """A fit as plant and as controller over the paper's 0.2 s, gains given: result, JSON, folder of figures."""
    folder = tmp_path_factory.mktemp("track")
    path = folder / "track.json"
    result = ask("track", "--plant", FIT, "--paper", *GIVEN, "--json", path, "--out", folder / "figures")
    assert result.exit_code == 0, result.output
    return result, json.loads(path.read_text(encoding="utf-8")), folder / "figures"


@pytest.mark.long
def test_the_answer_holds_what_the_contract_says(ran):
    _, found, _ = ran
    assert found["schema"] == "pam-ident/track/1"
    assert found["cadence_Hz"] == 1.0 and found["prototype"] is False
    assert set(found["budget"]) >= {"structure", "tuning", "muscle"}
    for run in (found["pid"], *found["rungs"]):
        assert 0.0 < run["rms_deg"] <= run["peak_deg"]
    (rung,) = found["rungs"]
    assert rung["effects"] == json.loads(FIT.read_text(encoding="utf-8"))["effects"]
    assert found["tuning"]["automatic"]["kp_MPa_per_rad"] == 2.7
    assert found["tuning"]["automatic"]["runs"] == 0
    assert found["duration_s"] == pytest.approx(0.2, abs=0.006)


@pytest.mark.long
def test_the_controller_that_knows_its_plant_beats_the_pid(ran):
    """And, being the plant, does as the plant's own model."""
    _, found, _ = ran
    (rung,) = found["rungs"]
    assert rung["rms_deg"] < found["pid"]["rms_deg"] / 3.0
    assert rung["rms_deg"] == pytest.approx(found["ideal"]["rms_deg"], rel=1e-6)
    low, high = rung["rms_band_deg"]
    assert 0.0 < low <= high


@pytest.mark.long
def test_the_budget_adds_up(ran):
    _, found, _ = ran
    budget, tuning = found["budget"], found["tuning"]
    assert budget["all_rms_deg"] == pytest.approx(tuning["by_hand"]["rms_deg"])
    assert budget["tuning"] == pytest.approx(tuning["by_hand"]["rms_deg"] - tuning["automatic"]["rms_deg"])


@pytest.mark.long
def test_it_says_the_same_in_words(ran):
    result, found, _ = ran
    for words in ("0.2 s of a stride", "in the reduced leg", "Kp 2.70 MPa/rad", "PID + the plant's own model"):
        assert words in result.stdout
    assert "two muscles as the fit's: " in result.stdout and " mm long, " in result.stdout
    assert f"{found['rungs'][0]['rms_deg']:.3f}" in result.stdout
    assert f"{found['budget']['muscle']:+.3f}" in result.stdout


@pytest.mark.long
def test_figures_are_written_and_named(ran):
    result, _, folder = ran
    assert sorted(path.name for path in folder.iterdir()) == ["four_bar.svg", "loop.svg", "tracking.svg"]
    assert all(f"wrote {path}" in result.stdout for path in folder.iterdir())


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (("--kp", "2.0"), 2, ("--kp", "--ki", "--kd")),
        (("--kp", "2.0", "--kd", "0.1"), 2, ("--ki",)),
        (("--gait", "gallop"), 2, ("gallop", "winter", "knee_deg")),
        (("--supply", "0"), 2, ("--supply", "0.1 MPa")),
        (("--supply", "nan"), 2, ("--supply",)),
        (("--load", "-1"), 2, ("--load", "0 kg")),
        (("--off", "-10", "200"), 2, ("--off", "-80 to 80")),
        (("--ageing", "-1"), 2, ("--ageing", "0 to 50")),
        (("--ground",), 2, ("--ground", "--prototype")),
        (("--learn", "-1"), 2, ("--learn", "strides")),
        (("--unknown", "crep"), 2, ("crep", "creep")),
        (("--unknown", "viscous_damping"), 2, ("viscous_damping", "twice")),
        (("--leg", "no_such.toml"), 4, ("no_such.toml", "--write-leg")),
        (("--cadence", "0"), 4, ("cadence", "positive")),
        (("--plant", "no_such.json"), 4, ("no_such.json", "no such file", "--json")),
        (("--specimen", "no_such.toml"), 4, ("no_such.toml",)),
    ],
)
def test_what_cannot_be_is_refused_in_one_message(ask, words, code, told):
    result = ask("track", *words)
    assert result.exit_code == code, result.output
    message = result.stderr.strip()
    assert 1 <= len(message.splitlines()) <= 2 and "Traceback" not in result.output
    for word in told:
        assert word in message


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("not json", "is no JSON"),
        ("{}", "schema"),
        ('{"schema": "pam-ident/diagnosis/1"}', "pam-ident/diagnosis/1"),
        ('{"schema": "pam-ident/fit/1", "law": "exponential_law"}', "specimen"),
    ],
)
def test_a_file_that_is_no_fit_is_bad_data(ask, tmp_path, text, told):
    (tmp_path / "fit.json").write_text(text, encoding="utf-8")
    result = ask("track", "--controller", tmp_path / "fit.json")
    assert result.exit_code == 4 and told in result.stderr and "fit.json" in result.stderr
    assert len(result.stderr.strip().splitlines()) <= 2


def test_the_own_leg_is_written_to_begin_from(ask, tmp_path):
    from pam_ident.leg.leg_file import DEFAULT, read_leg

    result = ask("track", "--write-leg", tmp_path / "leg.toml")
    assert result.exit_code == 0 and f"wrote {tmp_path / 'leg.toml'}" in result.stdout
    assert read_leg(tmp_path / "leg.toml") == DEFAULT
    (tmp_path / "leg.toml").write_text("[sprocket]\nradius = 0.04\n")
    result = ask("track", "--leg", tmp_path / "leg.toml")
    assert result.exit_code == 4 and "leg.toml: unknown key of [sprocket] 'radius'" in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


@pytest.mark.long
def test_a_leg_off_the_drawing_board_says_so_in_words_and_json(ask, tmp_path):
    words = ("--off", "-10", "10", "--unknown", "creep", "--learn", "2", "--prototype", "--ground")
    result = ask("track", "--plant", FIT, *GIVEN, *words, "--json", tmp_path / "track.json")
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "track.json").read_text(encoding="utf-8"))
    assert found["off"] == {
        "force": [0.9, 1.1],
        "mass": 1.0,
        "supply": 1.0,
        "ageing": 0.0,
        "unknown": "creep",
        "size": 1.0,
    }
    assert found["ground"] and found["lessons"] == 2
    assert "on the ground" in result.stdout and "flexor's force -10 %" in result.stdout
    assert "learns from 2 strides" in result.stdout
    assert any(one["code"] == "outside_range" and one["column"] == "pressure_MPa" for one in found["warnings"])
    assert all(one["text"] in result.stdout for one in found["warnings"])
    assert found["rungs"][0]["rms_deg"] < found["pid"]["rms_deg"] / 2.0


def test_a_gait_without_a_knee_is_bad_data(ask, tmp_path):
    (tmp_path / "gait.csv").write_text("time_s,hip_deg\n" + "".join(f"{k / 10},1\n" for k in range(10)))
    result = ask("track", "--gait", tmp_path / "gait.csv")
    assert result.exit_code == 4 and "knee_deg" in result.stderr
