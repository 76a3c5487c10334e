"""Scores worked out by hand, answers refused by line, and an envelope that stays closed until all answers are there."""

import json

import pytest

from pam_ident.core import DataError, UsageError
from pam_ident.core.progress import heard
from pam_ident.parallel.executor import Executor, WorkerLost
from pam_ident.records import read_record
from pam_ident.rig.challenge import write_case
from pam_ident.rig.record import Plan, Secret, make_record
from pam_ident.validation import challenge
from pam_ident.validation.challenge import write_challenge
from pam_ident.validation.holdout import forms_left_out
from pam_ident.validation.score import confusion, score, tally


def truth(*hidden, unknown=None, blunt=False, tier=1, case="c000"):
    return {
        "case": case, "law": "exponential_law", "truth": sorted(hidden), "unknown": unknown, "tier": tier,
        "blunt": blunt, "noise_rms": 3.0, "rmse_base": 5.0,
    }  # fmt: skip


def answer(*selected, verdict=None, groups=(), **more):
    verdict = verdict or ("missing_effect" if selected else "adequate")
    return {"verdict": verdict, "selected": list(selected), "groups": [list(g) for g in groups], **more}


def grade(one):
    return one.right, one.exact


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (answer("creep"), (True, True)),
        (answer("creep", "coulomb_friction"), (True, False)),
        (answer("coulomb_friction", "creep"), (False, False)),
        (answer("mullins_softening", groups=[("mullins_softening", "creep")]), (True, False)),
        (answer("creep", groups=[("creep", "a", "b", "c", "d")]), (False, False)),
        (answer(), (False, False)),
        (answer(verdict="none"), (False, False)),
    ],
)
def test_one_effect_is_right_by_the_first_name_or_its_group(given, expected):
    assert grade(score(truth("creep"), given)) == expected


def test_a_name_of_the_same_family_is_exact_only_where_the_group_holds_the_truth():
    hidden = truth("stribeck_friction", tier=2)
    assert grade(score(hidden, answer("coulomb_friction"))) == (False, False)
    grouped = answer("coulomb_friction", groups=[("coulomb_friction", "stribeck_friction")])
    assert grade(score(hidden, grouped)) == (True, True)


def test_two_effects_are_asked_for_by_name_and_counted_by_group_apart():
    hidden = truth("creep", "stribeck_friction")
    given = answer("creep", "coulomb_friction", groups=[("coulomb_friction", "stribeck_friction")])
    one = score(hidden, given)
    assert (one.right, one.exact, one.grouped) == (False, False, True)
    assert grade(score(hidden, answer("stribeck_friction", "creep"))) == (True, True)
    assert grade(score(hidden, answer("stribeck_friction", "creep", "force_drift"))) == (True, False)
    assert not score(hidden, answer("creep")).grouped


def test_nothing_an_unknown_and_a_poor_protocol_are_asked_for_by_the_verdict():
    assert grade(score(truth(), answer())) == (True, True)
    assert grade(score(truth(), answer("creep"))) == (False, False)
    ripple = {"kind": "periodic"}
    hidden = truth(unknown="screw_ripple")
    assert grade(score(hidden, answer(verdict="unknown_effect", pattern=ripple))) == (True, True)
    assert grade(score(hidden, answer(verdict="unknown_effect", pattern={"kind": "local"}))) == (True, False)
    assert grade(score(hidden, answer("creep"))) == (False, False)
    poor, pair = truth("viscous_damping", blunt=True), [("coulomb_friction", "viscous_damping")]
    speed = {"vary": ["speed"], "text": "repeat"}
    assert grade(score(poor, answer("coulomb_friction", groups=pair, next_experiment=speed))) == (True, True)
    assert grade(score(poor, answer("coulomb_friction", groups=pair, next_experiment=None))) == (True, False)
    assert grade(score(poor, answer("viscous_damping"))) == (False, False)


def test_a_refusal_is_no_answer():
    refused = answer(verdict="unknown_effect", rmse_N=None)
    assert grade(score(truth("creep"), refused)) == (False, False)
    assert score(truth("creep"), refused).named == ("refused",)
    assert grade(score(truth(unknown="screw_ripple"), refused)) == (False, False)


def test_the_error_removed_is_that_of_the_squares_above_the_noise():
    # base 25, noise 9, after 11.56 N²: 1 − 2.56 / 16
    assert score(truth("creep"), answer("creep", rmse_after_N=3.4)).removed == pytest.approx(0.84)
    assert score(truth("creep"), answer("creep", rmse_after_N=2.9)).removed == 1.0
    assert score(truth("creep"), answer("creep")).removed is None
    assert score(truth(), answer(rmse_after_N=3.0)).removed is None


def test_confusion_pairs_what_is_hidden_with_what_was_named_in_its_place():
    cases = [
        (truth("creep"), answer("creep", "pressure_lag")),  # and one too many
        (truth("creep", "viscous_damping"), answer("pressure_lag", "force_drift")),
        (truth("coulomb_friction"), answer()),
        (truth(), answer()),
        (truth(unknown="rub"), answer("creep", verdict="unknown_effect")),
        (truth("viscous_damping"), answer("coulomb_friction", groups=[("coulomb_friction", "viscous_damping")])),
    ]
    assert confusion(score(t, a) for t, a in cases) == {
        ("creep", "creep"): 1,
        ("nothing", "rate"): 1,
        ("rate", "rate"): 2,
        ("creep", "force_drift"): 1,
        ("friction", "nothing"): 1,
        ("nothing", "nothing"): 1,
        ("unknown", "unknown"): 1,
        ("nothing", "creep"): 1,
    }


def test_a_group_makes_one_statement():
    ranking = [
        {"effect": "creep", "status": "candidate", "probability": 0.7},
        {"effect": "force_drift", "status": "candidate", "probability": 0.6},
        {"effect": "pressure_lag", "status": "candidate", "probability": 0.1},
        {"effect": "end_taper", "status": "absorbed_by_law", "probability": 0.0},
    ]
    given = answer("creep", groups=[("creep", "force_drift")], ranking=ranking)
    assert score(truth("force_drift"), given).statements == ((0.7, True), (0.1, False))


def test_tallies_count_each_kind_and_all():
    scores = [
        score(truth("creep"), answer("creep", rmse_after_N=3.4)),
        score(truth("creep"), answer("creep", "force_drift", rmse_after_N=5.0)),
        score(truth(), answer("creep")),
    ]
    first, null, both = tally(scores)
    assert (first.kind, first.n, first.right, first.exact) == ("tier1", 2, 2, 1)
    assert (first.removed_median, first.removed_worst) == pytest.approx((0.42, 0.0))
    assert (null.kind, null.right, null.removed_median) == ("null", 0, None)
    assert (both.kind, both.n, both.right, both.exact) == ("all", 3, 2, 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A set of three records."""
    path = tmp_path_factory.mktemp("set")
    write_challenge(str(path), 3, 7, "null")
    return path


@pytest.fixture
def lines(folder, tmp_path):
    def write(*answers):
        path = tmp_path / "mine.jsonl"
        path.write_text("\n".join(a if isinstance(a, str) else json.dumps(a) for a in answers) + "\n\n")
        return path

    return write


def cases(*verdicts):
    return [{"case": f"c{k:03d}", "verdict": v, "selected": []} for k, v in enumerate(verdicts)]


def test_a_person_s_answers_are_scored(folder, lines):
    mine = cases("adequate", "unknown_effect", "adequate")
    mine[2] = {"record": "somewhere/c002/record.csv", "verdict": "adequate"}
    found = challenge.score_answers(folder, lines(*mine))
    assert [s.right for s in found.scores] == [True, False, True]
    assert found.seconds is None and found.reliability.n == 0


@pytest.mark.parametrize(
    ("bad", "told"),
    [
        ("no json", "line 2: no JSON"),
        ("[1]", "line 2: expected an object"),
        ({"case": "c001", "verdict": "maybe"}, "verdict 'maybe'"),
        ({"case": "c009", "verdict": "adequate"}, "case 'c009'; expected one of the set, such as c000"),
        ({"case": "c000", "verdict": "adequate"}, "c000 is answered twice"),
        ({"case": "c001", "verdict": "missing_effect", "selected": ["colomb"]}, "selected 'colomb'"),
        ({"case": "c001", "verdict": "missing_effect", "selected": "creep"}, "expected a list"),
    ],
)
def test_a_line_that_is_no_answer_is_refused_by_its_number(folder, lines, bad, told):
    with pytest.raises(DataError) as caught:
        challenge.score_answers(folder, lines(cases("adequate")[0], bad))
    assert told in str(caught.value) and "line 2" in str(caught.value)


def test_the_envelope_stays_closed_until_every_case_is_answered(folder, lines, monkeypatch):
    monkeypatch.setattr(challenge, "open_envelope", lambda *_: pytest.fail("opened"))
    with pytest.raises(DataError, match="no answer to c001, c002; the envelope stays closed"):
        challenge.score_answers(folder, lines(*cases("adequate")))


def test_the_program_answers_without_the_truth(folder, tmp_path, monkeypatch):
    """All that it is told is case and law; truth.json is not even there."""
    (tmp_path / "questions.json").write_text((folder / "questions.json").read_text())
    told = []
    monkeypatch.setattr(
        challenge, "answer_case", lambda _, case, law: {"verdict": "adequate", "case": case, "law": law}
    )
    with heard(lambda stage: told.append((stage.done, stage.of))):
        given = challenge.answer_all(tmp_path, Executor())
    assert list(given) == ["c000", "c001", "c002"] and told == [(0, 3), (1, 3), (2, 3), (3, 3)]
    with pytest.raises(DataError, match=r"truth\.json.*expected a set"):
        challenge.open_envelope(tmp_path, given, 1.0)
    asked = json.loads((folder / "questions.json").read_text())
    assert all(set(one) == {"case", "law"} for one in asked)


def test_a_case_whose_worker_is_killed_is_a_wrong_answer(folder, monkeypatch):
    monkeypatch.setattr(Executor, "in_order", lambda self, work, tasks, what: iter([WorkerLost(2)] * len(tasks)))
    given = challenge.answer_all(folder)
    assert list(given) == ["c000", "c001", "c002"] and "killed 2 times" in given["c002"]["error"]
    assert not any(one.right for one in challenge.open_envelope(folder, given, 1.0).scores)


def test_a_set_is_never_written_over_another(folder):
    before = (folder / "truth.json").read_bytes()
    with pytest.raises(UsageError, match="holds a set already"):
        challenge.sit_challenge(folder, 2, 1)
    assert (folder / "truth.json").read_bytes() == before


def test_a_diagnosis_that_breaks_down_is_a_wrong_answer(tmp_path):
    write_challenge(str(tmp_path), 1, 7, "null")
    (tmp_path / "c000" / "record.csv").write_text("time_s,force_N\n0,1\n")
    given = challenge.answer_all(tmp_path, Executor())
    assert given["c000"]["verdict"] == "none" and "record.csv" in given["c000"]["error"]
    (one,) = challenge.open_envelope(tmp_path, given, 1.0).scores
    assert not one.right


def test_the_form_that_is_hidden_is_left_out_though_rows_are_lost(tmp_path):
    hidden = make_record(Plan(7, secrets=(Secret("coulomb_friction"),), fault="spikes"))
    write_case(tmp_path, hidden)
    assert len(read_record(tmp_path / "record.csv")) < len(hidden.added)
    assert "coulomb_friction:smooth" in forms_left_out(tmp_path, hidden)
