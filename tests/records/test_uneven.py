"""Clocks that jitter, turns that are round and sensors that are coarse, against the motion that was commanded."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.records import build_record
from pam_ident.records.roughness import position_noise

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)


def unevenly(n, step, share, seed=5):
    """Times in s whose steps scatter by a share of their length to either side."""
    return (np.arange(n) + np.random.default_rng(seed).uniform(-share, share, n)) * step


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_clock_that_jitters_is_no_noise_of_the_position(noise):
    t = unevenly(2000, 0.1, 0.35)
    seen = 3.0 * t + noise * np.random.default_rng(6).standard_normal(len(t))
    assert position_noise(seen, t) == pytest.approx(noise, rel=0.1, abs=1e-9)


def test_the_bend_of_a_sine_is_no_noise_of_the_position():
    """Fourth differences of A sin are A (2 sin(π/24))⁴ at most with 24 samples a wave; of noise, √70 deviations."""
    t = np.arange(480) / 24.0
    most = 20.0 * (2.0 * np.sin(np.pi / 24.0)) ** 4 / np.sqrt(70.0)
    assert position_noise(20.0 * np.sin(2.0 * np.pi * t + 0.1), t) < most / 0.6745


def test_steady_inputs_of_an_uneven_sine_stay_where_the_muscle_was():
    t = unevenly(600, 0.5, 0.35)
    x = 10.0 - 10.0 * np.cos(2.0 * np.pi * t / 15.0)
    record = build_record("r", MUSCLE, np.full_like(t, 0.3), x / 200.0, 800.0 - x, time=t)
    np.testing.assert_allclose(record.steady.displacement_mm, x, atol=0.01)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.2])
def test_behind_a_round_turn_the_next_stroke_begins(share):
    t = unevenly(600, 0.5, share) + 0.2
    phase = 2.0 * np.pi * t / 15.0
    x = 10.0 - 10.0 * np.cos(phase)
    found = build_record("r", MUSCLE, np.full_like(t, 0.3), x / 200.0, 800.0 - x, time=t).inputs
    sure = np.abs(np.sin(phase)) > np.sin(2.0 * np.pi * 0.5 * (0.5 + share) / 15.0)  # not the sample next to the turn
    sure &= found.moving
    np.testing.assert_array_equal(found.direction[sure], np.sign(np.sin(phase))[sure])


def test_the_steps_of_a_coarse_pressure_sensor_are_no_isobars():
    rng = np.random.default_rng(7)
    t = np.arange(4000) * 0.1
    x = 10.0 - 10.0 * np.cos(2.0 * np.pi * t / 8.0)
    pressure = np.round(np.repeat([0.2, 0.4], 2000) + 0.0003 * rng.standard_normal(4000), 4)
    record = build_record("r", MUSCLE, pressure, x / 200.0, 800.0 - x, time=t)
    np.testing.assert_array_equal(record.levels, [0.2, 0.4])
