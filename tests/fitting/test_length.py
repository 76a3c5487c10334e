"""Where the load is held the length answers: the model solved for it, on muscles of the virtual rig under weights."""

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import DataError, Specimen, UsageError
from pam_ident.fitting import Weighing, fit, fit_together
from pam_ident.fitting.carried import _sticks
from pam_ident.fitting.length import Lengths, _stopped, at_limit, equilibrium, implicit, load_of, weights_of
from pam_ident.model import Model
from pam_ident.records import Record, record_from_frame
from pam_ident.records.turning import pivots
from pam_ident.rig import Plan, make_record
from pam_ident.rig.record import COLUMNS

LAW = Model("exponential_law")
SENSORS_MM = 0.025
"""What noise of 0.01 mm and 0.2 kPa makes of a length, about."""


def read(made, table=None) -> Record:
    s = made.muscle.specimen
    muscle = Specimen("rig", s.initial_length_mm, s.initial_radius_mm, s.braid_angle_deg, s.wall_thickness_mm)
    frame = pd.DataFrame(made.table if table is None else table, columns=list(COLUMNS))
    return record_from_frame(frame.dropna(axis=1, how="all"), muscle)


@cache
def rig(seed: int, protocol: str = "weight_ramps"):
    return make_record(Plan(seed, protocol=protocol))


@cache
def record(seed: int, protocol: str = "weight_ramps") -> Record:
    return read(rig(seed, protocol))


def under(whole: Record, *weights: int) -> Record:
    """The runs under some of the weights, 0 the lightest."""
    held = weights_of(whole)
    return whole.take(np.flatnonzero(np.isin(held, np.unique(held)[list(weights)])))


def rms_mm(model, values, part: Record) -> float:
    return float(np.sqrt(np.mean(Lengths.of(model, part, values).residual ** 2)))


@pytest.mark.long
@pytest.mark.parametrize("seed", [3, 4])
def test_two_weights_predict_the_length_under_a_third_to_about_the_sensors_noise(seed):
    whole = record(seed)
    for third in range(3):
        one = fit(LAW, under(whole, *(k for k in range(3) if k != third)))
        assert one.valid and one.length_errors.rmse < SENSORS_MM
        assert rms_mm(LAW, one.values, under(whole, third)) < 1.3 * SENSORS_MM


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 5])
def test_weights_and_isobars_give_one_muscle_the_same_parameters(seed):
    weights, isobars = fit(LAW, record(seed)), fit(LAW, record(seed, "standard"))
    truth = rig(seed).muscle.law
    assert rig(seed, "standard").muscle.law == truth
    assert isobars.lengths is None and weights.lengths is not None
    for one, other in zip(weights.estimates, isobars.estimates, strict=True):
        assert abs(one.value - other.value) < 3.0 * np.hypot(one.stderr, other.stderr)
        assert abs(one.value - getattr(truth, one.name)) < 3.0 * one.stderr
    assert rms_mm(LAW, isobars.values, record(seed)) < SENSORS_MM


@pytest.mark.long
def test_records_of_one_weight_each_are_fitted_together_as_one_of_all():
    whole = fit(LAW, record(3))
    for one in fit_together(LAW, [under(record(3), k) for k in range(3)], LAW.names):
        assert one.valid and one.length_errors.rmse < SENSORS_MM
        for mine, its in zip(one.estimates, whole.estimates, strict=True):
            assert mine.value == pytest.approx(its.value, abs=0.1 * its.stderr)
            assert mine.stderr == pytest.approx(its.stderr, rel=0.1)


@pytest.mark.long
def test_a_weight_and_isobars_are_fitted_together_each_by_what_answered():
    records, truth = [record(3, "standard"), under(record(3), 1)], rig(3).muscle.law
    isobars, weight = fit_together(LAW, records, LAW.names)
    assert isobars.valid and weight.valid and weight.length_errors.rmse < SENSORS_MM
    for one, alone in zip(isobars.estimates, fit(LAW, records[0]).estimates, strict=True):
        assert one.stderr < alone.stderr and abs(one.value - getattr(truth, one.name)) < 3.0 * one.stderr
    isobars, weight = fit_together(LAW, [records[0], record(3)])
    for one, alone in ((isobars, fit(LAW, records[0])), (weight, fit(LAW, record(3)))):
        for mine, its in zip(one.estimates, alone.estimates, strict=True):
            assert (mine.value, mine.stderr) == pytest.approx((its.value, its.stderr), rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("law", ["exponential_law", "modified_chou_hannaford", "hildebrandt", "martens_boblan"])
def test_one_weight_leaves_the_scale_of_a_law_open(law):
    one = fit(Model(law), under(record(3), 1))
    assert not one.valid and "hang other weights" in one.problems[-1]
    assert [e for e in one.estimates if not e.identified]


@pytest.mark.long
def test_what_wiggles_of_one_load_would_tell_is_no_second_weight():
    whole = under(record(3), 1)
    wiggles = 10.0 * np.sin(0.8 * whole.inputs.time)
    one = fit(LAW, replace(whole, force=whole.force + wiggles))
    assert not one.valid and len(np.unique(weights_of(one.record))) == 1


@pytest.mark.long
def test_a_law_that_does_not_fall_predicts_no_length_and_does_not_win():
    whole = under(record(3), 1)
    load = load_of(whole)
    nothing = dict.fromkeys(LAW.names, 0.0) | {"a0": float(load[0]), "mu": 45.0}
    assert np.abs(LAW.force(whole.inputs, nothing) - load).max() < 1e-9  # the force is fitted to the last digit
    e, slope = equilibrium(LAW, whole.inputs, nothing, load)
    assert not slope.any() and np.ptp(e) < 1e-9
    assert rms_mm(LAW, nothing, whole) > 5.0
    assert fit(LAW, whole).length_errors.rmse < SENSORS_MM


def test_the_length_predicted_knows_nothing_of_the_length_measured():
    whole = record(3)
    values = fit(LAW, whole, detail=False).values
    moved = replace(whole, inputs=replace(whole.inputs, contraction=whole.inputs.contraction[::-1].copy()))
    there, here = (Lengths.of(LAW, one, values).contraction for one in (moved, whole))
    np.testing.assert_array_equal(there, here)


@pytest.mark.long
@pytest.mark.parametrize("law", ["exponential_law", "modified_chou_hannaford", "sarosi"])
def test_slopes_of_the_length_are_those_of_differences(law):
    model, whole = Model(law), record(3)
    values, load = fit(model, whole, detail=False).values, load_of(whole)
    slopes = implicit(model, whole.inputs, values, load, *equilibrium(model, whole.inputs, values, load))
    for k, name in enumerate(model.names):
        step = 1e-5 * max(abs(values[name]), 1e-2)
        ends = (equilibrium(model, whole.inputs, {**values, name: values[name] + s * step}, load)[0] for s in (1, -1))
        up, down = ends
        np.testing.assert_allclose(slopes[:, k], (up - down) / (2 * step), rtol=2e-4, atol=1e-7 * np.abs(slopes).max())


def on_a_stop(seed: int):
    """A record whose muscle rests on a stop where the pressure lifts the weight no higher, and which rows do."""
    made = rig(seed)
    table, x = made.table.copy(), made.course.eps[made.course.rows] * made.course.length_mm
    stop = float(np.quantile(x, 0.25))
    noise = table[:, 4] - x
    rests = x < stop
    table[:, 4] = np.where(rests, stop + noise, table[:, 4])
    return read(made, table), rests


@pytest.mark.long
def test_rows_on_a_stop_are_left_out_and_counted():
    whole, rests = on_a_stop(3)
    limit = at_limit(whole)
    assert np.mean(limit[rests]) > 0.95 and np.mean(limit[~rests]) < 0.05
    one = fit(LAW, whole)
    assert one.n == len(whole) - limit.sum()
    for e in one.estimates:
        assert abs(e.value - getattr(rig(3).muscle.law, e.name)) < 4.0 * e.stderr
    assert not at_limit(record(3)).any()


def test_rows_without_pressure_are_left_out():
    whole = record(3)
    p = whole.inputs.pressure.copy()
    p[:50] = 0.001
    assert at_limit(replace(whole, inputs=replace(whole.inputs, pressure=p))).sum() == 50


def test_one_pressure_but_for_its_rounding_tells_of_no_stop():
    """A line through its rows had a warning of numpy's for each."""
    x = np.r_[np.zeros(20), np.full(20, 0.5), np.linspace(1.0, 10.0, 60)]
    p = np.r_[np.linspace(0.1, 0.2, 20), np.tile([0.2, np.nextafter(0.2, 1.0)], 10), np.linspace(0.2, 0.5, 60)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not _stopped(x, p, np.ones(100, bool), 0.1).any()


def test_a_length_that_leaves_its_stop_at_a_jump_stood_on_one():
    """Just above a threshold a light weight goes up by a tenth of its way from one sample to the next."""
    ramp = np.linspace(0.02, 0.5, 130)
    p = np.tile(np.r_[ramp, ramp[::-1]], 2)
    x = np.where(p < 0.04, 0.0, 5.0 + 50.0 * np.sqrt(np.maximum(p - 0.04, 0.0)))
    found = _stopped(x, p, np.tile(np.repeat([False, True], 130), 2), 0.2)
    assert found.sum() == (p < 0.04).sum() > 12


def without_pauses(made) -> Record:
    """The same rows on one clock, weight after weight."""
    table = pd.DataFrame(made.table, columns=list(COLUMNS))
    table["time_s"] = 0.05 * np.arange(len(table))
    return read(made, table)


def test_weights_that_are_changed_without_a_pause_are_told_apart():
    parted, whole = record(3), without_pauses(rig(3))
    assert len(np.unique(whole.inputs.segment)) == 1 and len(np.unique(weights_of(whole))) == 3
    np.testing.assert_allclose(weights_of(whole), weights_of(parted), rtol=0.01)


@pytest.mark.parametrize("order", [(1, 3, 0, 2), (0, 3, 1, 2)])
def test_weights_in_any_order_are_told_apart(order):
    """The first step alone explains little of them."""
    whole = without_pauses(rig(3))
    turns = pivots(whole.inputs.pressure, 0.5 * float(np.ptp(whole.inputs.pressure)))
    edges = [0, *np.array(turns)[[len(turns) * k // 4 for k in (1, 2, 3)]], len(whole)]
    force = np.concatenate([np.full(b - a, 100.0 + 60.0 * k) for a, b, k in zip(edges, edges[1:], order, strict=False)])
    force = force + np.random.default_rng(1).normal(0.0, 0.5, len(whole))
    np.testing.assert_allclose(
        np.unique(weights_of(replace(whole, force=force))), [100.0, 160.0, 220.0, 280.0], atol=0.2
    )


def test_weights_are_told_apart_though_each_is_lifted_by_pressures_of_its_own():
    """A light one needs less, and its pressures change by less."""
    whole = without_pauses(rig(3))
    held = weights_of(whole)
    _, which = np.unique(held, return_inverse=True)
    pressure = whole.inputs.pressure * np.array([0.25, 0.6, 1.0])[which]
    lifted = replace(whole, inputs=replace(whole.inputs, pressure=pressure))
    np.testing.assert_allclose(weights_of(lifted), held, rtol=0.01)


@pytest.mark.parametrize("seed", [1, 2])
def test_rows_in_which_a_weight_sticks_tell_nothing_however_badly_the_length_is_read(seed):
    rng, n = np.random.default_rng(seed), 2400
    time = 0.1 * np.arange(n)
    pressure = 0.3 + 0.2 * np.abs(2.0 * (time / 24.0 % 1.0) - 1.0)
    pulled = np.empty(n)  # what gets past dry friction of half of 0.03 MPa
    at = pressure[0]
    for k, p in enumerate(pressure):
        at = pulled[k] = min(max(at, p - 0.015), p + 0.015)
    stands = np.abs(np.diff(pulled, prepend=pulled[0])) < 1e-9
    table = {
        "time_s": time,
        "pressure_MPa": pressure,
        "displacement_mm": 150.0 * (pulled - 0.3) + 5.0 + 0.2 * rng.standard_normal(n),
        "force_N": 100.0 + 0.3 * rng.standard_normal(n),
    }
    record = record_from_frame(pd.DataFrame(table), Specimen("m", 200.0, 10.0, 25.0))
    assert record.kind == "isotonic"
    found = _sticks(record)
    first = np.flatnonzero(np.diff(np.sign(np.diff(pressure))))[0] + 2  # before the first turn nobody knows
    assert np.mean(found[first:][stands[first:]]) > 0.9
    assert np.mean(found[~stands]) < 0.1


@pytest.mark.parametrize("load", ["friction", "one way", "swelling", "swinging", "noise", "two like ones"])
def test_what_else_a_load_does_within_a_run_is_no_other_weight(load):
    whole = without_pauses(rig(3))
    n, rng = len(whole), np.random.default_rng(2)
    if load == "one way":  # a single rise and fall of the pressure
        turns = pivots(whole.inputs.pressure, 0.5 * float(np.ptp(whole.inputs.pressure)))
        whole = whole.take(np.arange(turns[0], turns[2]))
        n = len(whole)
    way = np.sign(whole.inputs.pressure_rate)
    force = {
        "friction": 100.0 + 15.0 * way,
        "one way": 100.0 + 15.0 * way,
        "swelling": np.linspace(50.0, 150.0, n),
        "swinging": 100.0 + 50.0 * np.sin(2.0 * np.pi * np.arange(n) / n),
        "noise": 100.0 + rng.normal(0.0, 5.0, n),
        "two like ones": 100.0 + 5.0 * way + 10.0 * (np.arange(n) > n // 2),
    }[load]
    assert len(np.unique(weights_of(replace(whole, force=force)))) == 1


def test_weights_are_told_apart_under_friction_and_while_they_are_changed():
    whole = without_pauses(rig(3))
    held = weights_of(whole)
    step = np.flatnonzero(np.diff(held))[0]
    force = held * (1.0 + 0.05 * np.sign(whole.inputs.pressure_rate))
    force[step - 5 : step + 5] = 0.0
    assert len(np.unique(weights_of(replace(whole, force=force)))) == 3


def test_a_hanging_mass_is_accelerated_and_a_held_force_is_not():
    whole = under(record(3), 0)
    heavy = replace(whole, force=np.full(len(whole), 98.0665))
    assert np.ptp(load_of(heavy)) == 0.0
    mass = replace(heavy, columns={"force": "load_kg = 10 by columns.toml"})
    t, x = whole.inputs.time, 1.0 - np.cos(2 * np.pi * 0.5 * whole.inputs.time)
    velocity = 2 * np.pi * 0.5 * np.sin(2 * np.pi * 0.5 * t)
    swung = replace(
        whole.inputs,
        contraction=x / 200.0,
        velocity=velocity,
        direction=np.sign(velocity),
        moving=np.ones(len(t), bool),
    )
    found = load_of(replace(mass, inputs=swung)) - 98.0665
    within = (np.abs(found) > 0.0) & (np.diff(t, append=t[-1] + 9.0) < 0.2) & (np.diff(t, prepend=t[0] - 9.0) < 0.2)
    expected = 10.0 * 1e-3 * (2 * np.pi * 0.5) ** 2 * np.cos(2 * np.pi * 0.5 * t)
    assert within.sum() > 50 and np.abs(found - expected)[within].max() < 0.15 * np.abs(expected).max()


def test_what_remembers_the_way_or_weighs_forces_is_refused():
    with pytest.raises(DataError, match="creep remembers the way"):
        fit(Model("exponential_law", "creep"), record(3))
    with pytest.raises(UsageError, match="residuals in force"):
        fit(LAW, record(3), weighing=Weighing(loss="huber"))


def test_a_static_table_of_lengths_under_weights_is_fitted():
    made = rig(4)
    p = np.tile(np.linspace(0.2, 0.6, 12), 3)
    load = np.repeat([60.0, 150.0, 260.0], 12)
    x = made.muscle.contraction(p, load) * made.muscle.specimen.initial_length_mm
    rng = np.random.default_rng(1)
    table = pd.DataFrame({"pressure_MPa": p, "displacement_mm": x + rng.normal(0, 0.01, len(x)), "force_N": load})
    s = made.muscle.specimen
    whole = record_from_frame(table, Specimen("t", s.initial_length_mm, s.initial_radius_mm, s.braid_angle_deg))
    one = fit(LAW, replace(whole, said_kind="isotonic"))
    assert one.length_errors.rmse < 0.012 and one.n == 36
