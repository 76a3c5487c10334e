"""What nature does not allow: no name rests on it, and every answer says so."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pam_ident.core import Param, Specimen
from pam_ident.core.param import Range
from pam_ident.diagnosis import climb, confirmed, diagnose
from pam_ident.diagnosis.confirmed import _as_nature_allows, allowed_by_nature
from pam_ident.diagnosis.ladder import _alive
from pam_ident.diagnosis.selection import FittedSet
from pam_ident.effects import catalogue
from pam_ident.fitting import fit
from pam_ident.fitting.fit import Estimate
from pam_ident.laws import listed
from pam_ident.model import Model, as_term
from pam_ident.records import build_record
from pam_ident.schema.diagnosis import diagnosis_json
from pam_ident.schema.fit import parameters
from pam_ident.tasks.gate import warnings_of

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 1.5)
LAW = Model.build("chou_hannaford")
FORMS = [form for effect in catalogue().values() for form in effect.forms]
RANGED = [p for one in (*FORMS, *listed()) for p in one.params if p.range is not None]


def record_with(bias):
    """A table of the ideal braid, a bias of the load cell in N, and noise of 2 N."""
    e, p = (grid.ravel() for grid in np.meshgrid(np.linspace(0.0, 0.2, 11), np.linspace(0.1, 0.6, 6)))
    noise = 2.0 * np.random.default_rng(5).standard_normal(len(e))
    return build_record("t", MUSCLE, p, e, MUSCLE.ideal_force(p, e) + bias + noise)


@pytest.mark.parametrize("p", RANGED, ids=lambda p: p.name)
def test_a_range_has_a_source_and_lies_in_the_bounds(p):
    assert p.range.source and p.lower <= p.range.low < p.range.high <= p.upper


@pytest.mark.parametrize(("low", "high", "possible"), [(-9, -3, False), (-3, 1, True), (7, 9, False), (4, 9, True)])
def test_a_value_is_impossible_when_its_whole_interval_is(low, high, possible):
    one = Estimate("a", "N", "", (low + high) / 2, 1.0, False, True, low, high, range=Range(-2.0, 5.0, "this test"))
    assert one.possible is possible
    assert replace(one, range=None).possible is None
    assert replace(one, low=np.nan, high=np.nan).possible is None
    assert replace(one, low=np.nan, high=np.nan, at_bound=True, value=5.5).possible is False


def test_a_possible_bias_is_named():
    found = diagnose(LAW, record_with(-30.0))
    assert found.verdict == "missing_effect" and "force_bias" in found.selected and not found.best.impossible


def test_an_impossible_bias_is_not_named_and_the_answer_says_why():
    found = diagnose(LAW, record_with(-160.0), only=("force_bias",))
    assert found.verdict == "unknown_effect" and found.selected == ()
    assert "F_b = -160 N of bias of the load cell is impossible: -100 to 100 N" in found.sentence
    assert found.pattern.share > 0.9 and found.best.model == LAW
    assert diagnosis_json("r", found)["ranking"][0]["probability"] == 0.0


def test_values_beyond_nature_are_sought_within_it_before_they_are_ruled_out():
    t = np.arange(2000.0)
    p, e = 0.2 + 0.1 * np.floor(t / 667.0), 0.1 - 0.1 * np.cos(2.0 * np.pi * t / 80.0)
    swing = -5.8 * np.sin(2.0 * np.pi * t / 20700.0) - 21.6 * (1.0 - np.cos(2.0 * np.pi * t / 20700.0))
    force = MUSCLE.ideal_force(p, e) + swing + np.random.default_rng(1).standard_normal(len(t))
    best = fit(Model.build("chou_hannaford", ["force_drift:swinging"]), build_record("t", MUSCLE, p, e, force, time=t))
    ends = {"force_drift.F_sin": 5.0, "force_drift.F_cos": 10.0}  # of a swing longer than the test only the bend shows
    wrong = [
        replace(one, range=Range(-ends[one.name], ends[one.name], "this test"))
        for one in best.estimates
        if one.name in ends
    ]
    inside = _as_nature_allows(best, wrong)
    assert all(abs(best.values[name]) > end >= abs(inside.values[name]) for name, end in ends.items())
    assert inside.rmse == pytest.approx(best.rmse, rel=1e-3) and 0.0 < abs(inside.values["force_drift.F_sin"]) < 5.0


def test_a_model_with_an_impossible_value_of_its_own_is_never_adequate():
    found = climb(LAW.adding(Model.build("chou_hannaford", ["force_bias"]).terms[0]), record_with(-160.0))
    assert found.verdict == "unknown_effect" and "is impossible" in found.last.sentence
    last = found.rungs[0].fit
    assert [doubt.code for doubt in warnings_of(last) if not doubt.grave] == ["impossible_parameter"]
    assert parameters(last.estimates)["force_bias.F_b"]["possible"] is False


@pytest.mark.parametrize("law", ["exponential_law", "sarosi"])
def test_a_peak_that_no_muscle_has_is_impossible(law):
    e, p = (grid.ravel() for grid in np.meshgrid(np.linspace(0.08, 0.2, 121), np.linspace(0.1, 0.6, 6)))
    bump = (30.0 + 100.0 * p) * np.exp(-800.0 * (e - 0.08))  # 1e29 N at rest length
    force = 3000.0 * p - 9000.0 * p * e + bump + np.random.default_rng(5).standard_normal(len(e))
    codes = {doubt.code for doubt in warnings_of(fit(Model.build(law), build_record("t", MUSCLE, p, e, force)))}
    assert "impossible_parameter" in codes


def test_what_an_effect_makes_is_its_force():
    one = fit(Model.build("chou_hannaford", ["force_bias"]), record_with(-30.0))
    assert one.shares == pytest.approx({"force_bias": abs(one.values["force_bias.F_b"])})


def test_an_effect_that_has_become_nothing_is_taken_out_but_not_what_was_asked_for():
    model = Model.build("chou_hannaford", ["force_bias", "bladder_elasticity"])
    one = fit(model, record_with(-30.0), held={"bladder_elasticity.E": 0.0})
    assert one.shares["bladder_elasticity"] == 0.0
    assert _alive(one, LAW).model.labels == ["force_bias"]
    assert _alive(one, model) is one


def test_a_param_says_nothing_about_nature_unless_told():
    assert Param("a", "N", "").range is None


@pytest.mark.parametrize(
    ("squares", "complete", "alone"),
    [(12.0, False, False), (900.0, True, True), (900.0, True, False), (900.0, False, True)],
)
def test_another_form_stands_for_what_is_impossible_though_a_slight_name_goes(monkeypatch, squares, complete, alone):
    """One that explains as much, or alone is complete. Neither the set itself is looked at again nor another with the
    same value."""
    lag, free, creep, drift = map(as_term, ("pressure_lag", "pressure_lag:free_lagging", "creep", "force_drift"))
    kappa = Estimate(
        "pressure_lag.kappa", "1", "", 0.1, 0.01, False, True, 0.08, 0.12, range=Range(0.3, 1.7, "this test")
    )
    values = {"pressure_lag.kappa": 0.1}
    beside = () if alone else (creep, drift)
    first = FittedSet((lag, *beside), values, 10.0, 10.0)
    alike = FittedSet((lag, creep), values, 11.0, 11.0)
    other = FittedSet((free, *beside), {}, squares, squares)
    asked = []

    def possible(base, heldout, named, fitted, least):
        asked.append(fitted)
        kept = [t for t in named if t is not drift and t is not lag]
        ruled_out = {"pressure_lag": SimpleNamespace(impossible=(kappa,))} if lag in named else {}
        return SimpleNamespace(), 1.0, kept, ruled_out

    selection = SimpleNamespace(
        record=SimpleNamespace(inputs=SimpleNamespace(time=np.zeros(9))),
        noise=SimpleNamespace(too_small=0.05, whole=1.0),
        cache={1: first, 2: alike},
        weight=lambda fitted, term: 1.0,
        refit=lambda terms, start: other if free in terms else replace(other, squares=1e9),
    )
    monkeypatch.setattr(confirmed, "_possible", possible)
    monkeypatch.setattr(confirmed, "FreeModel", SimpleNamespace(of=lambda _: None))
    monkeypatch.setattr(
        confirmed, "Adequacy", lambda _, one, free: SimpleNamespace(complete=complete and one.squares == squares)
    )
    found, (_, _, named, ruled_out) = allowed_by_nature(SimpleNamespace(), 1.0, selection, first, lambda one: True)
    stands = squares < 30.0 or (complete and alone)
    assert (found is other and named == [free, *beside[:1]] and not ruled_out) is stands
    assert asked == ([first, other] if stands else [first])
