"""The court: what it fits, gives up, and may not name together."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.diagnosis.confounding import groups
from pam_ident.diagnosis.search import beam_search
from pam_ident.diagnosis.trial import Trial
from pam_ident.effects import catalogue, get_effect
from pam_ident.fitting import fit
from pam_ident.model import Model, Term
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record

EXPONENTIAL = "exponential_law"
SUSPECTS = [e for e in catalogue().values() if e.candidate]


@pytest.fixture(scope="module")
def base():
    record = read_record(dataset_record("hidden_effect"))
    return fit(Model.build(EXPONENTIAL), replace(record, inputs=record.steady), detail=False)


@pytest.fixture
def trial(base):
    return Trial(base, SUSPECTS)


def term(label):
    return Term(*get_effect(label))


def test_a_set_without_hope_is_given_up_and_fitted_when_asked_for_by_itself(trial):
    """Pressure friction is hidden; creep alone explains next to nothing."""
    found = trial.refit([term("pressure_friction")])
    given_up = trial.refit([term("creep")], best=found.cost)
    assert given_up.beyond == found.cost < given_up.cost
    again = trial.refit([term("creep")], best=found.cost - 1.0)
    assert again is given_up
    whole = trial.refit([term("creep")])
    assert whole.beyond == np.inf and whole.cost <= given_up.cost + 1e-6


def test_what_may_still_win_is_never_given_up(trial):
    free = trial.refit([term("pressure_friction:power")])
    other = Trial(trial.base, SUSPECTS)
    limited = other.refit([term("pressure_friction:power")], best=free.cost + 1.0)
    assert limited.beyond == np.inf
    assert limited.cost == pytest.approx(free.cost, rel=1e-6)


def test_of_one_kin_a_set_holds_one(trial):
    found = beam_search(trial.data, trial.price, 3)
    assert found
    for choice in found:
        names = {trial.data.atoms[a].effect for a in choice.atoms}
        assert not {"coulomb_friction", "stribeck_friction"} <= names


def test_what_the_law_nearly_follows_can_be_the_other_reading(base):
    """On one branch, friction in proportion to pressure is a law of a longer muscle."""
    record = base.record
    law = Model.build("modified_chou_hannaford")
    values = {"k0": 0.9, "k1": 1.1, "k2": 0.0}
    rows = record.inputs.direction < 0
    inputs = replace(record.inputs, contraction=record.inputs.contraction - 0.05)
    noise = np.random.default_rng(11).standard_normal(len(record))
    one_way = replace(record, force=law.force(inputs, values) + noise).take(rows)
    trial = Trial(fit(law, one_way, detail=False), SUSPECTS)
    assert trial.excluded["length_offset"][0] == "absorbed_by_law"
    assert "length_offset" in {e.name for e in trial.absorbed}
    verdict = trial.refit([term("pressure_friction")])
    rival = trial.refit([term("length_offset")])
    assert rival.cost < verdict.cost
    assert any("length_offset" in group for group in groups(trial, verdict))
