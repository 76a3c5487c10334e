"""Very many samples are fitted to the same minimum as by the long way."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Inputs
from pam_ident.effects import catalogue
from pam_ident.fitting import VariableProjection, fit, large
from pam_ident.fitting.covariance import clusters, covariance
from pam_ident.fitting.large import is_large, solve_large
from pam_ident.fitting.solve import jacobian, solve
from pam_ident.model import Model
from pam_ident.validation.effect_contract import LAW_VALUES, plausible
from pam_ident.validation.effect_record import clean_record

LAWS = ["exponential_law", "modified_chou_hannaford", "polynomial", "wickramatunge_leephakpreeda"]


@pytest.mark.parametrize("name", LAWS)
def test_the_short_way_ends_where_the_long_way_ends(record, name):
    many = record(n=100_000)
    model = Model.build(name)
    short = solve_large(model, many, {})
    long = solve(model, many.inputs, many.force, lambda m: m).values
    assert short is not None
    assert fit(model, many, detail=False).values == short[0]
    errors = {e.name: e.stderr for e in fit(model, many, white=True).estimates}
    for key, value in long.items():
        assert short[0][key] == pytest.approx(value, rel=1e-6, abs=1e-4 * errors[key])


@pytest.mark.parametrize("white", [True, False])
def test_its_errors_are_those_of_the_whole_jacobian(record, white):
    many = record(n=60_000, rho=0.7)
    model = Model.build("exponential_law")
    one = fit(model, many, white=white)
    matrix = jacobian(model, many.inputs, one.values, many.force)
    whole = covariance(matrix, one.residual, None if white else clusters(many, slice(None)))
    stderr, dof = whole.error(np.eye(7))
    # Taken a step of some standard errors before the end, where slopes differ by about as much of a parameter.
    np.testing.assert_allclose([e.stderr for e in one.estimates], stderr, rtol=5e-3)
    np.testing.assert_allclose([e.dof for e in one.estimates], dof, rtol=5e-3)


def test_what_remembers_the_past_and_what_is_short_goes_the_long_way(record):
    many = record(n=60_000)
    every = np.ones(len(many), bool)
    assert is_large(Model.build("exponential_law"), many, every)
    assert not is_large(Model.build("exponential_law", ("creep",)), many, every)
    assert not is_large(Model.build("chou_hannaford"), many, every)  # nothing is free
    assert not is_large(Model.build("exponential_law"), many, many.inputs.direction > 0)
    assert not is_large(Model.build("exponential_law"), record(n=1000), np.ones(1000, bool))


def test_an_answer_at_a_bound_or_along_a_flat_direction_goes_the_long_way(record):
    many = record(n=60_000)
    pushed = replace(many, force=many.force + 3.0 * many.inputs.direction)  # friction that would have to push
    assert solve_large(Model.build("exponential_law", ("coulomb_friction",)), pushed, {}) is None
    assert solve_large(Model.build("exponential_law", ("force_bias",)), many, {}) is None


FORMS = [f"{effect.name}:{form.name}" for effect in catalogue().values() for form in effect.forms]
PAST = ["force_drift", "thermal_softening", "mullins_softening:recovering", "mullins_softening:whole_test"]
PAST += ["mullins_softening:pseudo_elastic", "coulomb_friction:relaxing"]


@pytest.fixture
def small(monkeypatch):
    """What is large begins at a thousand samples, of which each reading takes many chunks."""
    for name, size in {"FROM": 1_000, "FIRST": 500, "SECOND": 2_000, "CHUNK": 97}.items():
        monkeypatch.setattr(large, name, size)


@pytest.mark.parametrize("label", FORMS)
def test_what_is_read_in_chunks_is_the_same_as_read_whole(label, small):
    """The gradient of each form that a large fit takes, chunk by chunk, against the whole Jacobian's."""
    made = clean_record(per_move=60, per_hold=20)
    model = Model.build("exponential_law", (label,))
    ((effect, form),) = [(term.effect, term.form) for term in model.terms]
    if not is_large(model, made, np.ones(len(made), bool)):
        assert form.remembers or form.uses_force
        return
    values = LAW_VALUES | plausible(effect, form)
    left = 5.0 * np.random.default_rng(3).standard_normal(len(made))
    made = replace(made, force=model.force(made.inputs, values) + left)
    reading = large._Reading(model, made.inputs, made.force, model.bounded(made.inputs))
    found = reading.sums(np.array([values[p.name] for p in reading.params]))
    whole = jacobian(model, made.inputs, values, made.force)
    sizes = np.linalg.norm(whole, axis=0)
    assert found.squares == pytest.approx(float(left @ left), rel=1e-9)
    score = reading.score(np.array([values[p.name] for p in reading.params]))
    np.testing.assert_allclose(score / sizes, whole.T @ left / sizes, atol=1e-4)
    np.testing.assert_allclose(found.gram / np.outer(sizes, sizes), whole.T @ whole / np.outer(sizes, sizes), atol=1e-4)


@pytest.mark.parametrize("label", [*PAST[:2], *(pytest.param(label, marks=pytest.mark.long) for label in PAST[2:])])
def test_a_large_record_with_a_past_is_fitted_as_by_the_solver(label, record, truth, small):
    many = record(n=10_000)
    warmed = replace(many.inputs, temperature=22.0 + 3.0 * np.sin(many.inputs.time / 300.0))
    model = Model.build("exponential_law", (label,))
    ((effect, form),) = [(term.effect, term.form) for term in model.terms]
    values = plausible(effect, form) | dict(zip(LAW_VALUES, truth, strict=True))
    many = replace(many, inputs=warmed, steady=warmed)
    many = replace(many, force=model.force(warmed, values) + np.random.default_rng(1).normal(0.0, 2.0, len(many)))
    one, other = fit(model, many), fit(model, many, solver=VariableProjection())
    assert one.rmse == pytest.approx(2.0, rel=0.02)
    assert any(e.identified and abs(e.value) > 5.0 * e.stderr for e in other.estimates if effect.name in e.name)
    for a, b in zip(one.estimates, other.estimates, strict=True):
        if b.identified:
            assert a.value == pytest.approx(b.value, abs=1e-5 * b.stderr), a.name


def test_an_own_effect_that_does_not_say_what_it_remembers_is_not_read_in_chunks(record, small):
    """As an effect file might have it, that `effects check` has never seen."""

    def columns(inputs: Inputs, shape, force):
        return np.maximum.accumulate(inputs.contraction)[:, None]

    many = record(n=10_000)
    plain = Model.build("exponential_law", ("force_bias",))
    (term,) = plain.terms
    silent = replace(plain, terms=(replace(term, form=replace(term.form, columns=columns)),))
    every = np.ones(len(many), bool)
    assert is_large(plain, many, every)
    assert not is_large(silent, many, every)
