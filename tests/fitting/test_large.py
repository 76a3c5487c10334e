"""Very many samples are fitted to the same minimum as by the long way."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Inputs
from pam_ident.effects import catalogue
from pam_ident.fitting import VariableProjection, fit, readings
from pam_ident.fitting.covariance import clusters, covariance
from pam_ident.fitting.fit import BY_READINGS, pays_in_chunks
from pam_ident.fitting.readings import Readings, in_memory
from pam_ident.fitting.solve import jacobian, solve
from pam_ident.model import Model
from pam_ident.validation.check_effects import clean_record
from pam_ident.validation.effect_contract import LAW_VALUES, plausible, showing

LAWS = ["exponential_law", "modified_chou_hannaford", "polynomial", "wickramatunge_leephakpreeda"]


@pytest.mark.parametrize("name", LAWS)
def test_the_short_way_ends_where_the_long_way_ends(record, name):
    many = record(n=100_000)
    model = Model.build(name)
    short = fit(model, many, detail=False)
    long = solve(model, many.inputs, many.force, lambda m: m).values
    assert short.message == BY_READINGS
    errors = {e.name: e.stderr for e in fit(model, many, white=True).estimates}
    for key, value in long.items():
        assert short.values[key] == pytest.approx(value, rel=1e-6, abs=1e-4 * errors[key])


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
    assert pays_in_chunks(Model.build("exponential_law"), many, every)
    assert not pays_in_chunks(Model.build("exponential_law", ("creep",)), many, every)
    assert not pays_in_chunks(Model.build("chou_hannaford"), many, every)  # nothing is free
    assert not pays_in_chunks(Model.build("exponential_law"), many, many.inputs.direction > 0)
    assert not pays_in_chunks(Model.build("exponential_law"), record(n=1000), np.ones(1000, bool))


def test_an_answer_at_a_bound_or_along_a_flat_direction_is_that_of_the_long_way(record):
    many = record(n=60_000)
    pushed = replace(many, force=many.force + 3.0 * many.inputs.direction)  # friction that would have to push
    for effect, made, kinds in (("coulomb_friction", pushed, {"at_bound"}), ("force_bias", many, {"flat"})):
        model = Model.build("exponential_law", (effect,))
        short, long = fit(model, made), fit(model, made, solver=VariableProjection())
        assert short.converged and short.rmse == pytest.approx(long.rmse, rel=1e-12)
        assert kinds < {e.verdict.kind for e in short.estimates}
        for a, b in zip(short.estimates, long.estimates, strict=True):
            assert (a.name, a.at_bound, a.verdict.kind) == (b.name, b.at_bound, b.verdict.kind)
            if b.verdict.determined:
                assert a.value == pytest.approx(b.value, rel=1e-9, abs=1e-6 * b.stderr), a.name
            assert a.stderr == pytest.approx(b.stderr, rel=1e-4, nan_ok=True), a.name


def test_some_rows_and_held_parameters_are_fitted_as_by_the_solver(record, small):
    many, model = record(n=10_000), Model.build("exponential_law", ("mullins_softening:recovering",))
    how = {"rows": many.inputs.direction > 0, "held": {"mu": 44.0, "mullins_softening.n_0": 1.5}}
    short, long = fit(model, many, **how), fit(model, many, solver=VariableProjection(), **how)
    assert short.message == BY_READINGS and short.values["mu"] == 44.0
    for a, b in zip(short.estimates, long.estimates, strict=True):
        assert a.verdict.kind == b.verdict.kind
        assert a.value == pytest.approx(b.value, rel=1e-9, abs=1e-5 * np.nan_to_num(b.stderr)), a.name


FORMS = [f"{effect.name}:{form.name}" for effect in catalogue().values() for form in effect.forms]
PAST = ["force_drift", "thermal_softening", "mullins_softening:recovering", "mullins_softening:whole_test"]
PAST += ["mullins_softening:pseudo_elastic", "coulomb_friction:relaxing"]


@pytest.fixture
def small(monkeypatch):
    """What is large begins at a thousand samples, of which each reading takes many chunks."""
    for name, size in {"FROM": 1_000, "SAMPLES": (500, 2_000), "CHUNK": 97}.items():
        monkeypatch.setattr(readings, name, size)


@pytest.fixture(scope="module")
def plain():
    return clean_record(per_move=60, per_hold=20)


@pytest.mark.long
@pytest.mark.parametrize("label", FORMS)
def test_what_is_read_in_chunks_is_the_same_as_read_whole(label, plain, small):
    """The gradient of each form that a large fit takes, chunk by chunk, against the whole Jacobian's."""
    model = Model.build("exponential_law", (label,))
    ((effect, form),) = [(term.effect, term.form) for term in model.terms]
    made = showing(plain, form)
    if not pays_in_chunks(model, made, np.ones(len(made), bool)):
        assert form.remembers or form.uses_force
        return
    values = LAW_VALUES | plausible(effect, form)
    left = 5.0 * np.random.default_rng(3).standard_normal(len(made))
    made = replace(made, force=model.force(made.inputs, values) + left)
    params = model.bounded(made.inputs)
    every = Readings(model, in_memory(made, np.arange(len(made)), first=True), {}, params)
    whole = jacobian(model, made.inputs, values, made.force)
    sizes = np.linalg.norm(whole, axis=0)
    for reading in (every, replace(every, exact=True)):
        found = reading.at(np.array([values[p.name] for p in params])).sums
        assert found.squares == pytest.approx(float(left @ left), rel=1e-9)
        slopes = found.triangle[:, :-1]
        np.testing.assert_allclose(slopes.T @ found.triangle[:, -1] / sizes, -whole.T @ left / sizes, atol=1e-4)
        scaled = slopes / sizes
        np.testing.assert_allclose(scaled.T @ scaled, whole.T @ whole / np.outer(sizes, sizes), atol=1e-4)


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
    assert pays_in_chunks(plain, many, every)
    assert not pays_in_chunks(silent, many, every)
