"""Several records in one fit: what is shared is known better, and what is not is as alone."""

import math

import numpy as np
import pytest

from pam_ident.core import Specimen, UsageError
from pam_ident.fitting import fit, fit_together
from pam_ident.fitting.solve import separated
from pam_ident.fitting.together import stacked
from pam_ident.model import Model
from pam_ident.records import Record, build_record

LAW = Model.build("exponential_law")
MU = 45.0
OWN = ({"a0": -190.0, "a1": 2400.0, "b0": 900.0, "b1": 5500.0, "c0": 20.0, "c1": 690.0},
       {"a0": -150.0, "a1": 2000.0, "b0": 1100.0, "b1": 4500.0, "c0": 35.0, "c1": 500.0},
       {"a0": -260.0, "a1": 3100.0, "b0": 700.0, "b1": 6500.0, "c0": 5.0, "c1": 900.0})  # fmt: skip


def muscle(k: int, seed: int = 0, noise: float = 2.0, pressures=(0.1, 0.3, 0.5), time: bool = False) -> Record:
    """Isobars up and down, of the exponential law with its own coefficients and one μ for all."""
    rng = np.random.default_rng([seed, k])
    way = np.r_[np.linspace(0.0, 0.2, 25), np.linspace(0.2, 0.0, 25)]
    e, p = np.tile(way, 2 * len(pressures)), np.repeat(pressures, 100)
    v = OWN[k]
    force = v["a0"] + v["a1"] * p - (v["b0"] + v["b1"] * p) * e + (v["c0"] + v["c1"] * p) * np.exp(-MU * e)
    clock = np.arange(len(e)) * 0.2 + 30.0 * np.repeat(np.arange(len(pressures)), 100) if time else None
    specimen = Specimen(f"muscle {k}", 200.0, 10.0, 25.4, 1.5)
    return build_record(specimen.name, specimen, p, e, force + noise * rng.standard_normal(len(e)), time=clock)


@pytest.mark.parametrize("law", ["exponential_law", "sarosi"])
@pytest.mark.parametrize("time", [True, False])
def test_with_nothing_shared_it_is_the_fits_of_each_alone(law, time):
    """In tables, whose noise is white, but for what the pooled noise's degrees of freedom make of the intervals."""
    model = Model.build(law, ("coulomb_friction",) if time else ())
    records = [muscle(k, time=time, noise=1.0 + k) for k in range(3)]
    for record, one in zip(records, fit_together(model, records), strict=True):
        alone = fit(model, record)
        assert one.valid and one.shared == () and one.rmse == pytest.approx(alone.rmse, rel=1e-9)
        for a, b in zip(alone.estimates, one.estimates, strict=True):
            assert (b.name, b.unit, b.verdict.kind, b.at_bound) == (a.name, a.unit, a.verdict.kind, a.at_bound)
            assert b.value == pytest.approx(a.value, rel=1e-6, abs=1e-9)
            assert b.stderr == pytest.approx(a.stderr, rel=1e-5, nan_ok=True)
            assert not time or b.dof == pytest.approx(a.dof, rel=1e-5, nan_ok=True)


def test_sharing_narrows_the_errors_of_what_is_shared_and_of_what_goes_with_it():
    records = [muscle(k) for k in range(3)]
    alone = [{e.name: e for e in fit(LAW, record).estimates} for record in records]
    together = [{e.name: e for e in one.estimates} for one in fit_together(LAW, records, ["mu"])]
    errors = np.array([one["mu"].stderr for one in alone])
    assert len({one["mu"].value for one in together}) == 1
    assert together[0]["mu"].stderr == pytest.approx(1.0 / math.sqrt(np.sum(errors**-2.0)), rel=0.05)
    assert abs(together[0]["mu"].value - MU) < 4.0 * together[0]["mu"].stderr
    for k, truth in enumerate(OWN):
        ratio = {name: together[k][name].stderr / alone[k][name].stderr for name in truth}
        assert max(ratio.values()) < 1.05 and min(ratio.values()) < 0.95, ratio
        for name, value in truth.items():
            assert abs(together[k][name].value - value) < 4.0 * together[k][name].stderr, (k, name)


@pytest.mark.long
def test_intervals_of_a_shared_parameter_hold_the_truth_as_often_as_they_say():
    held = 0
    for seed in range(60):
        (one, *_) = fit_together(LAW, [muscle(k, seed, noise=(1.0, 3.0, 9.0)[k]) for k in range(3)], ["mu"])
        mu = next(e for e in one.estimates if e.name == "mu")
        held += mu.low < MU < mu.high
    assert 52 <= held <= 60  # 57 of 60 are 95 %; outside this with a chance of 1 %


def test_a_noisy_muscle_does_not_decide_for_the_others():
    records = [muscle(0, noise=1.0), muscle(1, noise=60.0)]
    (one, _) = fit_together(LAW, records, ["mu"])
    alone = next(e for e in fit(LAW, records[0]).estimates if e.name == "mu")
    mu = next(e for e in one.estimates if e.name == "mu")
    assert mu.stderr <= 1.02 * alone.stderr and abs(mu.value - alone.value) < alone.stderr


def test_the_covariance_of_a_record_is_that_of_its_errors():
    for one in fit_together(LAW, [muscle(k) for k in range(2)], ["mu", "b1"]):
        errors = {e.name: e.stderr for e in one.estimates}
        assert one.covariance is not None
        assert np.sqrt(np.diag(one.covariance.matrix)) == pytest.approx([errors[name] for name in one.free])
        _, low, high = one.band(one.record.inputs)
        assert np.all(high > low)


def test_a_muscle_of_one_isobar_is_fitted_by_what_it_shares():
    records = [muscle(0), muscle(0, seed=1, pressures=(0.3,))]
    assert set(fit(LAW, records[1]).held) == {"a0", "b0", "c0"}
    alike = fit_together(LAW, records, [n for n in LAW.names if n != "a0"])
    assert all(one.valid for one in alike) and alike[0].values["a0"] != alike[1].values["a0"]
    loose = fit_together(LAW, records, ["mu"])
    assert loose[0].valid and not loose[1].valid
    assert "a1" in next(e.verdict.text for e in loose[1].estimates if e.name == "a0")


def test_a_shared_relaxation_time_may_be_as_long_as_the_longest_record():
    model = Model.build("exponential_law", ("creep",))
    records = [muscle(0, time=True), muscle(1, time=True, pressures=(0.3,))]
    parts = [separated(model, one.inputs, one.force, {}) for one in records]
    for order in (parts, parts[::-1]):
        (tau,) = (p for p in stacked(order, {"creep.tau"}).nonlinear if p.name == "creep.tau")
        assert tau.upper == pytest.approx(records[0].inputs.seconds)


def test_what_is_held_is_held_in_all():
    for one in fit_together(LAW, [muscle(k) for k in range(2)], ["b0"], held={"mu": 44.0}):
        mu = next(e for e in one.estimates if e.name == "mu")
        assert mu.value == 44.0 and mu.verdict.kind == "held" and "mu" not in one.free and "b0" in one.free


@pytest.mark.parametrize(
    ("records", "shared", "held", "effects", "words"),
    [
        (1, ["mu"], {}, (), "two or more"),
        (2, ["nu"], {}, (), "no parameter 'nu' to share"),
        (2, ["mu"], {"mu": 40.0}, (), "held and shared"),
        (2, [], {"mu": -1.0}, (), "outside its bounds"),
        (2, ["mu"], {}, ("series_compliance",), "acts on the force itself"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_a_sentence(records, shared, held, effects, words):
    with pytest.raises(UsageError, match=words):
        fit_together(Model.build("exponential_law", effects), [muscle(k) for k in range(records)], shared, held=held)
