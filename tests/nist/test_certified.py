"""Certified problems: the program's solver gets the digits, from both starts that NIST gives and from no other."""

import numpy as np
import pytest
from strd import MODELS, read_certified

from pam_ident.fitting import LevenbergMarquardt, VariableProjection, covariance
from pam_ident.validation.certified import PROBLEMS

ROUNDING = "Lanczos1"
"""Its certified residual, 9e-14 rms, is rounding of the data: ours is rounding of the arithmetic, and not the same."""
BOTH = [(name, start) for name in MODELS for start in (1, 2)]
ELSEWHERE = ("MGH17", 1)
"""From here optimistix ends in another, flat minimum: sum of squares 0.0245, certified 0.0000546."""


@pytest.mark.parametrize("name", MODELS)
def test_the_model_written_here_is_the_certified_one(nist, name):
    one = read_certified(nist / f"{name}.dat")
    values = {f"b{k}": value for k, value in enumerate(one.values, 1)}
    squares = float(np.sum(one.problem(1).residual(values) ** 2))
    sigma = np.sqrt(squares / (len(one.y) - len(one.values)))
    if name == ROUNDING:  # certified parameters have eleven digits, which is too few to leave 9e-14
        assert sigma < 1e-10
    else:
        assert sigma == pytest.approx(one.sigma, rel=1e-6)


@pytest.mark.parametrize("one", PROBLEMS, ids=lambda one: one.name)
def test_the_problems_retyped_for_the_selftest_are_nists(nist, one):
    original = read_certified(nist / f"{one.name}.dat")
    for field in ("linear", "x", "y", "starts", "values", "stderr"):
        np.testing.assert_array_equal(getattr(one, field), getattr(original, field), field)


@pytest.mark.parametrize(("name", "start"), BOTH)
def test_six_digits_of_the_parameters_and_of_their_errors(nist, name, start):
    one = read_certified(nist / f"{name}.dat")
    problem = one.problem(start)
    found = VariableProjection().solve(problem)
    assert found.converged
    assert one.digits(found.values) >= 6.0
    residual = problem.residual(found.values)
    variance = np.diag(covariance(problem.jacobian(found.values), residual).matrix)
    if name == ROUNDING:  # so only the shape of the covariance can be held against NIST's, at its residual variance
        assert np.linalg.norm(residual) < 1e-12
        variance = variance * one.sigma**2 * (len(one.y) - len(one.values)) / float(residual @ residual)
    errors = dict(zip([p.name for p in problem.params], np.sqrt(variance), strict=True))
    assert one.digits_stderr(errors) >= 6.0


@pytest.mark.parametrize(("name", "start"), BOTH)
def test_levenberg_marquardt_gets_six_digits_but_for_one_start(nist, name, start):
    one = read_certified(nist / f"{name}.dat")
    found = LevenbergMarquardt().solve(one.problem(start))
    assert found.converged
    assert (one.digits(found.values) >= 6.0) is ((name, start) != ELSEWHERE)
