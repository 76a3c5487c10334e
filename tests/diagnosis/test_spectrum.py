"""Lines are found at any period that the record can show, and none where there is only noise."""

import numpy as np
import pytest

from pam_ident.core.recursion import decaying_sum
from pam_ident.diagnosis.spectrum import beats


@pytest.fixture
def time():
    """Strokes of 40 samples at three speeds, with a rest between: 0.05, 0.2 and 1 s from sample to sample."""
    rng = np.random.default_rng(4)
    gaps = np.concatenate([np.r_[np.full(39, step), 4.0] for step in rng.choice([0.05, 0.2, 1.0], 120)])
    return np.cumsum(gaps)


@pytest.mark.parametrize("period", [0.9, 3.7, 60.0])
def test_a_beat_is_found_at_its_period(time, period):
    rng = np.random.default_rng(5)
    residual = np.sin(2.0 * np.pi * time / period + 1.0) + rng.standard_normal(len(time))
    resolution = period**2 / np.ptp(time)
    assert beats(time, residual)[0] == pytest.approx(period, abs=0.5 * resolution)


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_noise_has_no_lines(time, rho):
    white = np.random.default_rng(6).standard_normal(len(time))
    noise = decaying_sum(np.full(len(time) - 1, rho), white[:-1])
    assert beats(time, noise) == []


def test_a_beat_stands_out_of_coloured_noise(time):
    white = np.random.default_rng(7).standard_normal(len(time))
    noise = decaying_sum(np.full(len(time) - 1, 0.9), white[:-1])
    found = beats(time, noise + 2.0 * np.sin(2.0 * np.pi * time / 5.3))
    assert found[0] == pytest.approx(5.3, rel=2e-3)


def test_too_few_samples_have_no_spectrum():
    assert beats(np.arange(6.0), np.ones(6)) == []
    assert beats(np.zeros(50), np.ones(50)) == []
