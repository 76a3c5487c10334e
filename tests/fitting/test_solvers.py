"""Solvers agree with each other and with independent ones, keep bounds, and say when they have not converged."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit, least_squares

from pam_ident.core import Param, Specimen, UsageError
from pam_ident.core.lmfit_names import to_lmfit_name
from pam_ident.fitting import (
    LevenbergMarquardt,
    Lmfit,
    Problem,
    VariableProjection,
    covariance,
    fit,
    from_lmfit,
    lmfit_result,
)
from pam_ident.fitting.solve import solve
from pam_ident.model import Model
from pam_ident.records import build_record

X = np.linspace(0.0, 4.0, 60)
SOLVERS = [VariableProjection(), LevenbergMarquardt(), Lmfit(), Lmfit("least_squares")]


def decay(rate_bounds=(-np.inf, np.inf), size_bounds=(-np.inf, np.inf), sigma=0.05, seed=4, **options):
    """y = a exp(−k x) + c with a = 3, k = 1.3, c = 0.5, and noise."""
    y = 3.0 * np.exp(-1.3 * X) + 0.5 + sigma * np.random.default_rng(seed).standard_normal(len(X))
    linear = (Param("a", "N", "", *size_bounds, start=max(0.0, size_bounds[0])), Param("c", "N", ""))
    nonlinear = (Param("k", "1", "", *rate_bounds, start=float(np.clip(0.6, *rate_bounds)), scale=0.5),)
    ones = np.ones_like(X)
    return Problem(linear, nonlinear, lambda q: (np.column_stack([np.exp(-q["k"] * X), ones]), 0.0 * X), y, **options)


@pytest.fixture(scope="module")
def rubbing():
    """A made-up stroke test with 12 N of Coulomb friction and 1 N of noise."""
    x = np.tile(np.concatenate([np.linspace(0, 30, 60), np.linspace(30, 0, 60)]), 6)
    p = np.repeat([0.2, 0.3, 0.4], 240)
    e, sign = x / 200.0, np.tile(np.repeat([1.0, -1.0], 60), 6)
    force = 800.0 * p * (13.3 * (1 - 1.1 * e) ** 2 - 5.4) * 0.4 + 7.0 - 12.0 * sign
    force = force + 90.0 * p * np.exp(-45.0 * e) + np.random.default_rng(8).standard_normal(len(x))
    specimen = Specimen("made", 200.0, 10.0, 25.4, 1.5)
    return build_record("made", specimen, p, e, force, time=0.05 * np.arange(len(x)))


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
def test_every_solver_finds_what_curve_fit_finds(solver):
    problem = decay()

    def curve(x, a, c, k):
        return a * np.exp(-k * x) + c

    def slope(x, a, c, k):
        return np.column_stack([np.exp(-k * x), np.ones_like(x), -a * x * np.exp(-k * x)])

    expected, theirs = curve_fit(curve, X, problem.target, [1, 0, 1], jac=slope, ftol=1e-15, xtol=1e-15)
    found = solver.solve(problem)
    assert found.converged
    np.testing.assert_allclose([found.values[n] for n in ("a", "c", "k")], expected, rtol=1e-6)
    ours = covariance(problem.jacobian(found.values), problem.residual(found.values)).matrix
    np.testing.assert_allclose(ours, theirs, rtol=1e-5)


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
@pytest.mark.parametrize(
    ("rate", "size"),
    [
        ((1.5, 9.0), (-9.0, 9.0)),
        pytest.param((0.1, 1.1), (0.0, np.inf), marks=pytest.mark.long),
        pytest.param((0.1, 9.0), (-np.inf, 2.0), marks=pytest.mark.long),
    ],
)
def test_every_solver_keeps_bounds_and_is_best_within_them(solver, rate, size):
    problem = decay(rate, size)
    limits = ([size[0], -np.inf, rate[0]], [size[1], np.inf, rate[1]])
    inside = [np.clip(1.0, *size), 0.0, np.clip(1.0, rate[0] + 0.1, rate[1] - 0.1)]

    def residual(v):
        return v[0] * np.exp(-v[2] * X) + v[1] - problem.target

    expected = least_squares(residual, inside, bounds=limits, ftol=1e-15, xtol=1e-15, gtol=1e-15)
    values = solver.solve(problem).values
    assert rate[0] <= values["k"] <= rate[1] and size[0] <= values["a"] <= size[1]
    assert 0.5 * np.sum(problem.residual(values) ** 2) == pytest.approx(expected.cost, rel=1e-6)


def test_the_projected_jacobian_has_the_exact_gradient():
    problem = decay()
    q, h = np.array([0.9]), 1e-6
    trial = problem.at(q)
    up, down = (problem.at(q + s).cost for s in (h, -h))
    assert 2.0 * (trial.jacobian.T @ trial.residual)[0] == pytest.approx((up - down) / (2 * h), rel=1e-6)
    np.testing.assert_allclose(problem.residual(trial.values), trial.residual, rtol=1e-12, atol=1e-15)


def test_the_jacobian_is_the_derivative_by_hand():
    problem, v = decay(), {"a": 2.0, "c": 0.1, "k": 0.7}
    by_hand = np.column_stack([np.exp(-0.7 * X), np.ones_like(X), -2.0 * X * np.exp(-0.7 * X)])
    np.testing.assert_allclose(problem.jacobian(v), by_hand, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("held", [{"c": 0.4}, {"k": 1.1}, {"a": 2.5, "k": 1.2}, {"a": 3.0, "c": 0.4, "k": 1.2}])
def test_holding_parameters_is_least_squares_over_the_others(held):
    free = [n for n in ("a", "c", "k") if n not in held]

    def residual(x):
        v = held | dict(zip(free, x, strict=True))
        return v["a"] * np.exp(-v["k"] * X) + v["c"] - problem.target

    problem = decay()
    part = problem.holding(**held)
    assert [p.name for p in part.params] == free
    found = VariableProjection().solve(part)
    if not free:
        assert found.values == {}
        np.testing.assert_allclose(part.residual({}), residual([]))
        return
    expected = least_squares(residual, [1.0] * len(free), ftol=1e-15, xtol=1e-15, gtol=1e-15).x
    np.testing.assert_allclose([found.values[n] for n in free], expected, rtol=1e-6)


def test_holding_what_is_not_there_is_refused():
    with pytest.raises(UsageError, match="cannot hold q; the free parameters are a, c, k"):
        decay().holding(q=1.0)


def test_grids_are_all_tried_and_a_named_start_only():
    tried = []

    def design(q):
        tried.append(q["k"])
        return np.exp(-q["k"] * X)[:, None], 0.0 * X

    problem = Problem((Param("a", "N", ""),), (Param("k", "1", "", start=1.0, grid=(0.2, 1.0, 5.0)),), design, 2 * X)
    problem.starts(24)
    assert tried == [0.2, 1.0, 5.0]
    tried.clear()
    Problem(problem.linear, problem.nonlinear, design, problem.target, {"k": 0.7}).starts(24)
    assert tried == [0.7]


def test_a_start_from_which_the_model_is_no_number_ends_without_a_fault():
    problem = decay(start={"k": -1e6})
    with np.errstate(over="ignore"):
        assert np.all(problem.at(np.array([-1e6])).residual == 1e60)


def test_noise_free_data_leave_nothing():
    found = VariableProjection().solve(decay(sigma=0.0))
    assert found.converged and found.values["k"] == pytest.approx(1.3, rel=1e-10)


def test_levenberg_marquardt_says_that_its_steps_ran_out():
    found = LevenbergMarquardt(steps=2).solve(decay())
    assert not found.converged and "maximum number of steps" in found.message


def test_a_misspelt_method_of_lmfit_is_refused():
    with pytest.raises(UsageError, match=r"lmfit has no method 'leastsqs'; it has .*leastsq"):
        Lmfit("leastsqs")


@pytest.mark.parametrize("solver", [LevenbergMarquardt(), Lmfit()], ids=repr)
def test_solvers_of_other_makes_fit_a_model(rubbing, solver):
    model = Model.build("modified_chou_hannaford", ("coulomb_friction",))
    ours = fit(model, rubbing).values
    found = solve(model, rubbing.inputs, rubbing.force, lambda m: m, solver=solver)
    assert found.converged
    np.testing.assert_allclose([found.values[n] for n in ours], list(ours.values()), rtol=1e-6)


def test_a_held_parameter_of_a_model_stays(rubbing):
    model = Model.build("modified_chou_hannaford", ("series_compliance",))
    held = {"k2": 5.0, "series_compliance.compliance": 3.0}
    found = solve(model, rubbing.inputs, rubbing.force, lambda m: m, held=held)
    assert {name: found.values[name] for name in held} == held
    names = ["k0", "k1"]

    def residual(x):
        return model.force(rubbing.inputs, held | dict(zip(names, x, strict=True))) - rubbing.force

    expected = least_squares(residual, [1.0, 1.0], ftol=1e-15, xtol=1e-15, gtol=1e-15).x
    np.testing.assert_allclose([found.values[n] for n in names], expected, rtol=1e-5)


@pytest.mark.parametrize("law", ["exponential_law", "modified_chou_hannaford"])
def test_lmfit_reaches_the_same_parameters_and_back(rubbing, law):
    model = Model.build(law, ("coulomb_friction",))
    ours = fit(model, rubbing)
    bridge, parameters = model.to_lmfit(rubbing.inputs)
    assert parameters["coulomb_friction__F_c"].min == 0.0
    options = {"jac": "3-point", "ftol": 1e-15, "xtol": 1e-12}
    result = bridge.fit(rubbing.force, parameters, inputs=rubbing.inputs, method="least_squares", fit_kws=options)
    values = from_lmfit(result)
    assert set(values) == set(ours.values)
    for name, value in values.items():
        assert value == pytest.approx(ours.values[name], rel=1e-6), name


def test_a_fit_reports_and_profiles_through_lmfit(rubbing):
    model = Model.build("modified_chou_hannaford", ("coulomb_friction",))
    rows = rubbing.inputs.direction > 0
    ours = fit(Model.build("modified_chou_hannaford"), rubbing, rows, white=True)
    result = lmfit_result(ours)
    assert result.ndata == rows.sum() and "k1" in result.fit_report()
    for one in ours.estimates:
        assert result.params[one.name].stderr == pytest.approx(one.stderr, rel=1e-3)
    whole = fit(model, rubbing, white=True)
    limits = lmfit_result(whole).conf_interval(p_names=["coulomb_friction__F_c"], sigmas=[1])
    low, middle, high = (value for _, value in limits["coulomb_friction__F_c"])
    error = next(e.stderr for e in whole.estimates if e.name == "coulomb_friction.F_c")
    assert (middle - low, high - middle) == pytest.approx((error, error), rel=0.02)


def test_what_stands_at_a_bound_is_fixed_in_lmfit(rubbing):
    backwards = replace(rubbing, force=rubbing.force + 24.0 * rubbing.inputs.direction)
    ours = fit(Model.build("modified_chou_hannaford", ("coulomb_friction",)), backwards, white=True)
    result = lmfit_result(ours)
    assert not result.params["coulomb_friction__F_c"].vary
    assert result.params["k1"].stderr == pytest.approx(
        next(e.stderr for e in ours.estimates if e.name == "k1"), rel=0.01
    )


def test_a_name_that_could_not_come_back_is_refused():
    with pytest.raises(UsageError, match="a__b"):
        to_lmfit_name("a__b")
