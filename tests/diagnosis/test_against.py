"""Two records beside each other."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.diagnosis.against import (
    EffectDifference,
    ParameterDifference,
    _between,
    _holm,
    _missing_in,
    against,
)
from pam_ident.records import build_record, read_record, thinned
from pam_ident.records.record import rebuilt
from pam_ident.tasks.diagnose import diagnose_record
from pam_ident.tasks.setup import Setup

SETUP = Setup("exponential_law")


@pytest.fixture(scope="module")
def found():
    """Nothing hidden (A) against a friction (B), in the same muscle."""
    a, b = (thinned(read_record(name), 1500) for name in ("nothing_hidden", "hidden_effect"))
    return against(diagnose_record(a, SETUP), diagnose_record(b, SETUP))


def test_what_was_put_in_is_what_differs(found):
    assert [(one.effect, one.where) for one in found.effects] == [("pressure_friction", "b")]
    assert found.effects[0].a < 0.5 < found.effects[0].b
    apart = {one.name for one in found.parameters if one.differs}
    assert apart and all(name.startswith("pressure_friction.") for name in apart), "the law is the same muscle's"
    for one in found.parameters:
        assert one.difference == one.b - one.a
        assert math.isnan(one.low) or one.low < one.difference < one.high
    assert "pressure_friction" in found.sentence and "direction of motion" in found.sentence


def test_a_muscle_that_pulls_less_all_over_is_said_to(found):
    one = found.a.base.record
    weak = replace(one, name="weak", force=0.94 * one.force)
    told = against(found.a, diagnose_record(weak, SETUP))
    assert told.force.share == pytest.approx(-0.06, abs=1e-3) and told.force.explained > 0.99
    assert "of its squares as a force that is 6 % less all over" in told.sentence


def test_parameters_of_a_free_form_draw_a_curve_and_are_not_compared(found):
    free = replace(found.b, labels=("pressure_friction:free",))
    names = {each.name for each in against(found.a, free).parameters}
    assert names == {each.name for each in found.a.base.estimates}


def test_records_of_one_name_are_told_by_their_muscles(found):
    worn = rebuilt(found.b.base.record, replace(found.b.base.record.specimen, name="worn"))
    b = replace(found.b, base=replace(found.b.base, record=worn))
    assert against(found.b, b).names == (found.b.base.record.specimen.name, "worn")


def test_what_one_record_cannot_tell_from_the_others_name_is_the_same(found):
    b = found.b
    damped = ("viscous_damping",)
    blunt = replace(b, selected=damped, labels=damped, groups=(("viscous_damping", "pressure_friction"),))
    for one in (against(blunt, b), against(b, blunt)):
        assert [(each.effect, each.where) for each in one.effects] == [("pressure_friction", "both")]
        assert [each.model.effect_names for each in one.fits] == [["pressure_friction"]] * 2
    surely = against(replace(blunt, groups=()), b)
    assert [(each.effect, each.where) for each in surely.effects] == [
        ("viscous_damping", "a"),
        ("pressure_friction", "b"),
    ]


def test_what_a_record_cannot_tell_is_said_beside_the_name(found):
    unsure = replace(found.b, groups=(("pressure_friction", "coulomb_friction"),))
    for a, b, who in ((found.a, unsure, "hidden_effect"), (unsure, unsure, "both")):
        told = against(a, b).sentence
        assert f"Missing in {who}" in told and "(coulomb_friction)" in told, told
    assert "coulomb_friction" not in against(unsure, found.b).sentence, "the other record tells"


def test_the_force_differs_by_the_friction_and_not_on_average(found):
    force = found.force
    assert force.low < force.mean < force.high and abs(force.mean) < 1.0 < force.rms < abs(force.largest)
    friction = found.b.base.rmse**2 - found.b.best.rmse**2
    assert force.rms == pytest.approx(math.sqrt(friction), rel=0.15)


def test_the_sentence_says_more_and_less_in_words_and_ends_each_thought(found):
    assert _between(-0.192, -0.0165) == "95 %: 0.017 to 0.192 N less"
    assert _between(0.0165, 0.192) == "95 %: 0.017 to 0.192 N more"
    assert _between(-0.2, 0.1) == "95 %: from 0.200 N less to 0.100 N more"
    assert _between(math.nan, math.nan) == "its interval is not determined"
    thoughts = found.sentence.split(". ")
    assert len(thoughts) == 4 and all(not one[0].islower() for one in thoughts) and " -" not in found.sentence
    assert thoughts[2] == "Missing in hidden_effect alone: friction that grows with pressure (pressure_friction)"


def test_what_is_as_large_in_the_other_record_is_not_missing_in_one_alone():
    one = EffectDifference("creep", 0.84, 0.01, "a")
    alike = ParameterDifference("creep.share", "", 0.0283, 7e-4, 0.0293, 4e-4, 0.001, -6e-4, 0.0026, 0.2)
    assert _missing_in(one, ("A", "B"), [alike]) == "A alone, though about as large in B"
    for other in (replace(alike, b=2e-4), replace(alike, p=1e-6), replace(alike, name="creeping.share")):
        assert _missing_in(one, ("A", "B"), [other]) == "A alone"


@pytest.mark.long
def test_what_a_table_cannot_show_is_no_difference(found):
    """B less its friction, without time: the law's parameters are the same."""
    record, best = found.b.base.record, found.b.best
    friction = best.force - found.b.base.model.force(record.inputs, best.values)
    inputs = record.inputs
    table = build_record("table", record.specimen, inputs.pressure, inputs.contraction, record.force - friction)
    other = against(found.b, diagnose_record(table, SETUP))
    assert [(one.effect, one.a is None, one.b is None) for one in other.effects] == [("pressure_friction", False, True)]
    assert "Missing in hidden_effect, which table could not show: friction" in other.sentence
    assert {one.name for one in other.parameters} == set(found.b.base.model.names)
    assert not any(one.differs for one in other.parameters) and "follow the direction" not in other.sentence


def test_a_record_against_its_like_differs_in_nothing(found):
    same = against(found.b, found.b)
    assert not any(one.differs for one in same.parameters) and same.force.rms == 0.0
    assert [one.where for one in same.effects] == ["both"]


def test_chances_are_held_for_all_parameters_together():
    assert _holm([0.01, 0.04, math.nan, 0.03]) == pytest.approx([0.03, 0.06, math.nan, 0.06], nan_ok=True)
    draw = np.random.default_rng(3)
    wrong = sum(min(_holm(list(draw.uniform(size=8)))) < 0.05 for _ in range(2000))
    assert 0.03 < wrong / 2000 < 0.07


@pytest.mark.long
def test_the_answer_in_python(found, tmp_path):
    import pam_ident as pam
    from pam_ident.core import UsageError

    a, b = (pam.diagnose(one.base.record, "exponential_law") for one in (found.a, found.b))
    result = a.against(b)
    assert result.params.loc["pressure_friction.mu_f", "differs"] and result.follows.loc["direction", "a"] == 0.0
    assert result.effects.loc["pressure_friction", "where"] == "b" and "pulls" in repr(result)
    assert "mu_f" in result.summary() and "<table" in result._repr_html_()
    answer = json.loads(json.dumps(result.to_json(), default=float))
    assert answer["schema"] == "pam-ident/against/1" and answer["b"]["selected"] == ["pressure_friction"]
    page = result.report(tmp_path / "ab.html").read_text(encoding="utf-8")
    assert "friction that grows with pressure" in page and "B − A" in page
    with pytest.raises(UsageError, match="different models"):
        a.against(pam.diagnose(found.b.base.record, "sarosi"))
