"""An effect that is named without a form is taken in the form that fits, before another gets what it leaves."""

import pytest

from pam_ident.records import read_record
from pam_ident.rig import Plan, Secret, make_record, write_case
from pam_ident.tasks.diagnose import diagnose_record
from pam_ident.tasks.forms import in_best_forms
from pam_ident.tasks.ladder import climb_ladder
from pam_ident.tasks.setup import Setup

BARE = Setup("exponential_law", ("creep",), heldout="refit")
SAID = Setup("exponential_law", ("creep:textbook",))


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """Creep with two times, of which the textbook knows one."""
    folder = tmp_path_factory.mktemp("creep")
    write_case(folder, make_record(Plan(3, secrets=(Secret("creep", "prony_2", 6.0),))))
    return read_record(folder / "record.csv")


@pytest.mark.long
def test_what_was_named_alone_is_taken_in_the_form_that_fits(record):
    model, said = in_best_forms(record, BARE)
    assert model.labels != ["creep"] and model.effect_names == ["creep"]
    found = diagnose_record(record, BARE)
    assert found.verdict == "adequate" and found.base.model == model
    assert found.sentence.startswith(said) and f"Creep and stress relaxation is taken as {model.labels[0]}" in said
    assert climb_ladder(record, BARE).rungs[0].fit.model == model


@pytest.mark.long
def test_a_form_that_was_said_is_kept(record):
    assert in_best_forms(record, SAID) == (SAID.model, "")
    assert diagnose_record(record, SAID).base.model == SAID.model
