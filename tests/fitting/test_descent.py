"""The descent within bounds and the small bounded least squares, beside scipy's."""

import numpy as np
import pytest
from scipy.optimize import least_squares, lsq_linear

from pam_ident.core import Param
from pam_ident.fitting import Problem
from pam_ident.fitting.descent import GIVEN_UP, descend
from pam_ident.fitting.problem import within_bounds


@pytest.mark.parametrize("seed", range(20))
def test_bounded_least_squares_are_those_of_scipy(seed):
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(40, 7)) * 10.0 ** rng.uniform(-3, 3, 7)
    target = columns @ rng.normal(size=7) + rng.normal(size=40)
    free = np.linalg.lstsq(columns, target)[0]
    lower = np.where(rng.random(7) < 0.5, free + np.abs(free) * rng.uniform(-1, 1, 7), -np.inf)
    upper = np.where(rng.random(7) < 0.5, np.fmax(free, lower) + np.abs(free) * rng.uniform(0.01, 1, 7), np.inf)
    found = within_bounds(np.linalg.qr(np.column_stack([columns, target]), mode="r"), lower, upper)
    scale = np.linalg.norm(columns, axis=0)
    other = lsq_linear(columns / scale, target, (lower * scale, upper * scale), method="bvls", tol=1e-14)
    np.testing.assert_allclose(found * scale, other.x, rtol=1e-8, atol=1e-8)


def decays(sizes, rates, y, t):
    def design(values):
        return np.exp(-np.outer(t, [values[p.name] for p in rates])), np.zeros_like(t)

    return Problem(sizes, rates, design, y)


@pytest.mark.parametrize(("top", "seed"), [(30.0, 1), (30.0, 2), (2.0, 3), (0.5, 4)])
def test_two_decays_are_found_as_scipy_finds_them_also_at_a_bound(top, seed):
    """Rates 0.3 and 3 of two decays; the second lies beyond its bound in the last two."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 10.0, 300)
    y = 2.0 * np.exp(-0.3 * t) + 3.0 * np.exp(-3.0 * t) + 0.01 * rng.normal(size=300)
    sizes = (Param("a", "1", "", -100.0, 100.0), Param("b", "1", "", -100.0, 100.0))
    rates = (
        Param("slow", "1/s", "", 0.01, 0.4, start=0.05),
        Param("fast", "1/s", "", 0.45, top, start=min(8.0, 0.49 + 0.1 * (top > 1.0))),
    )

    found, status, _ = descend(decays(sizes, rates, y, t).starts(1)[0], 1e-15, 1e-9, 200)

    def residual(x):
        return np.exp(-np.outer(t, x[2:])) @ x[:2] - y

    low, high = ([-100.0, -100.0, 0.01, 0.45], [100.0, 100.0, 0.4, top])
    begin = [1.0, 1.0, 0.05, min(8.0, 0.5 * (0.45 + top))]
    other = least_squares(residual, begin, bounds=(low, high), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    assert status > 0
    assert found.cost == pytest.approx(2.0 * other.cost, rel=1e-7)
    np.testing.assert_allclose(found.q, other.x[2:], rtol=1e-4)
    assert (found.q[1] == top) == (top < 2.5)


@pytest.mark.parametrize("count", [1, 2])
def test_a_search_without_hope_is_given_up_and_no_other(count):
    """One decay cannot follow two; two decays follow three as long as the limit is above what they reach."""
    t = np.linspace(0.0, 10.0, 300)
    y = np.exp(-np.outer(t, [0.1, 1.0, 6.0][: count + 1])) @ [2.0, 3.0, -2.0][: count + 1]
    sizes = tuple(Param(f"a{k}", "1", "") for k in range(count))
    rates = tuple(Param(f"k{k}", "1/s", "", 0.01, 20.0, start=start) for k, start in enumerate([0.2, 2.0][:count]))
    start = decays(sizes, rates, y, t).starts(1)[0]
    best, status, _ = descend(start, 1e-15, 1e-9, 200)
    assert status > 0 and 0.0 < best.cost < start.cost
    again, status, _ = descend(start, 1e-15, 1e-9, 200, 1.01 * best.cost)
    assert status > 0 and again.cost == best.cost
    _, status, message = descend(start, 1e-15, 1e-9, 200, 0.01 * best.cost)
    assert (status, message) == (-1, GIVEN_UP)


@pytest.mark.parametrize("seed", range(3))
def test_what_the_data_leave_open_stays_where_it_began(seed):
    """A size and three rates of one decay: only the rates' sum counts, and rounding must not move them apart."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 5.0, 200)
    y = 2.0 * np.exp(-1.5 * t) + 0.01 * rng.normal(size=200)
    rates = tuple(Param(f"r{k}", "1/s", "", 0.01, 10.0, start=0.1 * (k + 1)) for k in range(3))

    def design(values):
        return np.exp(-t * sum(values.values()))[:, None], np.zeros_like(t)

    def found(target):
        problem = Problem((Param("a", "1", "", -100.0, 100.0),), rates, design, target)
        return descend(problem.starts(1)[0], 1e-15, 1e-9, 200)[0].q

    whole = found(y)
    np.testing.assert_allclose(found(y * (1.0 + 1e-10 * rng.normal(size=200))), whole, rtol=1e-7)
    assert np.sum(whole) == pytest.approx(1.5, abs=0.02)
