"""The interval of a new reading holds 95 % of them, whatever the model lacks; a benchmark counts it more widely."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.fitting import fit
from pam_ident.fitting.prediction import Predictor, reading_spread, simpler
from pam_ident.model import Model
from pam_ident.records import build_record

MUSCLE = Specimen("made", 200.0, 10.0, 25.4)
LEVELS = (0.1, 0.2, 0.3, 0.4, 0.5)


def made(seed, friction=0.0, levels=LEVELS, cycles=5, wander=0.0):
    rng = np.random.default_rng(seed)
    rows, t = [], 0.0
    for p in levels:
        for speed in (5.0, 20.0):
            for _ in range(cycles):
                for start, end in ((0.0, 24.0), (24.0, 0.0)):
                    x = np.linspace(start, end, 25)
                    rows += [(t + abs(v - start) / speed, p, v / 200.0, np.sign(end - start)) for v in x]
                    t += 24.0 / speed + 1.0
        t += 5.0
    time, p, e, sign = np.array(rows).T
    force = -190 + 2400 * p - (900 + 5500 * p) * e + (20 + 690 * p) * np.exp(-45 * e) - friction * sign
    force += rng.normal(0.0, 2.0, len(e)) + wander * np.sin(40.0 * p)
    return build_record("made", MUSCLE, p, e, force, time=time)


@pytest.mark.parametrize("friction", [0.0, 10.0])
def test_it_holds_95_percent_of_another_run(friction):
    one = fit(Model("exponential_law"), made(1, friction))
    found = Predictor.of(one, reading_spread(one))
    fresh = made(2, friction)
    there = found.at(fresh.inputs)
    inside = np.abs(fresh.force - there.force) <= there.half_reading
    assert 0.93 < inside.mean() < 0.985
    assert np.all(there.half_mean < there.half_reading) and not there.outside.any()


def test_it_is_wider_where_the_model_lacks_an_effect():
    widths = []
    for friction in (0.0, 10.0):
        one = fit(Model("exponential_law"), made(1, friction))
        widths.append(reading_spread(one).same)
    assert widths[0] == pytest.approx(1.96 * 2.0, rel=0.08) and widths[1] > 2.5 * widths[0]


@pytest.mark.parametrize(
    ("friction", "effects", "said"), [(0.0, (), False), (10.0, (), True), (10.0, ("coulomb_friction",), False)]
)
def test_it_says_that_it_is_wide_where_the_model_lacks_an_effect(friction, effects, said):
    one = fit(Model("exponential_law", effects), made(1, friction))
    spread = reading_spread(one)
    assert spread.noise == pytest.approx(2.0, rel=0.1) and spread.wide == said
    assert np.all(Predictor.of(one, spread).at(one.record.inputs).unexplained == said)


def test_it_is_wider_at_pressures_that_were_not_measured():
    one = fit(Model("exponential_law"), made(1, wander=15.0))
    spread = reading_spread(one)
    assert spread.between > 1.2 * spread.same and spread.beyond > spread.same
    inputs = made(3, levels=(0.2, 0.25, 0.8)).inputs
    half = spread.half_width(inputs)
    assert [half[inputs.pressure == p][0] for p in (0.2, 0.25, 0.8)] == [spread.same, spread.between, spread.beyond]
    assert spread.outside(inputs).tolist() == (inputs.pressure == 0.8).tolist()


def test_nothing_is_said_where_nothing_can_be_left_out():
    one = fit(Model("exponential_law"), made(1, levels=(0.2, 0.4)))
    spread = reading_spread(one)
    assert np.isnan(spread.between) and np.isnan(spread.beyond) and spread.same > 0
    there = Predictor.of(one, spread).at(made(3, levels=(0.3,)).inputs)
    assert np.isnan(there.half_reading).all() and np.isfinite(there.half_mean).all()


def test_the_mean_and_its_error_are_those_of_the_fit():
    one = fit(Model("exponential_law"), made(1))
    found = Predictor.of(one, reading_spread(one)).at(one.record.inputs)
    force, low, high = one.band(one.record.inputs)
    assert found.force == pytest.approx(force)
    assert np.median(found.half_mean / (0.5 * (high - low))) == pytest.approx(1.0, abs=0.25)


def test_the_simpler_models_are_least_squares():
    one = fit(Model("exponential_law"), made(1))
    p, force = one.record.inputs.pressure, one.record.force
    plain = simpler(one).forces(one.record.inputs)
    design = np.column_stack([np.ones(len(p)), p])
    assert plain["mean_over_pressure"] == pytest.approx(design @ np.linalg.lstsq(design, force, rcond=None)[0])
    assert np.sqrt(np.mean((force - plain["polynomial"]) ** 2)) > one.rmse
