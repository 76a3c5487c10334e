"""What comes back with every cycle is taken out of the noise, and nothing else is."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis.noise import estimate_noise
from pam_ident.diagnosis.repeats import comes_back, without_repeats
from pam_ident.records import build_record

SIGMA = 2.0
MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)


@pytest.fixture(scope="module")
def record():
    """Three isobars of five cycles to and fro, 1 s of rest at each end; the force is of no matter."""
    pressure, time, x, clock = [], [], [], 0.0
    for p in (0.1, 0.3, 0.5):
        for _ in range(5):
            for sign in (1.0, -1.0):
                at = (np.arange(40) + 0.5) / 40
                pressure += [np.full(50, p)]
                time += [clock + 4.0 * at, clock + 4.0 + np.arange(10) / 10 + 0.05]
                x += [40.0 * at if sign > 0 else 40.0 * (1.0 - at), np.full(10, 40.0 * (sign > 0))]
                clock += 5.0
        clock += 20.0
    x, time, pressure = np.concatenate(x), np.concatenate(time), np.concatenate(pressure)
    x = x + 0.01 * np.random.default_rng(1).standard_normal(len(x))
    return build_record("r", MUSCLE, pressure, x / 200.0, 800.0 - x, time=time)


def slow(record, rng, seconds):
    """A first-order process of standard deviation SIGMA with a correlation time in s, shape (n,)."""
    decay = np.exp(-np.diff(record.inputs.time) / seconds)
    found = [rng.standard_normal()]
    for keep in decay:
        found.append(keep * found[-1] + np.sqrt(1.0 - keep**2) * rng.standard_normal())
    return SIGMA * np.array(found)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("seconds", [1e-3, 0.5, 10.0, 100.0, 1000.0])
def test_noise_of_any_colour_is_left_as_it_is(record, seconds, seed):
    residual = slow(record, np.random.default_rng(seed), seconds)
    assert without_repeats(record, residual, np.ones(len(residual), bool)) is residual


@pytest.mark.parametrize("seed", range(4))
def test_a_force_that_comes_back_with_each_stroke_and_hold_is_no_noise(record, seed):
    white = SIGMA * np.random.default_rng(seed).standard_normal(len(record))
    inputs = record.inputs
    since = inputs.time - inputs.time[np.searchsorted(record.stroke, record.stroke)]
    misfit = 4.0 * np.exp(-since) * np.cos(5.0 * since) * inputs.direction
    noise = estimate_noise(record, white + misfit, np.zeros(len(record)), 0)
    assert noise.sigma == pytest.approx(SIGMA, rel=0.1)
    alone = estimate_noise(record, white, np.zeros(len(record)), 0)
    assert noise.deviance > alone.deviance + 100.0


@pytest.mark.parametrize("seed", range(4))
def test_a_force_that_differs_by_direction_is_no_slow_noise(record, seed):
    """It falls along each cycle; and slow noise beside it stays noise of its own size."""
    rng = np.random.default_rng(seed)
    white, wander = SIGMA * rng.standard_normal(len(record)), slow(record, rng, 30.0)
    gap = 6.0 * record.inputs.direction * (1.0 + np.sin(record.inputs.displacement_mm))
    rows = np.ones(len(record), bool)
    own = without_repeats(record, white + gap, rows)
    assert np.sqrt(np.mean(own**2)) == pytest.approx(SIGMA, rel=0.1)
    both = without_repeats(record, white + wander + gap, rows)
    assert np.sqrt(np.mean(both**2)) == pytest.approx(np.sqrt(np.mean((white + wander) ** 2)), rel=0.15)


def test_rounding_to_a_gauge_s_steps_comes_back_and_is_noise_still(record):
    clean = 500.0 - 8.0 * np.round(record.inputs.displacement_mm, 1)
    rounded = np.round((clean + 0.02 * np.random.default_rng(2).standard_normal(len(clean))) / 3.0) * 3.0
    gauged = replace(record, force=rounded)
    residual = rounded - clean
    assert without_repeats(gauged, residual, np.ones(len(clean), bool)) is residual


@pytest.mark.parametrize(("size", "comes"), [(0.0, False), (4.0, True)])
def test_an_error_of_the_load_cells_own_comes_back_with_the_force(size, comes):
    """A converter's ladder, in strokes of which none repeats another; and slow noise, which does not know the force."""
    rng, n, strokes = np.random.default_rng(5), 60, 80
    ends = rng.uniform(0.0, 40.0, strokes + 1)
    x = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b in pairwise(ends)])
    pressure, time = np.repeat([0.15, 0.3, 0.45, 0.6], len(x) // 4), 0.1 * np.arange(len(x))
    force = MUSCLE.ideal_force(pressure, x / 200.0)
    record = build_record("r", MUSCLE, pressure, x / 200.0, force, time=time)
    noise = slow(record, rng, 3.0) + SIGMA * rng.standard_normal(len(x))
    residual = noise + size * (force / 45.0 - np.round(force / 45.0)) * np.sqrt(12.0)
    record = replace(record, force=force + residual)
    rows = np.ones(len(x), bool)
    assert (comes_back(record, residual, rows) > 0.5) == comes
    own = without_repeats(record, residual, rows)
    assert 0.9 < np.std(own) / np.std(noise) < 1.2 and (own is residual) == (not comes)
