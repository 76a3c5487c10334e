"""Gains found by hand and automatically: rms errors against the plain plant, and what each way of tuning promises."""

import numpy as np
import pytest
from plain_loop import PlainGait, PlainPid, closed_loop, runge_kutta

from pam_ident.leg import tuning
from pam_ident.leg.control import Gains
from pam_ident.leg.loop import Scale
from pam_ident.leg.tuning import FIRST, HIGHEST, LOST_DEG, LOWEST, PLANTS, errors, rms_deg, tune, tune_by_hand

JUDGED = slice(10, 110)


@pytest.fixture(scope="module")
def by_hand(loop, task):
    return tune_by_hand(loop, task, JUDGED)


@pytest.fixture(scope="module")
def automatic(loop, task, by_hand):
    return tune(loop, task, JUDGED, by_hand.gains, seed=1)


@pytest.mark.long
def test_errors_are_those_of_the_plain_plant_a_fifth_off(example, loop, course, task):
    """The same integrator, so that what is compared is which plant got which error."""
    _, plain = example
    gains = np.array([[2.0, 1.0, 0.1], [0.5, 3.0, 0.02]])
    found = errors(loop, task, JUDGED, gains)
    assert found.shape == (2, 7)
    target = np.asarray(task.target)[JUDGED]
    for row, column in ((0, 6), (1, 3)):
        plain.force_scale, plain.inertia_scale, plain.flow_scale = PLANTS[column]
        path = closed_loop(plain, PlainGait(course.gait), PlainPid(*gains[row]), len(task.target), runge_kutta)
        plain.force_scale = plain.inertia_scale = plain.flow_scale = 1.0
        off = np.degrees(np.array(path)[JUDGED, 0] - target)
        assert found[row, column] == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-6)


def test_the_plants_are_the_leg_and_three_things_a_fifth_off_each_way():
    assert len(PLANTS) == 7 and PLANTS[0] == Scale(1.0, 1.0, 1.0)
    assert sorted(tuple(p) for p in PLANTS[1:]) == sorted(
        tuple(1.0 + 0.2 * sign * (np.arange(3) == k)) for k in range(3) for sign in (-1, 1)
    )


@pytest.mark.long
def test_tuning_by_hand_stops_where_the_next_doubling_is_no_better(loop, task, by_hand):
    """Each gain is a first guess doubled; at the turn it was left, one more doubling, the later gains still at their
    first guess, is no better, and one fewer was worse."""
    gains = np.array(by_hand.gains)
    doublings = np.log2(gains / np.array(FIRST))
    assert doublings == pytest.approx(np.round(doublings), abs=1e-12) and doublings.max() >= 1
    order, now = (0, 2, 1), np.array(FIRST)
    tried = []
    for k in order:
        steps = np.arange(3) == k
        now = np.where(steps, gains, now)
        tried += [now, now * np.where(steps, 2.0, 1.0), now * np.where(steps, 0.5, 1.0)]
    found = errors(loop, task, JUDGED, np.array(tried), PLANTS[:1])[:, 0].reshape(3, 3)
    for row, k in zip(found, order, strict=True):
        assert row[1] >= row[0] or gains[k] >= HIGHEST[k]
        assert row[2] > row[0] or gains[k] == FIRST[k]
    assert found[-1, 0] == pytest.approx(by_hand.rms_deg, rel=1e-9)


@pytest.mark.long
def test_automatic_tuning_is_no_worse_on_its_worst_plant(by_hand, automatic):
    assert automatic.worst_deg <= by_hand.worst_deg
    assert automatic.rms_deg <= automatic.worst_deg


@pytest.mark.long
def test_nor_is_it_where_what_is_known_is_best(loop, task, automatic, monkeypatch):
    """Of a single generation of random trials, hardly one is better than the gains of six."""
    monkeypatch.setattr(tuning, "GENERATIONS", 1)
    again = tune(loop, task, JUDGED, automatic.gains, seed=5)
    assert again.worst_deg <= automatic.worst_deg


@pytest.mark.long
def test_its_gains_beat_a_crude_grid(loop, task, automatic):
    axes = [np.geomspace(low, high, 4) for low, high in zip(LOWEST, HIGHEST, strict=True)]
    grid = np.stack([a.ravel() for a in np.meshgrid(*axes)], axis=1)
    assert automatic.worst_deg <= errors(loop, task, JUDGED, grid).max(axis=1).min()


@pytest.mark.long
def test_the_same_seed_finds_the_same_gains(loop, task, monkeypatch):
    monkeypatch.setattr(tuning, "GENERATIONS", 1)
    one, again, other = (tune(loop, task, JUDGED, FIRST, seed).gains for seed in (1, 1, 2))
    assert one == again != other


@pytest.mark.long
def test_a_run_without_end_counts_as_lost(loop, task):
    flexion = np.full((2, 110), np.nan)
    flexion[0] = np.asarray(task.target) + np.radians(2.0)
    log = loop.run(loop.pair.muscle.values(), Gains(1.0, 0.0, 0.0), Scale(), task)._replace(flexion=flexion)
    assert rms_deg(log, task, JUDGED) == pytest.approx([2.0, LOST_DEG])
