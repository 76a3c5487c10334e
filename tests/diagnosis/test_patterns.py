"""Patterns are made and tried many at a time; what comes out must be what one at a time would give."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.dictionary import grid
from pam_ident.diagnosis.patterns import patterns
from pam_ident.diagnosis.scan import ENOUGH, Remainder, _best, _found
from pam_ident.diagnosis.selection import Selection
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record


def ripple(x):
    return 3.0 * np.sin(2.0 * np.pi * x / 6.4)


def loops(n, hidden=ripple):
    time = np.arange(n) * 0.1
    x = 20.0 - 20.0 * np.cos(2.0 * np.pi * time / 30.0)
    noise = np.random.default_rng(1).standard_normal(n)
    force = 400.0 - 5.0 * x + hidden(x) + noise
    pressure = np.where(time < 0.05 * n, 0.3, 0.4)
    return build_record("loop", Specimen("bench", 200.0, 10.0, 25.4, 1.5), pressure, x / 200.0, force, time=time)


@pytest.fixture
def record():
    return loops(900)


def test_columns_of_many_shapes_are_those_of_each(record):
    inputs, force = record.inputs, record.force
    shaped = [(e.name, form) for e in patterns(inputs) for form in e.forms if form.nonlinear]
    assert {"local", "periodic", "step"} <= {name for name, _ in shaped}
    for _, form in shaped:
        grid = [np.array(p.grid[:12]) if k == 0 else np.full(12, p.grid[0]) for k, p in enumerate(form.nonlinear)]
        many = form.columns(inputs, dict(zip([p.name for p in form.nonlinear], grid, strict=True)), force)
        many = many.reshape(len(record), len(form.linear), -1)
        for i in range(many.shape[2]):
            shape = {p.name: float(values[i]) for p, values in zip(form.nonlinear, grid, strict=True)}
            np.testing.assert_allclose(many[:, :, i], form.columns(inputs, shape, force), atol=1e-11)


def test_the_gain_of_a_ripple_is_the_fall_of_a_least_squares_fit(record):
    selection = Selection(fit(Model.build("polynomial"), record), [])
    remainder = Remainder(selection, selection.empty)
    ripple = next(e for e in patterns(record.inputs) if e.name == "periodic").forms[0]
    found = _best(ripple, [{"period": p} for p in (9.0, 6.4, 5.0)], [remainder])[0]
    columns = selection.noise.whiten(
        np.column_stack([remainder.view.law, ripple.columns(record.inputs, found.point, record.force)])
    )
    residual = selection.noise.whiten(remainder.view.residual)
    law = columns[:, :-2]
    alone, whole = (np.linalg.lstsq(m / np.linalg.norm(m, axis=0), residual, rcond=None)[1][0] for m in (law, columns))
    assert found.point == {"period": 6.4}
    assert found.gain == pytest.approx(alone - whole, rel=1e-6)


@pytest.mark.parametrize("begin_s", [0.0, 1.7e9], ids=["from zero", "from the epoch"])
def test_what_single_precision_finds_is_as_good_as_what_double_finds(record, begin_s):
    """A clock that counts seconds since 1970 has no digits to spare for single precision."""
    inputs = record.inputs
    later = build_record(
        "later", inputs.specimen, inputs.pressure, inputs.contraction, record.force, time=inputs.time + begin_s
    )
    selection = Selection(fit(Model.build("polynomial"), later), [])
    remainder = Remainder(selection, selection.empty)
    for effect in patterns(later.inputs):
        for form in effect.forms:
            points = grid(form, later.inputs)
            rough, precise = _found(form, points, [remainder])[0], _best(form, points, [remainder])[0]
            assert 0.98 * precise.gain <= rough.gain <= (1.0 + 1e-9) * precise.gain


def test_a_third_of_the_samples_shows_what_all_of_them_show():
    record = loops(3 * ENOUGH, lambda x: 3.0 * np.exp(-0.5 * ((x - 27.0) / 4.0) ** 2))
    selection = Selection(fit(Model.build("polynomial"), record), [])
    remainder = Remainder(selection, selection.empty)
    assert len(remainder.rough.inputs) == pytest.approx(ENOUGH, rel=0.1)
    strong = 0
    for effect in patterns(record.inputs):
        for form in effect.forms:
            rough, precise = (f(form, grid(form, record.inputs), [remainder])[0].gain for f in (_found, _best))
            if precise > 0.1 * len(record):
                strong += 1
                assert rough > 0.98 * precise, form.name
    assert strong > 5


def test_columns_are_made_and_whitened_in_the_precision_of_the_inputs(record):
    selection = Selection(fit(Model.build("polynomial"), record), [])
    remainder = Remainder(selection, selection.empty)
    samples = remainder.rough
    for effect in patterns(record.inputs):
        for form in effect.forms:
            if form.nonlinear:
                columns = form.columns(samples.inputs, grid(form, record.inputs)[0], samples.around.force)
                assert columns.dtype == np.float32
                exact = form.columns(record.inputs, grid(form, record.inputs)[0], remainder.view.around.force)
                np.testing.assert_allclose(selection.noise.whiten(columns), selection.noise.whiten(exact), atol=1e-4)


@pytest.mark.long
def test_a_wave_as_short_as_the_distance_of_readings_does_not_follow_the_length_sensors_noise():
    """Strokes that are read at the same places each time, where the force is steep: it was a ripple of 1.30 mm."""
    rng = np.random.default_rng(0)
    part, soft = np.arange(29) / 29, 0.05
    way = np.where(part < soft, part**2 / (2 * soft), part - soft / 2)
    way = np.where(part > 1 - soft, 1 - soft - (1 - part) ** 2 / (2 * soft), way) / (1 - soft)
    x, p, t, now = [], [], [], 0.0
    for pressure in (0.43, 0.22, 0.58, 0.3, 0.5):
        for speed in np.repeat((2.4, 8.8, 32.0), 3):
            for stroke in (way, 1.0 - way):
                x.append(1.5 + 36.0 * stroke)
                p.append(np.full(29, pressure))
                t.append(now + part * 36.0 / speed)
                now += 36.0 / speed
        now += 20.0
    x, p, t = map(np.concatenate, (x, p, t))
    e = x / 200.0
    force = 1600.0 * p - 40.0 + (70.0 + 1365.0 * p) * np.exp(-38.0 * e) - (60.0 + 1000.0 * p) * e
    seen, noise = x + 0.023 * rng.standard_normal(len(x)), 1.28 * rng.standard_normal(len(x))
    record = build_record("soft", Specimen(), p, seen / 200.0, force + noise, time=t)
    assert diagnose(Model.build("exponential_law"), record, detail=False).verdict == "adequate"


def test_a_wave_sees_the_mean_of_what_is_read_at_one_place():
    """A stroke with stops, in legs too short to be smoothed: it was a ripple of half the distance of its readings."""
    rng = np.random.default_rng(3)
    legs = [np.r_[2.4 * np.arange(7 * k, 7 * k + 7), np.full(4, 2.4 * (7 * k + 7))] for k in range(5)]
    x = np.tile(np.concatenate(legs), 20) + 0.03 * rng.standard_normal(20 * 55)
    time, force = np.arange(len(x)) * 0.1, 900.0 - 8.0 * x
    inputs = build_record("stops", Specimen(), np.full(len(x), 0.3), x / 200.0, force, time=time).inputs
    form = next(e for e in patterns(inputs, error_mm=0.03) if e.name == "periodic").forms[0]
    assert form.columns(inputs, {"period": 1.2}, force).std(axis=0).max() < 0.06, "0.16 with what the sensor is off"
    assert form.columns(inputs, {"period": 9.0}, force).std(axis=0).min() > 0.6


@pytest.mark.parametrize(("levels", "curves"), [(3, 0), (4, 0), (6, 1)])
def test_a_curve_over_pressure_needs_as_many_levels_as_knots_however_they_are_read(levels, curves):
    """Readings that straddle a rounded value counted as two levels; between few, a curve follows their noise."""
    rng = np.random.default_rng(4)
    held = np.repeat(np.linspace(0.095, 0.495, levels), 200)
    time = 0.1 * np.arange(len(held)) + np.repeat(60.0 * np.arange(levels), 200)
    contraction = 0.1 - 0.08 * np.cos(2.0 * np.pi * time / 5.37)
    muscle = Specimen("m", 200.0, 10.0, 25.0)
    pressure = held + 0.001 * rng.standard_normal(len(held))
    force = muscle.ideal_force(pressure, contraction)
    record = build_record("r", muscle, pressure, contraction, force, time=time, level=held)
    forms = [form.name for effect in patterns(record.inputs) for form in effect.forms]
    assert forms.count("over_pressure") == curves
