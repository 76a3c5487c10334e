"""Muscles fitted together, against the closed form of a balanced design and simulated truth."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.batch.hierarchy import fit_muscles
from pam_ident.core import Specimen, UsageError
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record

LAW = Model.build("exponential_law")
TRUTH = {"a0": -190.0, "a1": 2400.0, "b0": 900.0, "b1": 5500.0, "c0": 20.0, "c1": 690.0, "mu": 45.0}


def muscle(model, values, noise, rng, count=60):
    """A static table of three isobars."""
    p = np.repeat([0.2, 0.3, 0.4], count // 3)
    e = np.tile(np.linspace(0.0, 0.15, count // 3), 3)
    record = build_record("made", Specimen(), p, e, np.zeros(count), level=p)
    return replace(record, force=model.force(record.inputs, values) + rng.normal(0.0, noise, count))


def test_a_zero_of_each_muscles_load_cell_is_that_of_the_balanced_analysis_of_variance():
    # y = bias + noise over n samples of K muscles: τ² = (MSB − MSW)/n, and each bias is drawn to the mean by
    # τ²/(τ² + MSW/n) (Searle, Casella & McCulloch 1992, Variance Components, section 3.6).
    rng = np.random.default_rng(3)
    model = Model.build("chou_hannaford", ("force_bias",))
    count, n = 12, 60
    biases = rng.normal(30.0, 4.0, count)
    records = [muscle(model, {"force_bias.F_b": b}, 20.0, rng) for b in biases]
    found = fit_muscles(model, records, ("force_bias.F_b",))
    ideal = Model.build("chou_hannaford")
    y = np.array([r.force - ideal.force(r.inputs, {}) for r in records])
    between, within = n * y.mean(axis=1).var(ddof=1), y.var(axis=1, ddof=1).mean()
    tau = np.sqrt((between - within) / n)
    assert found.converged and found.scatter["force_bias.F_b"] == pytest.approx(tau, rel=2e-3)
    assert found.noise == pytest.approx(np.sqrt(within), rel=1e-3)
    assert found.values["force_bias.F_b"] == pytest.approx(y.mean(), abs=1e-6)
    assert found.stderr["force_bias.F_b"] == pytest.approx(np.sqrt(between / (n * count)), rel=2e-3)
    shrunk = y.mean() + tau**2 / (tau**2 + within / n) * (y.mean(axis=1) - y.mean())
    assert [mine["force_bias.F_b"] for mine in found.own] == pytest.approx(shrunk, abs=0.02)


def test_all_shared_is_the_fit_of_all_samples_in_one_record():
    rng = np.random.default_rng(4)
    records = [muscle(LAW, TRUTH, 2.0, rng) for _ in range(3)]
    p, e, force = (
        np.concatenate(parts)
        for parts in zip(*((r.inputs.pressure, r.inputs.contraction, r.force) for r in records), strict=True)
    )
    whole = fit(LAW, build_record("all", Specimen(), p, e, force, level=p))
    found = fit_muscles(LAW, records)
    assert dict(found.values) == pytest.approx(whole.values, rel=1e-6)
    assert dict(found.stderr) == pytest.approx({x.name: x.stderr for x in whole.estimates}, rel=1e-4)
    assert found.scatter == {} and found.own == ({}, {}, {})


@pytest.mark.long
def test_linear_and_curved_parameters_of_each_muscle_are_found_again():
    rng = np.random.default_rng(5)
    true = [TRUTH | {"a1": rng.normal(2400.0, 60.0), "mu": rng.normal(45.0, 3.0)} for _ in range(8)]
    records = [muscle(LAW, values, 1.0, rng) for values in true]
    found = fit_muscles(LAW, records, ("a1", "mu"))
    for name, scatter in (
        ("a1", np.std([t["a1"] for t in true], ddof=1)),
        ("mu", np.std([t["mu"] for t in true], ddof=1)),
    ):
        assert found.scatter[name] == pytest.approx(scatter, rel=0.15)
        assert [mine[name] for mine in found.own] == pytest.approx([t[name] for t in true], abs=0.2 * scatter)
    for name in ("a0", "b0", "b1", "c0", "c1"):
        assert abs(found.values[name] - TRUTH[name]) < 4.0 * found.stderr[name]
    assert max(found.rmse) < 1.3 and found.noise == pytest.approx(1.0, abs=0.15)
    other = muscle(LAW, TRUTH, 1.0, rng)
    assert np.sqrt(np.mean((found.force(other.inputs) - other.force) ** 2)) < 25.0


def test_what_cannot_be_shared_is_refused():
    record = muscle(LAW, TRUTH, 1.0, np.random.default_rng(6))
    with pytest.raises(UsageError, match="no parameter 'k9'"):
        fit_muscles(LAW, [record, record], ("k9",))
    with pytest.raises(UsageError, match="two muscles or more"):
        fit_muscles(LAW, [record], ("mu",))
    with pytest.raises(UsageError, match="depends on the force itself"):
        fit_muscles(Model.build("sarosi", ("series_compliance",)), [record, record])
