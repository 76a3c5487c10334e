"""An answer beside the free model: what no file foresaw is unknown, whatever else the catalogue could make of it."""

from dataclasses import replace

import pytest

from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.follows import DRIVERS, Following
from pam_ident.effects import catalogue
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record
from pam_ident.rig import Plan, Secret, make_record, write_case
from pam_ident.validation.holdout import effects_left_out, forms_left_out, kin

LONG = pytest.mark.long
EXPONENTIAL, CHOU = "exponential_law", "modified_chou_hannaford"


@pytest.fixture(scope="module")
def hidden_effect():
    return read_record(dataset_record("hidden_effect"))


def case(folder, law, name, form, seed=7, ratio=3.0):
    hidden = make_record(Plan(seed, law, (Secret(name, form, ratio),), warming=True))
    write_case(folder, hidden)
    return hidden


def test_every_candidate_says_what_it_follows():
    words = {driver.what for driver in DRIVERS}
    for effect in catalogue().values():
        assert effect.follows and set(effect.follows) <= words, effect.name


def test_only_what_the_error_follows_is_supported(hidden_effect):
    following = Following.of(fit(Model.build(EXPONENTIAL), hidden_effect))
    assert "direction" in following.needed
    assert following.supports(catalogue()["pressure_friction"].follows)
    assert not following.supports(catalogue()["thermal_softening"].follows)
    assert following.supports(()), "an effect of the user's own may follow anything"


def test_a_driver_that_no_effect_follows_is_uncovered(hidden_effect):
    following = Following.of(fit(Model.build(EXPONENTIAL), hidden_effect))
    known = list(catalogue().values())
    assert following.uncovered(known) == ()
    left = [effect for effect in known if "direction" not in effect.follows]
    assert following.uncovered(left) == ("direction",)
    assert following.uncovered([*left, replace(left[0], follows=())]) == ()


@pytest.mark.parametrize(
    ("law", "name", "form"),
    [
        (EXPONENTIAL, "viscous_damping", "thinning"),
        (CHOU, "creep", "by_force"),
        pytest.param(CHOU, "series_compliance", "textbook", marks=LONG),
        pytest.param(EXPONENTIAL, "mullins_softening", "textbook", marks=LONG),
        pytest.param(CHOU, "thermal_softening", "elastic_part", marks=LONG),
        pytest.param(EXPONENTIAL, "force_drift", "settling", marks=LONG),
    ],
)
def test_an_effect_that_the_catalogue_lacks_is_unknown_and_stands_alone(tmp_path, law, name, form):
    hidden = case(tmp_path, law, name, form)
    record = read_record(tmp_path / "record.csv")
    answer = diagnose(Model.build(law), record, without=effects_left_out(tmp_path, hidden))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert all(one.probability < 0.1 for one in answer.ranking)
    known = diagnose(Model.build(law), record)
    assert known.verdict == "missing_effect" and known.selected == (name,)


def test_a_form_that_the_catalogue_lacks_does_not_change_the_name(tmp_path):
    hidden = case(tmp_path, CHOU, "viscous_damping", "thinning")
    left = forms_left_out(tmp_path, hidden)
    assert "viscous_damping:thinning" in left and not any(label.endswith("free") for label in left)
    answer = diagnose(Model.build(CHOU), read_record(tmp_path / "record.csv"), without=left)
    assert answer.selected == ("viscous_damping",) and answer.labels[0] not in left


def test_without_and_only_take_a_form(hidden_effect):
    law = Model.build(EXPONENTIAL)
    label = "pressure_friction:contact_area"
    assert diagnose(law, hidden_effect, only=(label,)).labels == (label,)
    other = diagnose(law, hidden_effect, without=(label,))
    assert other.selected == ("pressure_friction",) and other.labels != (label,)


def test_kin_are_those_of_a_family_and_those_that_follow_the_same_but_the_map():
    assert kin("viscous_damping") == ("pressure_lag", "stribeck_friction", "viscous_damping")
    assert kin("threshold_pressure") == ("threshold_pressure",)
