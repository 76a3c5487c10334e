"""Effects that are tried only where they are asked for, against figures by hand and derivations of their own."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pam_ident.core import Inputs, Specimen
from pam_ident.core.recursion import Live
from pam_ident.effects import catalogue, get_effect

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 2.0)
OPTIONAL = ("end_contact", "first_cycle", "moving_mass", "nonlocal_hysteresis", "ogden_bladder")


def inputs(x, p=0.3, **more):
    """A way in mm, shape (n,), with the direction that it has."""
    x = np.asarray(x, float)
    direction = np.sign(np.diff(x, prepend=2.0 * x[0] - x[1] if len(x) > 1 else x[0] - 1.0))
    given = {"direction": direction, "moving": direction != 0.0, "segment": np.zeros(len(x), int)} | more
    return Inputs(np.full(len(x), p), x / MUSCLE.initial_length_mm, MUSCLE, **given)


def columns(name, given, **shape):
    return get_effect(name)[1].columns(given, shape, np.zeros(len(given)))


@pytest.mark.parametrize("name", OPTIONAL)
def test_they_are_in_the_catalogue_and_not_tried_by_themselves(name):
    assert not catalogue()[name].candidate and catalogue()[name].follows


# --- moving mass -------------------------------------------------------------------------------------------------


def swinging(step):
    """10 mm to and fro at 3 rad/s: 90 mm/s² at most."""
    time = np.arange(0.0, 4.0, step)
    speed = 30.0 * np.cos(3.0 * time)
    return inputs(20.0 + 10.0 * np.sin(3.0 * time), time=time, velocity=speed, direction=np.sign(speed))


def test_a_kilogram_that_is_accelerated_is_newtons_the_other_way():
    """2 kg at a constant 1.5 m/s²: 3 N less pull on the load cell, but not at the corners of the motion."""
    time = np.arange(6.0) / 10.0
    given = inputs(0.5 * 1500.0 * time**2 + time, time=time, velocity=1500.0 * time + 1.0)
    np.testing.assert_allclose(2.0 * columns("moving_mass", given)[1:-1, 0], -3.0)
    stopped = replace(given, moving=np.array([1, 1, 1, 1, 0, 0], bool))
    np.testing.assert_allclose(2.0 * columns("moving_mass", stopped)[:, 0], [-0.0, -3.0, -3.0, 0.0, 0.0, 0.0])


def test_a_turn_without_a_hold_is_no_blow():
    """To and fro at constant speeds that differ: what lies between is over within a sample, and not in a record."""
    time = np.arange(12.0) / 10.0
    speed = np.where(time < 0.55, 100.0, -80.0)
    given = inputs(10.0 * np.cumsum(speed) / 100.0, time=time, velocity=speed, direction=np.sign(speed))
    assert not columns("moving_mass", given).any()
    swing = swinging(0.02)
    turn = int(np.flatnonzero(np.diff(np.sign(swing.velocity)))[0])
    at_turn = -1e-3 * -90.0 * np.sin(3.0 * swing.time)[turn : turn + 2]
    np.testing.assert_allclose(columns("moving_mass", swing)[turn : turn + 2, 0], at_turn, rtol=0.01)


@pytest.mark.parametrize("step", [0.01, 0.002])
def test_live_the_acceleration_is_half_a_step_behind(step):
    given = swinging(step)
    memory, found = None, []
    for k in range(len(given)):
        live = Live(memory)
        found.append(columns("moving_mass", replace(given.take(slice(k, k + 1)), live=live))[0, 0])
        memory = live.slots
    truth = -1e-3 * -90.0 * np.sin(3.0 * given.time)
    np.testing.assert_allclose(found[1:], truth[1:], atol=0.55 * step * 0.27)
    np.testing.assert_allclose(columns("moving_mass", given)[1:-1, 0], truth[1:-1], atol=0.27 * 3.0 * step**2)


# --- nonlocal hysteresis -----------------------------------------------------------------------------------------


def by_steps(x, width, growth=0.0):
    z, out = 0.0, [0.0]
    for before, now in pairwise(x):
        z = min(max(z + (now - before) / width, -(1.0 + growth * now / 200.0)), 1.0)
        out.append(z)
    return np.array(out)


def legs(*turns, step=0.25):
    """A way in mm from one turning point to the next, shape (n,)."""
    parts = [np.arange(a, b, math.copysign(step, b - a)) for a, b in pairwise(turns)]
    return np.concatenate([*parts, turns[-1:]])


@pytest.mark.parametrize("growth", [-1.0, 0.0, 6.0])
def test_its_operators_yield_at_a_force_that_grows_on_the_extension_branch(growth):
    x = legs(0.0, 40.0, 10.0, 25.0, 15.0, 35.0, 5.0)
    got = columns("nonlocal_hysteresis", inputs(x), r=8.0, q=growth)
    for column, width in zip(got.T, (2.0, 4.0, 8.0), strict=True):
        np.testing.assert_allclose(column, -by_steps(x, width, growth), atol=1e-12)
    assert got[-1] == pytest.approx([1.0 + growth * 5.0 / 200.0] * 3)


def test_an_asymmetry_that_is_the_same_everywhere_would_be_a_constant_force():
    """Why it grows along the stroke: once slid, limits of −0.4 and 1 are those of ±0.7 and 0.3 more."""
    x = legs(0.0, 40.0, 10.0, 25.0, 15.0, 35.0, 0.0)

    def limited(low, high, width):
        z, out = 0.0, [0.0]
        for before, now in pairwise(x):
            z = min(max(z + (now - before) / width, low), high)
            out.append(z)
        return np.array(out)

    slid = 40
    np.testing.assert_allclose(limited(-0.4, 1.0, 4.0)[slid:], 0.3 + limited(-0.7, 0.7, 4.0)[slid:], atol=1e-12)


def test_the_growing_form_is_symmetric_and_grows_with_contraction():
    x = legs(0.0, 40.0, 10.0, 25.0, 0.0)
    got = columns("nonlocal_hysteresis:growing", inputs(x), r=8.0)
    expected = -np.column_stack([by_steps(x, width) for width in (2.0, 4.0, 8.0)])
    np.testing.assert_allclose(got, np.hstack([expected, expected * x[:, None] / 200.0]), atol=1e-12)


def test_a_minor_loop_closes_and_is_wiped_out():
    """Back where a smaller loop began, the force is that of before, and goes on as if there had been no loop."""
    x, without = legs(0.0, 40.0, 20.0, 23.0, 20.0, 0.0), legs(0.0, 40.0, 0.0)
    for name in ("nonlocal_hysteresis", "nonlocal_hysteresis:curved"):
        shape = {"r": 12.0, "q": 4.0} if name == "nonlocal_hysteresis" else {"r": 12.0}
        loop, plain = (columns(name, inputs(way), **shape) for way in (x, without))
        at, back = (int(k) for k in np.flatnonzero(x == 20.0)[1:])
        np.testing.assert_allclose(loop[back], loop[at], atol=1e-12)
        np.testing.assert_allclose(loop[back:], plain[np.flatnonzero(without == 20.0)[1] :], atol=1e-12)
        assert np.abs(loop[at + 12] - loop[at]).max() > 0.2


def test_its_curve_has_parts_of_their_own_near_full_force():
    x = legs(0.0, 40.0, 0.0)
    got = -columns("nonlocal_hysteresis:curved", inputs(x), r=8.0)
    state = sum(by_steps(x, width) for width in (2.0, 4.0, 8.0)) / 3.0
    expected = np.column_stack(
        [state, np.where(state > 0.5, state - 0.5, 0.0), np.where(state < -0.5, state + 0.5, 0.0)]
    )
    np.testing.assert_allclose(got, expected, atol=1e-12)


# --- Ogden's rubber ----------------------------------------------------------------------------------------------


def stretches(e):
    """Along, around and through an incompressible thin tube whose threads keep length and turns."""
    thread = 200.0 / math.cos(math.radians(25.0))
    around = np.sqrt(thread**2 - (200.0 * (1.0 - e)) ** 2) / (thread * math.sin(math.radians(25.0)))
    return 1.0 - e, around, 1.0 / ((1.0 - e) * around)


def pull(energy, e, h=1e-5):
    """Force in N of a stored energy in N·mm, by virtual work."""
    return -(energy(e + h) - energy(e - h)) / (2.0 * h) / 200.0


@pytest.mark.parametrize("alpha", [1.3, 2.0, 5.0, -2.0])
def test_ogden_is_the_virtual_work_of_its_strain_energy(alpha):
    def energy(e):
        return sum(s**alpha for s in stretches(e)) / alpha * 2.0 * math.pi * 10.0 * 2.0 * 200.0

    e = np.array([0.0, 0.03, 0.1, 0.2, 0.26])
    named = {1.3: 0, 5.0: 1, -2.0: 2}
    got = columns("ogden_bladder:treloar", inputs(200.0 * e))[:, named[alpha]] if alpha in named else None
    if alpha > 0.0:
        alone = columns("ogden_bladder", inputs(200.0 * e), alpha=alpha)[:, 0]
        np.testing.assert_allclose(alone, pull(energy, e), rtol=1e-6, atol=1e-4)
    if got is not None:
        np.testing.assert_allclose(got, pull(energy, e), rtol=1e-6, atol=1e-4)


def test_the_powers_two_and_minus_two_are_mooney_and_rivlin():
    """μ/2 (I1 − 3) and −μ/2 (I2 − 3)."""
    given = inputs([0.0, 10.0, 30.0, 50.0])
    mooney = columns("bladder_elasticity:mooney_rivlin", given)
    np.testing.assert_allclose(
        columns("ogden_bladder", given, alpha=2.0)[:, 0], 0.5 * mooney[:, 0], rtol=1e-9, atol=1e-9
    )
    last = columns("ogden_bladder:treloar", given)[:, 2]
    np.testing.assert_allclose(last, -0.5 * mooney[:, 1], rtol=1e-9, atol=1e-9)


# --- first stroke, ends ------------------------------------------------------------------------------------------


def test_the_first_stroke_ends_where_the_motion_turns_and_holds_before_it_are_no_part():
    given = inputs(
        [0, 0, 5, 10, 10, 5, 0, 5, 10, 5],
        direction=np.array([-1, -1, 1, 1, 1, -1, -1, 1, 1, -1.0]),
        moving=np.array([0, 0, 1, 1, 0, 1, 1, 1, 1, 1], bool),
        segment=np.array([0, 0, 0, 0, 0, 0, 0, 1, 1, 1]),
    )
    first = np.array([0, 0, 1, 1, 1, 0, 0, 0, 0, 0.0])
    np.testing.assert_array_equal(columns("first_cycle", given)[:, 0], first)
    shaped = columns("first_cycle:shaped", given)
    np.testing.assert_allclose(shaped[:, 1], first * given.contraction)
    again = np.array([0, 0, 1, 1, 1, 0, 0, 1, 1, 0.0])
    np.testing.assert_allclose(columns("first_cycle:rested", given), np.column_stack([again, 0.3 * again]))


def test_a_muscle_that_never_moves_has_no_first_stroke():
    still = inputs([5.0, 5.0, 5.0], direction=np.ones(3), moving=np.zeros(3, bool))
    assert not columns("first_cycle", still).any() and not columns("first_cycle:rested", still).any()


def test_a_contact_pushes_back_beyond_its_place_alone():
    """10 N/mm from 15 % of 200 mm on: at 34 mm it takes 40 N of the pull, after Hertz 80 N."""
    given = inputs([0.0, 29.0, 30.0, 34.0])
    np.testing.assert_allclose(10.0 * columns("end_contact", given, e_c=0.15)[:, 0], [0.0, 0.0, 0.0, -40.0], atol=1e-9)
    hertz = 10.0 * columns("end_contact:hertz", given, e_c=0.15)[:, 0]
    np.testing.assert_allclose(hertz, [0.0, 0.0, 0.0, -80.0], atol=1e-6)
    long = 10.0 * columns("end_contact:long", given, e_c=0.02)[:, 0]
    np.testing.assert_allclose(long, [40.0, 0.0, 0.0, 0.0], atol=1e-9)
