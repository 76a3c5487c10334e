"""Without a law: the one that predicts held-out data best, the simplest of those that do as well, and it says why."""

import numpy as np
import pytest

from pam_ident.core import FitError, Specimen, UsageError
from pam_ident.laws import catalogue
from pam_ident.records import build_record, read_record
from pam_ident.tasks.law_choice import choose_for_all, choose_law, settle
from pam_ident.tasks.setup import AUTO, Setup

MUSCLE = Specimen("made", 200.0, 10.0, 25.4)


def made(law, values, noise=1.0, pressures=(0.2, 0.3, 0.4, 0.5)):
    rng = np.random.default_rng(7)
    there = np.linspace(0.0, 0.12, 40)
    e = np.tile(np.r_[there, there[::-1]], 3 * len(pressures))
    p = np.repeat(pressures, 240)
    force = catalogue()[law].force(p, e, MUSCLE, values)
    time = 0.1 * np.arange(len(e)) + 50.0 * np.repeat(np.arange(len(pressures)), 240)
    return build_record("made", MUSCLE, p, e, force + rng.normal(0.0, noise, len(e)), time=time)


TRUE = {
    "exponential_law": {"a0": -190.0, "a1": 2400.0, "b0": 900.0, "b1": 5500.0, "c0": 20.0, "c1": 690.0, "mu": 45.0},
    "modified_chou_hannaford": {"k0": 0.8, "k1": 1.1, "k2": -30.0},
    "polynomial": {"a0": 3000, "a1": -16000, "a2": 46000, "b0": -187, "b1": -2700, "b2": 23000, "b3": -1e5},
}


@pytest.mark.parametrize("law", TRUE)
def test_the_law_that_made_the_record_is_taken(law):
    choice = choose_law(made(law, TRUE[law]), Setup(AUTO))
    assert choice.law == law and f" ({law}, {len(TRUE[law])} parameters) errs by 0.9" in choice.why
    assert {trial.law for trial in choice.trials} == set(catalogue())
    errors = [trial.heldout_rmse for trial in choice.trials if not np.isnan(trial.heldout_rmse)]
    assert errors == sorted(errors)


def test_of_laws_that_do_as_well_the_one_with_the_fewest_parameters_is_taken():
    choice = choose_law(made("modified_chou_hannaford", TRUE["modified_chou_hannaford"], noise=20.0), Setup(AUTO))
    assert choice.law == "modified_chou_hannaford"


def test_a_law_that_was_named_stays():
    record = read_record("dmsp20_300")
    assert settle(record, Setup("sarosi")) == (Setup("sarosi"), None)
    chosen, choice = settle(record, Setup(AUTO, ("force_bias",)))
    assert chosen.law == choice.law and chosen.effects == ("force_bias",)


def test_at_one_pressure_a_law_counts_without_the_parameters_that_are_held():
    choice = choose_law(made("exponential_law", TRUE["exponential_law"], pressures=(0.3,)), Setup(AUTO))
    taken = next(trial for trial in choice.trials if trial.law == choice.law)
    assert taken.parameters == 4 and not taken.problem and taken.heldout_rmse < 1.1


def test_names_are_checked_before_a_record_is_read():
    with pytest.raises(UsageError, match="did you mean creep"):
        Setup(AUTO, ("crep",)).check()


def test_a_record_that_no_law_fits_says_why():
    record = read_record("dmsp20_300")
    with pytest.raises(FitError, match="no law can be fitted"):
        choose_law(record, Setup(AUTO, ("viscous_damping",)))


def test_one_law_is_chosen_for_several_records():
    records = [made("exponential_law", TRUE["exponential_law"], noise) for noise in (1.0, 2.0)]
    choice = choose_for_all(records, Setup(AUTO))
    assert choice.law == "exponential_law" and "of 2 records" in choice.why
    alone = [choose_law(one, Setup(AUTO)).trials[0].heldout_rmse for one in records]
    assert choice.trials[0].heldout_rmse == pytest.approx(np.sqrt(alone[0] * alone[1]))
