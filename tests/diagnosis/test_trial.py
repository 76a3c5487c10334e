"""The selection: what it fits, gives up, and may not name together."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.diagnosis.confounding import _general, groups
from pam_ident.diagnosis.search import beam_search
from pam_ident.diagnosis.selection import Selection
from pam_ident.effects import catalogue, get_effect
from pam_ident.fitting import fit
from pam_ident.model import Model, Term
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record

EXPONENTIAL = "exponential_law"
CANDIDATES = [e for e in catalogue().values() if e.candidate]


@pytest.fixture(scope="module")
def base():
    record = read_record(dataset_record("hidden_effect"))
    return fit(Model.build(EXPONENTIAL), replace(record, inputs=record.steady), detail=False)


@pytest.fixture
def selection(base):
    return Selection(base, CANDIDATES)


def term(label):
    return Term(*get_effect(label))


def test_a_set_without_hope_is_given_up_and_fitted_when_asked_for_by_itself(selection):
    """Pressure friction is hidden; creep alone explains next to nothing."""
    found = selection.refit([term("pressure_friction")])
    given_up = selection.refit([term("creep")], best=found.criterion)
    assert given_up.beyond == found.criterion < given_up.criterion
    again = selection.refit([term("creep")], best=found.criterion - 1.0)
    assert again is given_up
    whole = selection.refit([term("creep")])
    assert whole.beyond == np.inf and whole.criterion <= given_up.criterion + 1e-6


def test_what_may_still_win_is_never_given_up(selection):
    free = selection.refit([term("pressure_friction:power")])
    other = Selection(selection.base, CANDIDATES)
    limited = other.refit([term("pressure_friction:power")], best=free.criterion + 1.0)
    assert limited.beyond == np.inf
    assert limited.criterion == pytest.approx(free.criterion, rel=1e-6)


def test_of_one_kin_a_set_holds_one(selection):
    found = beam_search(selection.data, selection.penalty, 3)
    assert found
    for choice in found:
        names = {selection.data.regressors[a].effect for a in choice.regressors}
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
    selection = Selection(fit(law, one_way, detail=False), CANDIDATES)
    assert selection.excluded["length_offset"][0] == "absorbed_by_law"
    assert "length_offset" in {e.name for e in selection.rivals}
    fitted = selection.refit([term("pressure_friction")])
    rival = selection.refit([term("length_offset")])
    assert rival.criterion < fitted.criterion
    assert any("length_offset" in group for group in groups(selection, fitted))


@pytest.mark.long
@pytest.mark.parametrize(("gain", "told"), [(0.0, False), (15.0, True)])
def test_a_dip_that_the_record_does_not_need_is_no_stribeck_frictions_alone(base, gain, told):
    """A friction of 20 N, with and without what it gains towards rest."""
    inputs, rubs = base.record.inputs, term("stribeck_friction")
    speed = np.abs(inputs.velocity)
    friction = -(20.0 + gain * np.exp(-((speed / 6.0) ** 2))) * inputs.direction
    noise = np.random.default_rng(12).standard_normal(len(inputs))
    record = replace(base.record, force=base.force + friction + noise)
    selection = Selection(fit(base.model, record, detail=False), CANDIDATES)
    fitted = selection.refit([rubs])
    assert (_general(selection, fitted, rubs) == ["coulomb_friction"]) is not told
    assert all("plain" not in label for key in selection.cache for label in key), "the answer's odds do not hold it"
