"""Many refits at once reach what one refit at a time reaches, and the bootstrap scatters as theory says."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from pam_ident.core import FitError, UsageError
from pam_ident.fitting import fit
from pam_ident.fitting.bootstrap import bootstrap
from pam_ident.fitting.refit import refit_forces, refit_weights
from pam_ident.model import Model


def by_scipy(law, truth, p, e, force, weight=1.0):
    done = least_squares(
        lambda x: weight * (law(x, p, e) - force),
        truth,
        jac="3-point",
        x_scale=np.abs(truth),
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    return done.x


def test_refits_to_other_forces_are_the_exact_ones(record, law, truth):
    one = fit(Model.build("exponential_law"), record())
    rng = np.random.default_rng(1)
    forces = one.force[:, None] + rng.choice(one.residual, (1000, 40))
    values, singly = refit_forces(one, forces)
    p, e = one.record.inputs.pressure, one.record.inputs.contraction
    assert singly == 0
    for b in range(40):
        np.testing.assert_allclose(values[b], by_scipy(law, truth, p, e, forces[:, b]), rtol=1e-6)


def test_refits_to_other_cycles_are_the_exact_ones(record, law, truth):
    one = fit(Model.build("exponential_law"), record())
    _, block = np.unique(one.record.block, return_inverse=True)
    counts = np.random.default_rng(2).multinomial(block.max() + 1, np.full(block.max() + 1, 1 / (block.max() + 1)), 40)
    values, _ = refit_weights(one, block, counts.astype(float))
    p, e = one.record.inputs.pressure, one.record.inputs.contraction
    for b in range(40):
        expected = by_scipy(law, truth, p, e, one.record.force, np.sqrt(counts[b])[block])
        np.testing.assert_allclose(values[b], expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "effects", "held"),
    [
        ("polynomial", (), {}),
        ("modified_chou_hannaford", ("coulomb_friction",), {}),
        ("exponential_law", (), {"mu": 45.0}),
        ("exponential_law", ("coulomb_friction",), {"a0": -197.8}),
    ],
)
def test_refits_to_the_same_record_give_the_fit_again(name, effects, held, record):
    one = fit(Model.build(name, effects), record(), held=held)
    values, _ = refit_forces(one, one.record.force[:, None])
    again, _ = refit_weights(one, np.arange(1000) // 10, np.ones((1, 100)))
    free = [e.value for e in one.estimates if e.name not in held]
    np.testing.assert_allclose(values[0], free, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(again[0], free, rtol=1e-6, atol=1e-7)


def test_refits_keep_the_bounds(record):
    one = fit(Model.build("modified_chou_hannaford", ("coulomb_friction",)), record())
    lower = {p.name: p.lower for p in one.model.params}
    forces = one.force[:, None] + np.random.default_rng(3).normal(0.0, 60.0, (1000, 30))
    values, singly = refit_forces(one, forces)
    for k, e in enumerate(one.estimates):
        assert np.all(values[:, k] >= lower[e.name] - 1e-9)
    assert singly > 0 and np.any(values[:, [e.name for e in one.estimates].index("coulomb_friction.F_c")] == 0.0)


def test_bootstrap_by_residual_agrees_with_the_standard_errors_of_white_noise(record):
    one = fit(Model.build("exponential_law"), record(), white=True)
    found = bootstrap(one, 4000, "residual", seed=3)
    for e in one.estimates:
        assert found.stderr[e.name] == pytest.approx(e.stderr, rel=0.06)
        low, high = found.intervals[e.name]
        assert low < e.value < high


def test_bootstrap_by_cycle_sees_the_correlation_that_the_white_one_misses(record):
    one = fit(Model.build("exponential_law"), record(rho=0.9))
    cycle, residual = bootstrap(one, 2000, "cycle", 1).stderr, bootstrap(one, 2000, "residual", 1).stderr
    assert np.median([cycle[n] / residual[n] for n in cycle]) > 1.5


def test_bootstrap_repeats_with_its_seed_and_refuses_nonsense(record):
    one = fit(Model.build("modified_chou_hannaford"), record())
    np.testing.assert_array_equal(bootstrap(one, 50, "cycle", 7).values, bootstrap(one, 50, "cycle", 7).values)
    assert not np.array_equal(bootstrap(one, 50, "cycle", 7).values, bootstrap(one, 50, "cycle", 8).values)
    with pytest.raises(UsageError, match="by 'stroke'"):
        bootstrap(one, 50, "stroke")
    few = fit(Model.build("modified_chou_hannaford"), one.record, rows=one.record.block < 3)
    with pytest.raises(FitError, match="3 cycles to draw from"):
        bootstrap(few, 50)
