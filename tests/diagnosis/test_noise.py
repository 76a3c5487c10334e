"""Noise is told from signal by size and colour."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.core.recursion import decaying_sum
from pam_ident.diagnosis.colour import (
    COARSE,
    MEMORY_SAMPLES,
    SHARES,
    Seen,
    _likeliest,
)
from pam_ident.diagnosis.noise import Noise, estimate_noise
from pam_ident.diagnosis.track import TrackError
from pam_ident.diagnosis.whitening import filter_gains, innovations
from pam_ident.records import build_record

SPECIMEN = Specimen("bench", 200.0, 10.0, 25.4, 1.5)


@pytest.fixture
def record():
    time = np.arange(4000) * 0.1
    x = 20.0 - 20.0 * np.cos(2.0 * np.pi * time / 40.0)
    return build_record("loop", SPECIMEN, np.full(4000, 0.3), x / 200.0, 400.0 - 5.0 * x, time=time)


def coloured(rho, n=4000, seed=5):
    white = np.random.default_rng(seed).standard_normal(n)
    return np.sqrt(1 - rho**2) * decaying_sum(np.full(n - 1, rho), white[:-1])


def test_recursion_against_a_plain_loop():
    rng = np.random.default_rng(2)
    decay, gain = rng.uniform(0.0, 1.0, 50), rng.standard_normal((50, 3))
    expected = np.zeros((51, 3))
    for i in range(50):
        expected[i + 1] = decay[i] * expected[i] + gain[i]
    np.testing.assert_allclose(decaying_sum(decay, gain), expected, atol=1e-13)


def test_innovations_have_the_likelihood_of_the_full_covariance():
    rng = np.random.default_rng(3)
    n, share, rho, extra = 60, 0.7, 0.8, rng.uniform(0.0, 0.5, 60)
    decay = np.full((n, 1), rho)
    decay[0] = 0.0
    gain, spread = (v[:, 0] for v in filter_gains(decay, np.array([share]), extra))
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    covariance = share * rho**lag + np.diag(1.0 - share + extra)
    z = rng.standard_normal(n)
    left = innovations(z[:, None], decay[:, 0], gain)[:, 0] / spread
    assert np.sum(left**2) == pytest.approx(z @ np.linalg.solve(covariance, z), rel=1e-10)
    assert 2.0 * np.sum(np.log(spread)) == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-10)


def test_white_noise_is_called_white(record):
    noise = estimate_noise(record, 2.0 * np.random.default_rng(1).standard_normal(4000), np.zeros(4000), 8)
    assert not noise.coloured and noise.sigma == pytest.approx(2.0, rel=0.03)


@pytest.mark.parametrize("rho", [0.5, 0.9])
def test_coloured_noise_is_whitened_and_keeps_its_size(record, rho):
    residual = 3.0 * coloured(rho)
    noise = estimate_noise(record, residual, np.zeros(4000), 8)
    left = noise.whiten(residual)
    assert noise.coloured and noise.sigma == pytest.approx(3.0, rel=0.2)
    assert abs(np.corrcoef(left[1:], left[:-1])[0, 1]) < 0.05
    assert np.std(left) == pytest.approx(1.0, rel=0.03)


def test_a_little_white_noise_beside_slow_noise_leaves_the_whole_as_large_as_it_is(record):
    white = np.random.default_rng(13).standard_normal(4000)
    residual = 4.0 * (np.sqrt(0.97) * coloured(np.exp(-1.0 / 13.0)) + np.sqrt(0.03) * white)
    noise = estimate_noise(record, residual, np.zeros(4000), 8)
    assert noise.share in (0.95, 0.98) and noise.whole == pytest.approx(np.std(residual), rel=0.1)


def test_noise_of_the_driven_sensors_is_not_taken_where_it_is_less_likely(record):
    seen = record.inputs.displacement_mm + 0.02 * np.random.default_rng(6).standard_normal(4000)
    noisy = build_record("loop", SPECIMEN, np.full(4000, 0.3), seen / 200.0, record.force, time=record.inputs.time)
    slope = np.where(np.arange(4000) % 50 == 0, 80.0, 0.0)  # steep here and there, where nothing is rougher
    with_it, without = (estimate_noise(noisy, 3.0 * coloured(0.9), v, 8) for v in (slope, np.zeros(4000)))
    assert with_it.deviance == without.deviance and with_it.whole == without.whole


def test_a_spike_is_set_aside_and_a_bump_is_not(record):
    residual = np.random.default_rng(4).standard_normal(4000)
    residual[100] += 30.0
    residual[2100:2120] += 8.0
    noise = estimate_noise(record, residual, np.zeros(4000), 8)
    assert noise.outlier[100] and not noise.outlier[2100:2120].any()


def test_columns_are_whitened_by_blocks_as_by_the_full_covariance():
    rng = np.random.default_rng(6)
    n, share = 53, np.array([0.6])
    decay = rng.uniform(0.2, 0.99, (n, 1))
    decay[0] = 0.0
    gain, spread = filter_gains(decay, share, np.zeros(n))
    outlier = np.zeros(n, bool)
    noise = Noise(2.0, 2.0, 0.6, 3.0, "samples", decay[:, 0], gain[:, 0], spread[:, 0], outlier, 0.0)
    kept = np.array([[np.prod(decay[min(i, j) + 1 : max(i, j) + 1]) for j in range(n)] for i in range(n)])
    covariance = 4.0 * (share * kept + (1.0 - share) * np.eye(n))
    columns = rng.standard_normal((n, 5))
    white = noise.whiten(columns)
    np.testing.assert_allclose(white.T @ white, columns.T @ np.linalg.solve(covariance, columns), rtol=1e-9)
    np.testing.assert_allclose(noise.whiten(columns[:, 2]), white[:, 2], atol=1e-12)
    single = noise.whiten(columns.astype(np.float32))
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, white, atol=1e-5)


def test_an_outlier_neither_counts_nor_spoils_its_neighbours():
    n = 40
    decay = np.full((n, 1), 0.8)
    decay[0] = 0.0
    gain, spread = filter_gains(decay, np.array([1.0]), np.zeros(n))
    noise = Noise(1.0, 1.0, 1.0, 4.5, "samples", decay[:, 0], gain[:, 0], spread[:, 0], np.arange(n) == 20, 0.0)
    one, other = np.ones(n), np.ones(n)
    other[20] = 1e6
    assert noise.whiten(other)[20] == 0.0
    np.testing.assert_array_equal(noise.whiten(one), noise.whiten(other))


def test_the_likeliest_colour_is_that_of_the_whole_grid():
    advance = np.ones(1500)
    z = coloured(0.85, 1500) + 0.6 * np.random.default_rng(8).standard_normal(1500)
    places = [(k, j) for k in range(len(MEMORY_SAMPLES)) for j in range(len(SHARES))]
    seen = Seen(z[:, None], np.zeros(1500), np.zeros(1500, bool), None)
    whole = seen.deviances(places, advance)
    place, least = _likeliest(lambda some: seen.deviances(some, advance), COARSE)
    assert place == places[int(np.argmin(whole))] and least == pytest.approx(min(whole), rel=1e-12)


@pytest.mark.parametrize("size", [1.0, 8.0])
def test_slow_noise_is_told_from_what_the_track_of_each_stroke_is_off_by(size):
    """Strokes have 20 rows, in 2 s or in 20; in each the track is off along two columns, and the force steep. That is
    0.4 of the slow noise's variance, or 0.006, but more than it changes by from row to row."""
    rng, rows, strokes = np.random.default_rng(9), 20, 100
    n = rows * strokes
    step = np.repeat(np.where(np.arange(strokes) % 20 < 10, 0.1, 1.0), rows)
    time, memory, slope = np.cumsum(step), 10.0, np.full(n, 40.0)
    kept = np.exp(-step[1:] / memory)
    slow = decaying_sum(kept, (np.sqrt(1.0 - kept**2) * rng.standard_normal(n - 1))[:, None])[:, 0]
    along = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, rows), 2))[0]
    blocks = tuple((np.arange(k, k + rows), 0.05 * along) for k in range(0, n, rows))
    off = np.concatenate([block @ rng.standard_normal(2) for _, block in blocks])
    x = 20.0 - 20.0 * np.cos(np.pi * np.arange(n) / rows)
    record = build_record("loop", SPECIMEN, np.full(n, 0.3), x / 200.0, 400.0 - 5.0 * x, time=time)
    unsure = TrackError(blocks, np.zeros(n), np.zeros(n), False, 0.05, np.zeros(n, bool))
    slow *= size
    residual = slow + slope * off
    noise = estimate_noise(record, residual, slope, 8, outlier=np.zeros(n, bool), unsure=unsure)
    left = noise.whiten(residual)
    assert noise.shared is not None
    assert noise.clock == "seconds" and memory / 2.5 < noise.memory < memory * 2.5  # its likelihood is flat
    assert noise.sigma == pytest.approx(np.std(slow), rel=0.3) and np.std(left) == pytest.approx(1.0, rel=0.05)
    assert abs(np.corrcoef(left[1:], left[:-1])[0, 1]) < 0.1


def test_samples_set_aside_leave_the_colour_as_it_is(record):
    residual = decaying_sum(np.full(3999, 0.98), 0.2 * np.random.default_rng(7).standard_normal((3999, 1)))[:, 0]
    none, some = np.zeros(4000, bool), np.arange(4000) % 40 == 20
    whole = estimate_noise(record, residual, np.zeros(4000), 8, outlier=none)
    found = estimate_noise(record, residual, np.zeros(4000), 8, outlier=some)
    assert (found.share, found.memory) == (whole.share, whole.memory)
    assert found.sigma == pytest.approx(whole.sigma, rel=0.05)
