"""`challenge` as a user calls it: a set is made, answered, opened and scored, or a person's answers are."""

import json

import pytest

from pam_ident.parallel.executor import Executor
from pam_ident.validation import challenge


@pytest.fixture
def guess(monkeypatch):
    """Answers in place of the diagnosis, which takes seconds: nothing is ever missing."""
    ranking = [{"effect": "creep", "status": "candidate", "probability": 0.2}]

    def answer(folder, case, law):
        return {"record": f"{case}/record.csv", "verdict": "adequate", "selected": [], "ranking": ranking}

    monkeypatch.setattr(challenge, "answer_case", answer)
    monkeypatch.setattr(Executor, "of_cores", lambda *asked: Executor())


@pytest.mark.long
def test_the_program_sits_its_own_examination(answer, tmp_path):
    out = tmp_path / "set"
    result, found = answer("challenge", "--n", 2, "--only", "null", "--seed", 3, "--out", out, "--workers", 2)
    assert result.exit_code == 0 and result.stderr == ""
    assert found["schema"] == "pam-ident/challenge/1" and found["seconds"] > 0
    assert found["kinds"]["all"] == found["kinds"]["null"] == {
        "n": 2, "right": 2, "exact": 2, "right_by_group": 2, "error_removed_median": None, "error_removed_worst": None,
    }  # fmt: skip
    assert found["confusion"] == [{"hidden": "nothing", "named": "nothing", "count": 2}]
    assert found["calibration"]["brier"] < 0.01 and sum(b["true"] for b in found["calibration"]["bins"]) == 0
    assert "false alarms 0 of 2" in result.stdout
    assert len((out / "answers.jsonl").read_text().splitlines()) == 2
    for name in ("confusion.svg", "calibration.svg"):
        assert (out / name).read_text().lstrip().startswith("<?xml"), name


def test_all_that_is_missed_is_told(ask, guess, tmp_path):
    result = ask("challenge", "--n", 3, "--only", "pair", "--out", tmp_path / "set")
    assert result.exit_code == 0 and "not right, or not exact:" in result.stdout
    assert result.stdout.count("  missed\n") == 3 and "3 probabilities stated" in result.stdout


def test_a_set_written_by_rig_is_scored_with_answers_of_one_s_own(ask, answer, tmp_path):
    folder, mine = tmp_path / "set", tmp_path / "mine.jsonl"
    assert ask("rig", folder, "--n", 2, "--only", "null").exit_code == 0
    lines = [
        {"case": "c000", "verdict": "adequate"},
        {"case": "c001", "verdict": "missing_effect", "selected": ["creep"]},
    ]
    mine.write_text("".join(json.dumps(one) + "\n" for one in lines))
    result, found = answer("challenge", "--out", folder, "--answers", mine)
    assert result.exit_code == 0 and found["kinds"]["null"]["right"] == 1 and found["seconds"] is None
    assert "false alarms 1 of 2" in result.stdout and not (folder / "answers.jsonl").exists()
    assert not (folder / "calibration.svg").exists(), "no probability was stated"


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (("--n", 0), 2, "n = 0"),
        (("--only", "luck"), 2, "tier1"),
        (("--workers", 0), 2, "workers = 0"),
        (("--answers", "mine.jsonl"), 2, "--out"),
        (("--answers", "mine.jsonl", "--out", "nowhere"), 4, "expected a set as `pam-ident rig nowhere` writes it"),
    ],
)
def test_a_wrong_call_is_refused_in_one_line(ask, words, code, told):
    result = ask("challenge", *words)
    assert result.exit_code == code and told in result.stderr and len(result.stderr.splitlines()) == 1
