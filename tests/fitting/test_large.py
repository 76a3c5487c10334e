"""Very many samples are fitted to the same minimum as by the long way."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.fitting import fit
from pam_ident.fitting.covariance import clusters, covariance
from pam_ident.fitting.large import is_large, solve_large
from pam_ident.fitting.solve import jacobian, solve
from pam_ident.model import Model

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
        assert short[0][key] == pytest.approx(value, rel=1e-6, abs=1e-3 * errors[key])


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
    assert not is_large(Model.build("exponential_law"), many, many.inputs.direction > 0)
    assert not is_large(Model.build("exponential_law"), record(n=1000), np.ones(1000, bool))


def test_an_answer_at_a_bound_or_along_a_flat_direction_goes_the_long_way(record):
    many = record(n=60_000)
    pushed = replace(many, force=many.force + 3.0 * many.inputs.direction)  # friction that would have to push
    assert solve_large(Model.build("exponential_law", ("coulomb_friction",)), pushed, {}) is None
    assert solve_large(Model.build("exponential_law", ("force_bias",)), many, {}) is None
