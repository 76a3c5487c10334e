"""A far sample in noise with heavy tails is no pattern."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.select import _outlives_tails
from pam_ident.diagnosis.tails import deviance_saved
from pam_ident.model import Model
from pam_ident.records import build_record


def test_in_normal_noise_the_fall_is_that_of_the_squares():
    after = np.random.default_rng(1).standard_normal(4000)
    before = after + np.r_[np.zeros(1000), np.full(3000, 0.5)]
    assert deviance_saved(before, after) == pytest.approx(np.sum(before**2) - np.sum(after**2), rel=0.05)


@pytest.mark.parametrize("freedom", [2.0, 3.0, 6.0])
def test_with_heavy_tails_it_is_that_of_students_likelihood(freedom):
    after = stats.t.rvs(freedom, scale=0.7, size=2000, random_state=3)
    before = after.copy()
    before[50:53] += 8.0
    nu, _, scale = stats.t.fit(after, floc=0.0)
    old, new = (-2.0 * np.sum(stats.t.logpdf(z, nu, scale=scale)) for z in (before, after))
    saved = deviance_saved(before, after)
    assert saved == pytest.approx(old - new, rel=0.01)
    assert saved < 0.6 * (np.sum(before**2) - np.sum(after**2))


def loops(noise, after_N):
    """Two isobars of a bench, whose force is off after 40 s."""
    time = np.arange(900) * 0.1
    x = 20.0 - 20.0 * np.cos(2.0 * np.pi * time / 15.0)
    force = 400.0 - 5.0 * x + noise + after_N * (time >= 40.0)
    pressure = np.where(time < 45.0, 0.3, 0.4)
    specimen = Specimen("bench", 200.0, 10.0, 25.4, 1.5)
    return build_record("loop", specimen, pressure, x / 200.0, force, time=time)


def heavy(seed):
    return stats.t.rvs(3.0, size=900, random_state=seed) / np.sqrt(3.0)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "count", "far"), [(4, 3, 9.0), (5, 3, 7.0), (4, 4, 7.0)])
def test_neighbours_that_are_far_off_by_chance_are_no_step_and_a_step_is_one(seed, count, far):
    noise = heavy(seed)
    noise[400 : 400 + count] = far
    found = diagnose(Model.build("polynomial"), loops(noise, 0.0))
    assert found.verdict == "adequate", found.pattern
    found = diagnose(Model.build("polynomial"), loops(noise, 4.0))
    assert found.verdict == "unknown_effect"
    assert found.pattern.kind == "step"


@pytest.mark.parametrize(("rows", "stands"), [(1, False), (2, False), (12, True)])
def test_a_pattern_that_rests_on_two_samples_is_none(rows, stands):
    """A pattern that takes them leaves noise without tails; the surfaces had taken one, so it was no outlier."""
    after = np.random.default_rng(4).standard_normal(1200)
    before = after + np.where(np.arange(1200) < rows, 14.0 * np.sqrt(2.0 / (rows + 1.0)), 0.0)
    noise = SimpleNamespace(outlier=np.zeros(1200, bool), whiten=lambda residual: residual)
    selection = SimpleNamespace(noise=noise, view=lambda one: SimpleNamespace(residual=one.left))
    fitted, found = (
        SimpleNamespace(left=left, squares=left @ left, criterion=left @ left + penalty)
        for left, penalty in ((before, 0.0), (after, 70.0))
    )
    assert found.criterion < fitted.criterion
    assert bool(_outlives_tails(selection, found, fitted)) is stands
