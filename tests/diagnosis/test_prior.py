"""What is known of a rig beforehand: prior odds of effects."""

import math

import pytest

from pam_ident.core import UsageError
from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.search import TEMPER, Penalty
from pam_ident.effects import get_effect
from pam_ident.model import Model, Term
from pam_ident.records import read_record, thinned
from pam_ident.records.datasets import dataset_record
from pam_ident.tasks.setup import Setup


def test_odds_of_ten_are_worth_their_logarithm_as_a_probability_counts_it():
    creep, _ = get_effect("creep")
    term = Term(creep, creep.forms[0])
    plain, likely = Penalty(8.0, 20.0, 5.0), Penalty(8.0, 20.0, 5.0, {"creep": 10.0, "force_drift": 0.1})
    assert plain.total([term]) - likely.total([term]) == pytest.approx(2.0 * TEMPER * math.log(10.0))


@pytest.mark.long
def test_odds_in_a_file_reach_the_diagnosis(tmp_path):
    file = tmp_path / "prior.toml"
    file.write_text("pressure_friction = 1e-300\n")
    record = thinned(read_record(dataset_record("hidden_effect")), 500)
    model = Model.build("exponential_law")
    assert diagnose(model, record).selected == ("pressure_friction",)
    assert (
        "pressure_friction" not in diagnose(model, record, odds=Setup("exponential_law", prior=str(file)).odds).selected
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("creep = -1", "prior odds of creep are -1"),
        ("creep = inf", "prior odds of creep are inf"),
        ("creep = 'often'", "creep is 'often'; expected a number"),
        ("[creep", "expected lines such as"),
        ("kreep = 2", "did you mean creep"),
    ],
)
def test_odds_that_are_none_are_told(tmp_path, text, message):
    file = tmp_path / "prior.toml"
    file.write_text(text)
    record = thinned(read_record(dataset_record("nothing_hidden")), 300)
    with pytest.raises(UsageError, match=message):
        diagnose(Model.build("exponential_law"), record, odds=Setup("exponential_law", prior=str(file)).odds)
