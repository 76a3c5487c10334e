"""Bands of the tracking error, and the draws of parameters behind them."""

from dataclasses import replace

import numpy as np
import pytest
from plain_loop import smooth_example

from pam_ident.core import Param
from pam_ident.leg.control import Gains
from pam_ident.leg.course import Course
from pam_ident.leg.fit_file import ParameterSpread
from pam_ident.leg.gait import Window, winter
from pam_ident.leg.loop import Loop
from pam_ident.leg.track import SAMPLES, Tracking, _Reduced

GAINS = Gains(2.0, 1.0, 0.1)


def test_three_parameters_of_which_one_is_known():
    """Σ11 − Σ12 Σ22⁻¹ Σ21 written out: a 2 × 2 left of a 3 × 3, a number left of a 2 × 2."""
    matrix = np.array([[4.0, 1.0, 2.0], [1.0, 9.0, 3.0], [2.0, 3.0, 16.0]])
    left = ParameterSpread(("a", "b", "c"), matrix).given(("c",))
    assert left.names == ("a", "b")
    expected = [[4.0 - 2.0 * 2.0 / 16.0, 1.0 - 2.0 * 3.0 / 16.0], [1.0 - 2.0 * 3.0 / 16.0, 9.0 - 3.0 * 3.0 / 16.0]]
    assert left.matrix == pytest.approx(np.array(expected))
    small = ParameterSpread(("a", "b"), np.array([[4.0, 3.0], [3.0, 9.0]])).given(("b",))
    assert small.matrix == pytest.approx(np.array([[4.0 - 9.0 / 9.0]]))
    assert ParameterSpread(("a", "b"), np.eye(2)).given(()).matrix == pytest.approx(np.eye(2))


def test_draws_have_the_covariance_and_keep_the_bounds():
    matrix = np.array([[4.0, 1.2], [1.2, 1.0]])
    params = [
        Param("a", "N", "one", -100.0, 100.0),
        Param("b", "N", "two", 2.5, 100.0, start=3.0),
        Param("c", "N", "three"),
    ]
    normal = np.random.default_rng(2).standard_normal((40_000, 2))
    found = ParameterSpread(("a", "b"), matrix).draws({"a": 1.0, "b": 3.0, "c": 7.0}, params, normal)
    assert np.var(found["a"]) == pytest.approx(4.0, rel=0.03) and np.mean(found["a"]) == pytest.approx(1.0, abs=0.04)
    assert found["b"].min() == 2.5  # 0.5 below the value, which 31 % of normal draws pass
    assert np.mean(found["b"] == 2.5) == pytest.approx(0.3085, abs=0.01)
    free = np.array([found["a"], found["b"]])[:, found["b"] > 2.5]
    slope = np.cov(free)[0, 1] / np.var(free[1])
    assert slope == pytest.approx(1.2, rel=0.03)  # of a on b: the regression that a cut in b leaves as it is
    assert np.all(found["c"] == 7.0)


@pytest.fixture(scope="module")
def bench():
    """A run-in and 0.1 s that are judged, of a muscle whose force per pressure is uncertain by a few per cent."""
    pair, _ = smooth_example()
    course = Course(winter(1.0), Window(0.0, 0.1))
    loop = Loop(pair)
    return _Reduced(loop, course, loop), pair.muscle


def with_spread(muscle, share):
    size = (share * muscle.contraction["a1"]) ** 2
    spread = ParameterSpread(("a1", "b0"), np.diag([size, (share * muscle.contraction["b0"]) ** 2]))
    return replace(muscle, spreads=(spread, spread))


@pytest.mark.long
def test_a_band_holds_the_fit_that_is_nearly_right_and_widens_with_its_uncertainty(bench):
    reduced, muscle = bench
    models = (replace(reduced.plant.pair, muscle=with_spread(muscle, share)) for share in (0.002, 0.02))
    narrow, wide = (reduced.rung(model, GAINS, seed=3) for model in models)
    own = narrow.tracking.rms_deg
    assert own < 0.1 and len(narrow.tracking.time) == 20 and narrow.tracking.time[0] == pytest.approx(1.0)
    assert wide.tracking.rms_deg == pytest.approx(own, rel=1e-9)  # the run is that of the fit itself
    assert narrow.band[0] <= own * 1.2 and narrow.band[1] >= own
    assert wide.band[1] - wide.band[0] > 3.0 * (narrow.band[1] - narrow.band[0]) > 0.0


def test_a_model_whose_uncertainty_is_not_known_has_no_draws(bench):
    _, muscle = bench
    assert muscle.draws(SAMPLES, seed=1) is None


def test_draws_begin_with_the_fit_and_come_again_with_their_seed(bench):
    _, muscle = bench
    draws = with_spread(muscle, 0.02).draws(SAMPLES, seed=1)
    for branch in ("contraction", "extension"):
        found = draws[branch]
        assert {len(v) for v in found.values()} == {1 + SAMPLES}
        assert {name: v[0] for name, v in found.items()} == pytest.approx(dict(muscle.contraction))
        assert np.ptp(found["a1"]) > 0.0 and np.ptp(found["a0"]) == 0.0
        again, other = (with_spread(muscle, 0.02).draws(SAMPLES, seed)[branch]["a1"] for seed in (1, 2))
        assert np.array_equal(again, found["a1"]) and not np.array_equal(other, found["a1"])


def test_errors_of_a_run_are_root_mean_square_and_peak():
    nothing = np.zeros((4, 2))
    run = Tracking(np.arange(4.0), np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.0, 1.0, 3.0, 6.0]), nothing, nothing)
    assert run.rms_deg == pytest.approx(np.sqrt(5.0 / 4.0)) and run.peak_deg == 2.0
