"""The four-bar knee against its own definition: fixed lengths, finite differences, a root finder, an intersection."""

import numpy as np
import pytest
from scipy.optimize import fsolve

from pam_ident.core import UsageError
from pam_ident.leg.anatomy import KNEE, LEG
from pam_ident.leg.arrays import jax, jnp
from pam_ident.leg.four_bar import FourBar

RANGE = np.radians(np.linspace(-5.0, 75.0, 161))
STEP = 1e-5


def places(flexion):
    """Pivots of the shank as the posture's knee carries them, independent of crank and rocker."""
    knee = KNEE.at(flexion).knee[0]
    return knee + np.exp(-1j * flexion) * KNEE.crank_shank, knee + np.exp(-1j * flexion) * KNEE.rocker_shank


def test_the_loop_closes_and_keeps_its_lengths():
    crank_end, rocker_end = places(RANGE)
    crank, coupler, rocker, _ = KNEE.lengths
    posture = KNEE.at(RANGE)
    assert np.max(np.abs(np.abs(crank_end - KNEE.crank_thigh) - crank)) < 1e-12
    assert np.max(np.abs(np.abs(rocker_end - KNEE.rocker_thigh) - rocker)) < 1e-12
    assert np.max(np.abs(np.abs(rocker_end - crank_end) - coupler)) < 1e-12
    assert np.max(np.abs(KNEE.crank_thigh + posture.crank[0] - crank_end)) < 1e-12
    assert np.max(np.abs(KNEE.rocker_thigh + posture.rocker[0] - rocker_end)) < 1e-12


def test_straight_leg_is_where_the_pivots_were_given():
    posture = KNEE.at(0.0)
    assert posture.sprocket == pytest.approx(0.0, abs=1e-15)
    assert posture.knee[0] == pytest.approx(0.0, abs=1e-15)
    assert posture.crank[0] == pytest.approx(KNEE.crank_shank - KNEE.crank_thigh, abs=1e-15)


def test_lengths_are_those_published_for_the_cruciate_ligaments():
    crank, _, rocker, _ = KNEE.lengths
    assert crank == pytest.approx(0.038, abs=1e-4)
    assert rocker == pytest.approx(0.031, abs=1e-4)


def test_a_root_finder_on_the_two_lengths_agrees():
    crank, _, rocker, _ = KNEE.lengths
    guess = np.zeros(2)
    for flexion in RANGE[10::15]:
        turn = np.exp(-1j * flexion)

        def gaps(knee, turn=turn):
            c = complex(*knee) + turn * KNEE.crank_shank
            d = complex(*knee) + turn * KNEE.rocker_shank
            return abs(c - KNEE.crank_thigh) - crank, abs(d - KNEE.rocker_thigh) - rocker

        guess = fsolve(gaps, guess, xtol=1e-13)
        assert KNEE.at(flexion).knee[0] == pytest.approx(complex(*guess), abs=1e-10)


def test_derivatives_agree_with_finite_differences():
    ahead, here, behind = KNEE.at(RANGE + STEP), KNEE.at(RANGE), KNEE.at(RANGE - STEP)

    def slope(name, order=None):
        a, b = getattr(ahead, name), getattr(behind, name)
        return (a - b if order is None else a[order] - b[order]) / (2.0 * STEP)

    assert np.max(np.abs(slope("sprocket") - here.ratio)) < 1e-9
    assert np.max(np.abs(slope("ratio") - here.bend)) < 1e-9
    for name in ("knee", "crank", "rocker"):
        for order in (0, 1):
            assert np.max(np.abs(slope(name, order) - getattr(here, name)[order + 1])) < 1e-10


def test_the_sprocket_follows_the_crank():
    crank = KNEE.at(RANGE).crank[0]
    turned = np.angle(KNEE.crank_shank - KNEE.crank_thigh) - np.angle(crank)
    assert np.max(np.abs(np.exp(1j * turned) - np.exp(1j * KNEE.at(RANGE).sprocket))) < 1e-12
    assert np.all(KNEE.at(RANGE).ratio > 0.5)


def test_points_of_the_shank_move_across_the_line_from_the_instantaneous_centre():
    centre = KNEE.at(RANGE).centre
    for body_point in (0.0, 0.03 - 0.2j, -0.1 - 0.4j, KNEE.crank_shank):

        def path(flexion, body_point=body_point):
            return KNEE.at(flexion).knee[0] + np.exp(-1j * flexion) * body_point

        velocity = (path(RANGE + STEP) - path(RANGE - STEP)) / (2.0 * STEP)
        line = path(RANGE) - centre
        assert np.max(np.abs((line.conjugate() * velocity).real)) < 1e-10
        assert np.max(np.abs(np.abs(velocity) - np.abs(line))) < 1e-9  # |v| = |line| · 1 rad/rad


def test_the_instantaneous_centre_is_where_the_links_cross():
    for flexion in RANGE[::20]:
        u, v = KNEE.at(flexion).crank[0], KNEE.at(flexion).rocker[0]
        gap = KNEE.rocker_thigh - KNEE.crank_thigh
        along, _ = np.linalg.solve([[u.real, -v.real], [u.imag, -v.imag]], [gap.real, gap.imag])
        assert KNEE.at(flexion).centre == pytest.approx(KNEE.crank_thigh + along * u, abs=1e-12)


def test_the_tibia_follows_the_published_path():
    """Origin of the tibia in the femur, mm, at the knots of gait2392 (Delp 1990)."""
    knots = {20.0: (-1.0, -397.6), 40.0: (2.12, None), 60.0: (4.10, None), 70.0: (None, -408.2)}
    straight = (-4.25, -395.7)  # between the knots at −10° and +10° on either side
    for degrees, (x, y) in knots.items():
        moved = 1e3 * KNEE.at(np.radians(degrees)).knee[0]
        if x is not None:
            assert moved.real == pytest.approx(x - straight[0], abs=1.8)
        if y is not None:
            assert moved.imag == pytest.approx(y - straight[1], abs=1.8)


@pytest.mark.long
def test_jax_gives_the_same_and_differentiates():
    np.testing.assert_allclose(jax.jit(KNEE.at)(jnp.asarray(RANGE)).knee[2], KNEE.at(RANGE).knee[2], rtol=0, atol=1e-13)
    slope = jax.vmap(jax.grad(lambda x: KNEE.at(x).sprocket))(jnp.asarray(RANGE))
    np.testing.assert_allclose(slope, KNEE.at(RANGE).ratio, rtol=0, atol=1e-12)


def test_links_that_cannot_close_are_refused_at_their_angle():
    """They lock where crank and rocker lie in line; there the law of cosines gives the shank's turn."""
    a, b, ground, coupler = 0.03, 0.04, 0.05, 0.04
    start = 2.0 - np.arccos(((a + b) ** 2 - ground**2 - coupler**2) / (2 * ground * coupler))
    w = coupler * np.exp(2.0j)  # against −(rocker_thigh − crank_thigh), along x
    g = ground + w
    crank = g * (b**2 - a**2 - abs(g) ** 2) / (2 * abs(g) ** 2)
    crank += 1j * g / abs(g) * np.sqrt(a**2 - abs(crank) ** 2)
    pivots = {"crank_thigh": 0j, "rocker_thigh": -ground + 0j, "crank_shank": crank, "rocker_shank": crank + w}
    with pytest.raises(UsageError, match=r"cannot close at \d+\.\d° of flexion; expected -10° to 85°") as caught:
        FourBar(**pivots)
    assert float(str(caught.value).split(" at ")[1].split("°")[0]) == pytest.approx(np.degrees(start), abs=1.0)


def test_a_dead_centre_is_refused():
    """A parallelogram's crank and rocker lie in line with its diagonal while the coupler has not turned."""
    with pytest.raises(UsageError, match=r"cannot close at -?0\.0° of flexion"):
        FourBar(crank_thigh=0j, rocker_thigh=0.02 + 0j, crank_shank=-0.03j, rocker_shank=0.02 - 0.03j)


def test_a_sprocket_that_turns_backwards_is_refused():
    # The links cross below the shank's pivots, so that crank and shank turn against each other.
    wide = {"crank_thigh": 0j, "rocker_thigh": 0.03 + 0j, "crank_shank": -0.03j, "rocker_shank": 0.015 - 0.03j}
    with pytest.raises(UsageError, match="turns its sprocket backwards"):
        FourBar(**wide, low=np.radians(-3.0), high=np.radians(3.0))


def test_muscles_of_200_mm_stay_within_their_range():
    sprocket = LEG.knee.at(RANGE).sprocket
    both = np.stack(LEG.contraction(sprocket, 0.2))
    assert both.min() >= 0.01 and both.max() <= 0.24
    assert np.all(np.diff(both[0]) > 0.0) and np.all(np.diff(both[1]) < 0.0)
