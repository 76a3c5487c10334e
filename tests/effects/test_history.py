"""Memory operators against loops that take one small step after the other."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pam_ident.core import Inputs, Specimen
from pam_ident.core.recursion import decaying_sum
from pam_ident.effects import get_effect
from pam_ident.effects._history import dahl_operator, lugre_operator, relax, runs, stop_operator
from pam_ident.laws import get_law
from pam_ident.model import Model

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)


def path(seed=2, n=400, dense=1.0):
    """Uneven times, a wandering displacement with holds and one jump between two segments."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.02, 0.2, n)) / dense
    turns = np.interp(np.arange(n), np.arange(0, n + 40, 40), rng.uniform(0.0, 45.0, n // 40 + 1))
    direction = np.sign(np.diff(turns, prepend=turns[0] - (turns[1] - turns[0])))
    direction[direction == 0.0] = 1.0
    segment = (np.arange(n) >= 230).astype(int)
    t[230:] += 12.0
    x = turns + np.where(segment == 1, 3.0, 0.0)
    return Inputs(np.full(n, 0.3), x / 200.0, MUSCLE, direction, time=t, segment=segment, velocity=np.zeros(n))


def relax_by_steps(inputs, drive, tau, pieces=4000):
    """q̇ = ḋ − q/τ by many small implicit steps over a drive linear between samples, at once between segments."""
    q, out = 0.0, [0.0]
    for k in range(1, len(drive)):
        step, rise = inputs.time[k] - inputs.time[k - 1], drive[k] - drive[k - 1]
        if inputs.segment[k] != inputs.segment[k - 1]:
            q = (q + rise) * math.exp(-step / tau)
        else:
            h = step / pieces
            keep = (1.0 - 0.5 * h / tau) / (1.0 + 0.5 * h / tau)
            gain = rise / pieces / (1.0 + 0.5 * h / tau)
            power = keep**pieces
            q = q * power + gain * (1.0 - power) / (1.0 - keep)
        out.append(q)
    return np.array(out)


@pytest.mark.parametrize("tau", [0.05, 1.0, 30.0, 3000.0])
def test_relaxation_is_that_of_small_steps(tau):
    inputs = path()
    drive = inputs.contraction
    np.testing.assert_allclose(relax(inputs, drive, tau), relax_by_steps(inputs, drive, tau), rtol=1e-6, atol=1e-10)


@pytest.mark.parametrize("tau", [1e-4, 0.003, 0.05, 1e5])
def test_relaxation_stays_exact_where_the_decay_between_samples_is_huge_or_tiny(tau):
    inputs = path(n=3000)
    exact, q = [0.0], 0.0
    for k in range(1, len(inputs)):
        h, rise = (inputs.time[k] - inputs.time[k - 1]) / tau, inputs.contraction[k] - inputs.contraction[k - 1]
        jump = inputs.segment[k] != inputs.segment[k - 1]
        q = (q + rise) * math.exp(-h) if jump else q * math.exp(-h) - rise * math.expm1(-h) / h
        exact.append(q)
    np.testing.assert_allclose(relax(inputs, inputs.contraction, tau), exact, rtol=1e-9, atol=1e-13)


def test_two_samples_at_one_instant_take_the_whole_step():
    inputs = Inputs(
        np.ones(3), np.zeros(3), MUSCLE, np.ones(3), time=np.array([0.0, 1.0, 1.0]), segment=np.zeros(3, int)
    )
    out = relax(inputs, np.array([0.0, 0.0, 2.0]), 5.0)
    np.testing.assert_allclose(out, [0.0, 0.0, 2.0])


def test_a_held_muscle_relaxes_with_its_time_constant():
    t = np.array([0.0, 1.0, 3.0, 11.0])
    inputs = Inputs(np.ones(4), np.zeros(4), MUSCLE, np.ones(4), time=t, segment=np.zeros(4, int))
    q = relax(inputs, np.array([0.0, 0.1, 0.1, 0.1]), 4.0)
    np.testing.assert_allclose(q[2:] / q[1], np.exp([-0.5, -2.5]))


def test_a_lagging_pressure_is_the_relaxation_of_the_volume():
    """p_abs times q of q̇ = V̇/V − q/τ; on a slow stroke that is τ p_abs V̇/V."""
    inputs = path()
    ratio = np.array([(MUSCLE.radius_ratio(np.array(e))) for e in inputs.contraction])
    volume = np.log(ratio**2 * (1.0 - inputs.contraction))
    _, form = get_effect("pressure_lag:lagging")
    got = form.columns(inputs, {"tau": 0.4}, np.zeros(len(inputs))) @ [1.0, 1.01325]
    np.testing.assert_allclose(got, -(0.3 + 0.101325) * relax_by_steps(inputs, volume, 0.4), atol=1e-9)


def test_a_filling_follows_the_rate_as_a_first_order_lag():
    """ẇ = (V̇/V − w)/τ in small steps; where τ is short it is the rate itself."""
    inputs = path()
    speed = np.random.default_rng(3).uniform(-40.0, 40.0, len(inputs))
    inputs = replace(inputs, velocity=speed)
    _, form = get_effect("pressure_lag:filling")
    _, steady = get_effect("pressure_lag:affine")
    got = form.columns(inputs, {"tau": 0.4}, np.zeros(len(inputs)))[:, 1]
    rate = steady.columns(inputs, {}, np.zeros(len(inputs)))[:, 1]
    np.testing.assert_allclose(got, rate - relax_by_steps(inputs, rate, 0.4), atol=1e-9)
    at_once = form.columns(inputs, {"tau": 1e-4}, np.zeros(len(inputs)))[:, 1]
    np.testing.assert_allclose(at_once, rate, atol=0.02 * np.max(np.abs(rate)))


def test_a_valve_of_two_conductances_is_one_where_they_are_alike_and_slower_where_it_vents():
    inputs = path()
    _, valve = get_effect("pressure_lag:valve")
    _, plain = get_effect("pressure_lag:conductance")
    force = np.zeros(len(inputs))
    alike = valve.columns(inputs, {"tau": 0.2, "w": 1.0}, force)
    np.testing.assert_allclose(alike, plain.columns(inputs, {"tau": 0.2}, force), atol=1e-12)
    venting = inputs.direction < 0.0
    slower = valve.columns(inputs, {"tau": 0.2, "w": 3.0}, force)
    assert np.abs(slower[venting]).mean() > 1.5 * np.abs(alike[venting]).mean()


@pytest.mark.parametrize("shape", [(50,), (50, 3)])
def test_the_decaying_sum_is_that_of_a_loop(shape):
    rng = np.random.default_rng(8)
    decay, gain = np.exp(-rng.exponential(2.0, 50)), rng.standard_normal(shape)
    decay[[7, 30]] = 0.0
    out = [np.zeros(shape[1:])]
    for d, g in zip(decay, gain, strict=True):
        out.append(d * out[-1] + g)
    np.testing.assert_allclose(decaying_sum(decay, gain), out, rtol=1e-10, atol=1e-14)
    assert decaying_sum(decay[:0], gain[:0]).shape == (1, *shape[1:])


def stop_by_steps(x, width):
    z, out = 0.0, [0.0]
    for k in range(1, len(x)):
        z = min(max(z + (x[k] - x[k - 1]) / width, -1.0), 1.0)
        out.append(z)
    return np.array(out)


def dahl_by_steps(x, width, pieces=2000):
    z, out = 0.0, [0.0]
    for k in range(1, len(x)):
        step = (x[k] - x[k - 1]) / pieces
        sign = math.copysign(1.0, step)
        keep = (1.0 - 0.5 * abs(step) / width) / (1.0 + 0.5 * abs(step) / width)
        z = sign + (z - sign) * keep**pieces if step else z
        out.append(z)
    return np.array(out)


@pytest.mark.parametrize("width", [0.05, 0.7, 4.0, 80.0])
@pytest.mark.parametrize(("operator", "loop"), [(stop_operator, stop_by_steps), (dahl_operator, dahl_by_steps)])
def test_slipping_elements_are_those_of_small_steps(operator, loop, width):
    inputs = path(seed=5)
    got = operator(inputs, width)
    np.testing.assert_allclose(got, loop(inputs.displacement_mm, width), atol=1e-6)
    assert np.abs(got).max() <= 1.0 + 1e-12


def test_a_slipping_element_begins_where_it_was():
    """Bent back by 0.5 of its 4 mm before the record, it slips after 6 mm; Dahl's comes nearer to 1 exponentially."""
    x = np.array([0.0, 2.0, 4.0, 6.0, 8.0, 7.0])
    inputs = Inputs(np.ones(6), x / 200.0, MUSCLE, np.sign(np.r_[1.0, np.diff(x)]), segment=np.zeros(6, int))
    np.testing.assert_allclose(stop_operator(inputs, 4.0, begun=-0.5), [-0.5, 0.0, 0.5, 1.0, 1.0, 0.75], atol=1e-12)
    for made in (dahl_operator(inputs, 4.0, -0.5), lugre_operator(inputs, 4.0, 1.0, -0.5)):
        np.testing.assert_allclose(made[:5], 1.0 - 1.5 * np.exp(-x[:5] / 4.0), atol=1e-12)


@pytest.mark.parametrize("operator", [stop_operator, dahl_operator, partial(lugre_operator, level=1.0)])
def test_in_a_locked_muscle_travel_counts_by_how_far_it_slides_at_all(operator):
    """Nobody measures that: a braid that slides by a tenth, or ten times as far, bends its contacts alike."""
    inputs = replace(path(seed=5), locked=True)
    states = [operator(replace(inputs, slide=share * inputs.contraction), 4.0) for share in (0.1, 1.0, 10.0)]
    np.testing.assert_allclose(states[0], states[1], atol=1e-12)
    np.testing.assert_allclose(states[2], states[1], atol=1e-12)


def test_a_slipping_element_forgets_no_reversal_in_a_minor_loop():
    """Up 10, back 1, up 1 with a width of 4: on the way back by 1 of 8 mm, and returned to full slip."""
    x = np.array([0.0, 5.0, 10.0, 9.5, 9.0, 9.5, 10.0, 11.0])
    direction = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
    inputs = Inputs(np.ones(8), x / 200.0, MUSCLE, direction, segment=np.zeros(8, int))
    np.testing.assert_allclose(stop_operator(inputs, 4.0), [0, 1, 1, 0.875, 0.75, 0.875, 1, 1], atol=1e-12)


def test_noise_of_the_sensor_within_a_stroke_does_not_shake_a_slipping_element():
    x = np.linspace(0.0, 40.0, 400)
    seen = x + 0.05 * np.random.default_rng(0).standard_normal(400)
    inputs = Inputs(np.ones(400), seen / 200.0, MUSCLE, np.ones(400), segment=np.zeros(400, int))
    z = stop_operator(inputs, 0.1)
    np.testing.assert_allclose(z[20:], 1.0)


def test_runs_are_cut_at_reversals_and_between_segments():
    direction = np.array([1.0, 1, -1, -1, 1, 1, 1])
    inputs = Inputs(np.ones(7), np.zeros(7), MUSCLE, direction, segment=np.array([0, 0, 0, 0, 0, 1, 1]))
    assert [(r.start, r.stop) for r in runs(inputs)] == [(0, 2), (2, 4), (4, 5), (5, 7)]


def test_creep_is_the_relaxation_of_its_drive():
    inputs = path()
    zero = np.zeros(len(inputs))
    _, single = get_effect("creep")
    q = relax_by_steps(inputs, inputs.contraction, 10.0)
    np.testing.assert_allclose(single.columns(inputs, {"tau": 10.0}, zero)[:, 0], -q, atol=1e-9)
    _, prony = get_effect("creep:prony_3")
    np.testing.assert_allclose(prony.columns(inputs, {"tau": 10.0}, zero)[:, 1], -q, atol=1e-9)
    assert prony.columns(inputs, {"tau": 10.0}, zero)[-1, 0] == pytest.approx(
        -relax_by_steps(inputs, inputs.contraction, 1.0)[-1], abs=1e-9
    )
    _, driven = get_effect("creep:force_driven")
    ideal = get_law("chou_hannaford").force(inputs.pressure, inputs.contraction, MUSCLE, {})
    got = driven.columns(inputs, {"tau": 10.0}, ideal)[:, 0]
    np.testing.assert_allclose(got, relax_by_steps(inputs, ideal, 10.0), rtol=1e-6, atol=1e-6)


def test_creep_that_began_before_the_record_starts_from_what_the_first_sample_finds():
    """As if the muscle had been pulled there from rest in no time, or a share of that."""
    inputs = replace(path(n=200), segment=np.zeros(200, int))
    e, t = np.r_[0.0, inputs.contraction], np.r_[inputs.time[0] - 1e-9, inputs.time]
    pulled = Inputs(np.full(201, 0.3), e, MUSCLE, np.ones(201), time=t, segment=np.zeros(201, int))
    _, begun = get_effect("creep:free_begun")
    for new in (1.0, 0.4):
        got = begun.columns(inputs, {"tau": 10.0, "new": new}, np.zeros(200))
        for k, tau in enumerate((1.0, 10.0, 100.0)):
            whole = relax_by_steps(pulled, e, tau)[1:]
            rested = relax_by_steps(inputs, inputs.contraction, tau)
            np.testing.assert_allclose(got[:, 4 * k], -(new * whole + (1.0 - new) * rested), atol=1e-8)


def test_creep_that_follows_brings_a_share_of_a_step_late():
    inputs = replace(path(n=200), segment=np.zeros(200, int))
    step = np.where(np.arange(200) >= 50, 100.0, 0.0)
    _, form = get_effect("creep:following")
    force = step + 0.2 * form.columns(inputs, {"tau": 4.0}, step)[:, 0]
    since = inputs.time[60] - 0.5 * (inputs.time[49] + inputs.time[50])
    assert force[40] == 0.0 and force[-1] == pytest.approx(100.0, abs=2.0)
    assert force[60] == pytest.approx(100.0 - 20.0 * math.exp(-since / 4.0), abs=0.5)


def test_presliding_may_grow_with_pressure():
    inputs = replace(path(seed=7), pressure=np.linspace(0.1, 0.5, 400))
    (_, dahl), (_, pressed) = get_effect("presliding_hysteresis:dahl"), get_effect("presliding_hysteresis:pressed")
    alone, both = (f.columns(inputs, {"x_s": 2.0}, np.zeros(len(inputs))) for f in (dahl, pressed))
    np.testing.assert_allclose(both, np.column_stack([alone[:, 0], alone[:, 0] * inputs.pressure]), atol=1e-12)


def test_the_maxwell_slip_form_has_elements_of_three_widths():
    inputs = path(seed=7)
    _, form = get_effect("presliding_hysteresis:maxwell_slip_3")
    got = form.columns(inputs, {"x_s": 2.0}, np.zeros(len(inputs)))
    for column, width in zip(got.T, (0.6, 2.0, 6.0), strict=True):
        np.testing.assert_allclose(column, -stop_by_steps(inputs.displacement_mm, width), atol=1e-12)


@pytest.mark.parametrize(("label", "share"), [("creep:force_driven", -0.9), ("creep:following", 0.9)])
def test_a_force_that_acts_back_through_its_history_is_the_one_that_it_leads_to(label, share):
    """Once each sample was solved for by itself, which does not settle, on a cylinder some newtons off."""
    inputs, model = path(n=1000, seed=7), Model.build("chou_hannaford", [label])
    values = model.neutral(inputs) | {f"creep.{model.terms[0].form.linear[0].name}": share}
    force = model.force(inputs, values)
    columns, fixed = model.design(inputs, values, force)
    again = fixed + columns @ [values[p.name] for p in model.linear]
    assert np.ptp(force - model.law.force(inputs.pressure, inputs.contraction, MUSCLE, values)) > 10.0
    np.testing.assert_allclose(again, force, rtol=0.0, atol=1e-7)
