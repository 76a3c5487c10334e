"""The same physics in other forms: figures worked out by hand, and what keeps a form from being another effect."""

import numpy as np
import pytest

from pam_ident.core import Inputs, Specimen
from pam_ident.effects import get_effect
from pam_ident.model import Model

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 2.0)


def columns(name, e, p=0.4, v=0.0, cycle=None, **shape):
    e = np.atleast_1d(np.asarray(e, float))
    given = Inputs(
        np.broadcast_to(np.asarray(p, float), e.shape),
        e,
        MUSCLE,
        np.sign(np.broadcast_to(np.asarray(v, float), e.shape)),
        velocity=np.broadcast_to(np.asarray(v, float), e.shape),
        cycle=None if cycle is None else np.broadcast_to(np.asarray(cycle, float), e.shape),
        segment=np.zeros(len(e), int),
    )
    return get_effect(name)[1].columns(given, shape, np.zeros(len(e)))


def test_damping_that_differs_by_branch_is_newtons_per_metre_a_second_on_its_own_branch():
    found = columns("viscous_damping:asymmetric", [0.1, 0.1, 0.1], v=[50.0, 0.0, -20.0])
    np.testing.assert_allclose(found @ [400.0, 100.0], [-20.0, 0.0, 2.0], atol=1e-12)


def test_flat_threads_lose_the_same_force_at_every_contraction():
    found = columns("braid_extensibility:flat", [0.0, 0.1, 0.25], p=[0.2, 0.2, 0.4])[:, 0]
    sine = np.sin(np.radians(25.0))
    np.testing.assert_allclose(found, -4e-3 * np.pi**2 * (10.0 / sine) ** 4 * np.array([0.04, 0.04, 0.16]), rtol=1e-12)
    leaning = columns("braid_extensibility", 0.1, p=0.2)[0, 0]
    assert leaning / found[1] == pytest.approx(0.9 * np.cos(np.radians(25.0)), rel=1e-12)


def test_a_bladder_spring_pulls_back_in_proportion_to_contraction():
    np.testing.assert_allclose(columns("bladder_elasticity:spring", [0.0, 0.1, 0.2])[:, 0] * 300.0, [0.0, -30.0, -60.0])


def test_softening_may_grow_with_contraction():
    found = columns("mullins_softening:shaped", [0.0, 0.2], cycle=[1.0, 3.0], n_0=2.0)
    np.testing.assert_allclose(found @ [0.05, 0.5], [0.05, (0.05 + 0.1) * np.exp(-1.0)], rtol=1e-12)


def test_a_pseudo_elastic_bladder_is_itself_on_its_way_to_new_stretch_and_softer_on_every_way_below():
    way = np.r_[np.linspace(0.0, 0.1, 5), 0.06, 0.02, 0.06, 0.1, 0.15]
    found = columns("mullins_softening:pseudo_elastic", way, cycle=np.repeat([1.0, 2.0], 5), m=0.1)[:, 0]
    np.testing.assert_array_equal(found[[0, 1, 2, 3, 4, 8, 9]], 0.0)
    sine = np.sin(np.radians(25.0))
    ratio = np.sqrt(1.0 - (1.0 - np.array([0.1, 0.02])) ** 2 * np.cos(np.radians(25.0)) ** 2) / sine
    eta = np.tanh(((ratio[0] - 1.0) ** 2 - (ratio[1] - 1.0) ** 2) / 0.1)
    whole = -columns("bladder_elasticity", 0.02)[0, 0]
    assert found[6] == pytest.approx(whole * eta, rel=1e-12)
    assert found[5] == found[7] > 0.0
    rested = columns("mullins_softening:pseudo_elastic", way, cycle=[1] * 5 + [2, 2, 1, 1, 1], m=0.1)[:, 0]
    np.testing.assert_array_equal(rested[7:], 0.0)


def test_softening_by_the_way_gone_counts_to_and_fro_and_begins_anew_after_a_rest():
    """The muscle is 200 mm long: 0.1 of it to and fro are 40 mm."""
    track, cycle = [0.0, 0.1, 0.0, 0.1, 0.0, 0.1], [1, 1, 2, 2, 1, 1]
    found = columns("mullins_softening:travelled", track, cycle=cycle, s_0=40.0)
    gone = np.array([0.0, 20.0, 40.0, 60.0, 0.0, 20.0])
    np.testing.assert_allclose(found @ [3.0, 50.0], (3.0 - 50.0 * np.array(track)) * np.exp(-gone / 40.0), rtol=1e-12)


@pytest.mark.parametrize("form", ["textbook", "dahl", "maxwell_slip_3"])
def test_an_element_that_would_never_slip_still_opens_a_loop(form):
    """Without a limit on its travel it would be a spring, −W x/x_s on both branches, and pass for the bladder."""
    way = np.r_[np.linspace(0.0, 0.2, 41), np.linspace(0.2, 0.0, 41)]
    found = columns(f"presliding_hysteresis:{form}", way, v=np.r_[np.ones(41), -np.ones(41)], x_s=80.0)
    up, down = found[:41, -1], found[41:, -1][::-1]
    middle = slice(10, 31)
    assert np.min(np.abs(up - down)[middle]) > 0.3 * np.ptp(found[:, -1])


def test_what_relaxes_within_a_fifth_of_a_second_is_no_creep():
    for form in get_effect("creep")[0].forms:
        for p in (p for p in form.nonlinear if p.unit == "s"):
            fastest = p.lower / (10.0 if form.name == "prony_3" else 1.0)
            assert fastest >= 0.2


@pytest.mark.parametrize(("form", "fastest"), [("textbook", 1.0), ("prony_3", 0.1), ("free", 0.1)])
def test_what_relaxes_within_two_samples_is_no_creep(form, fastest):
    for interval, least in ((0.01, 0.2), (0.5, 1.0)):
        x = np.linspace(0.0, 0.2, 400)
        inputs = Inputs(np.full(400, 0.3), x, MUSCLE, np.ones(400), time=interval * np.arange(400))
        (tau,) = (p for p in Model.build("polynomial", (f"creep:{form}",)).bounded(inputs) if p.name == "creep.tau")
        assert tau.lower == pytest.approx(least / fastest) and min(tau.grid) >= tau.lower


@pytest.mark.parametrize(
    ("form", "slowest", "least"),
    [("textbook", 1.0, 1.0), ("following", 1.0, 2.0), ("prony_3", 10.0, 2.0), ("free", 10.0, 2.0)],
)
def test_nothing_relaxes_more_slowly_than_the_record_lasts_for_that_is_elastic(form, slowest, least):
    def bound(seconds):
        time = None if seconds is None else np.array([5.0, 6.0, 5.0 + seconds])
        inputs = Inputs(np.full(3, 0.3), np.array([0.0, 0.1, 0.0]), MUSCLE, np.zeros(3), time=time)
        (tau,) = (p for p in Model.build("polynomial", (f"creep:{form}",)).bounded(inputs) if p.name == "creep.tau")
        assert tau.lower <= tau.start <= tau.upper and max(tau.grid) <= tau.upper
        return tau.upper

    assert bound(70.0) == pytest.approx(70.0 / slowest)
    assert bound(1.0) == least
    assert bound(1e6) == bound(None) == 3000.0
