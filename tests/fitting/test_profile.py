"""Profiles: the t interval where the model is linear, the likelihood's own where it is not, bounds on the way."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pam_ident.core import UsageError
from pam_ident.fitting import fit
from pam_ident.fitting.profile import profile
from pam_ident.model import Model
from pam_ident.records import build_record


def test_of_a_linear_parameter_it_is_a_parabola(record):
    one = fit(Model.build("polynomial"), record())
    e = one.estimates[0]
    found = profile(one, e.name)
    assert (found.low, found.high) == (pytest.approx(e.low, rel=1e-6), pytest.approx(e.high, rel=1e-6))
    np.testing.assert_allclose(found.deviance, ((found.values - e.value) / e.stderr) ** 2, rtol=1e-5, atol=1e-7)
    assert found.open_ == () and set(found.others) == {x.name for x in one.estimates} - {e.name}


def test_of_a_curved_parameter_it_is_where_the_sum_of_squares_passes_its_limit(record):
    short = record(n=100, sigma=15.0)
    one = fit(Model.build("exponential_law"), short, white=True)
    e = next(x for x in one.estimates if x.name == "mu")
    found = profile(one, "mu")
    p, x, y = short.inputs.pressure, short.inputs.contraction, short.force

    def squares(mu):
        d = np.exp(-mu * x)
        matrix = np.column_stack([np.ones_like(p), p, -x, -x * p, d, d * p])
        return float(np.sum((y - matrix @ np.linalg.lstsq(matrix, y, rcond=None)[0]) ** 2))

    limit = squares(e.value) * (1.0 + found.limit / (len(y) - 7))
    assert found.low == pytest.approx(brentq(lambda m: squares(m) - limit, 5.0, e.value), rel=0.02)
    assert found.high == pytest.approx(brentq(lambda m: squares(m) - limit, e.value, 200.0), rel=0.02)
    assert found.high - e.value > 1.03 * (e.value - found.low)


def test_a_flat_parameter_moves_freely_until_its_partner_meets_a_bound_which_is_marked(record):
    one = fit(Model.build("modified_chou_hannaford", ("force_bias",)), record())
    bias = next(p for p in one.model.params if p.name == "force_bias.F_b")
    found = profile(one, "k2")
    stuck = np.array([names == ("force_bias.F_b",) for names in found.bounded])
    assert stuck[0] and stuck[-1] and not stuck[len(stuck) // 2]
    assert np.all(found.deviance[~stuck] < 1e-6) and np.all(found.deviance[[0, -1]] > found.limit)
    assert found.high - found.low == pytest.approx(bias.upper - bias.lower, rel=0.2)


def test_an_end_that_the_data_do_not_close_is_open(specimen):
    e = np.tile(np.linspace(0.0, 0.2, 40), 3)
    p = np.repeat([0.1, 0.3, 0.5], 40)
    direction = np.where(np.arange(120) % 2 == 0, 1.0, -1.0)
    noise = np.random.default_rng(1).normal(0.0, 4.0, 120)
    force = 3000.0 * p * (1.0 - 3.0 * e) - 0.4 * direction + noise
    table = build_record("bench", specimen, p, e, force, direction=direction)
    found = profile(fit(Model.build("polynomial", ("coulomb_friction",)), table), "coulomb_friction.F_c")
    assert found.open_ == ("low",) and math.isnan(found.low) and found.high > 0.4
    assert found.values[0] == 0.0  # friction does not push: its own bound


def test_an_unknown_parameter_is_refused(record):
    one = fit(Model.build("exponential_law"), record(), held={"mu": 45.0})
    with pytest.raises(UsageError, match="no fitted parameter 'mu'"):
        profile(one, "mu")
