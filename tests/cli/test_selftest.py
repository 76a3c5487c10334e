"""`selftest` says whether the installation computes what it should, and notices when it does not."""

from dataclasses import replace

import pytest

from pam_ident.validation import certified, selftest


@pytest.mark.long
def test_the_selftest_passes_and_answers_by_the_contract(answer):
    result, found = answer("selftest")
    assert result.exit_code == 0 and result.stdout.splitlines()[-1].startswith("selftest passed: 12 certified fits")
    assert found["schema"] == "pam-ident/selftest/1" and found["passed"] is True
    assert [(one["name"], one["start"]) for one in found["problems"]] == [
        (name, start) for name in ("DanWood", "BoxBOD", "Rat42", "MGH09", "Misra1a", "MGH10") for start in (1, 2)
    ]
    for one in found["problems"]:
        assert set(one) == {"name", "start", "digits", "digits_stderr"}
        assert one["digits"] >= 6.0 and one["digits_stderr"] >= 6.0
    assert found["recovery"]["named"] == [found["recovery"]["hidden"]] == ["pressure_friction"]


@pytest.fixture
def recovered(monkeypatch):
    """The slow part taken as passed."""
    fine = selftest.Recovery(1.0, "adequate", "creep", ("creep",))
    monkeypatch.setattr(selftest, "_recover", lambda: fine)
    return fine


def test_quiet_leaves_the_verdict_to_the_exit_code(ask, recovered):
    result = ask("selftest", "--quiet")
    assert result.exit_code == 0 and result.output == ""


def test_a_wrong_digit_is_noticed_and_named(ask, recovered, monkeypatch):
    first, *others = certified.PROBLEMS
    wrong = replace(first, values=(first.values[0] * (1 + 1e-5), first.values[1]))
    monkeypatch.setattr(selftest, "PROBLEMS", (wrong, *others))
    result = ask("selftest")
    assert result.exit_code == 3 and "selftest failed: DanWood from start 1, DanWood from start 2;" in result.stderr
    assert "5.0" in result.stdout and "passed" not in result.stdout


@pytest.mark.parametrize(
    "change",
    [{"furthest": 4.1}, {"named": ()}, {"named": ("creep", "force_drift")}, {"clean_verdict": "missing_effect"}],
)
def test_a_record_that_is_not_recovered_fails_it(ask, recovered, monkeypatch, change):
    monkeypatch.setattr(selftest, "_recover", lambda: replace(recovered, **change))
    result = ask("selftest", "--quiet")
    assert result.exit_code == 3 and "the simulated records" in result.stderr and result.stdout == ""


def test_digits_are_those_that_agree():
    assert certified.agreement([1.001, 2.0], (1.0, 2.0)) == pytest.approx(3.0)
    assert certified.agreement([1.0, 2.0], (1.0, 2.0)) == 11.0
    assert certified.agreement([float("nan")], (1.0,)) == 0.0
    assert certified.agreement([3.0], (1.0,)) == 0.0
