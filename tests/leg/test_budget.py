"""The error budget: a cause that is absent has no share; a linear muscle and a hinge are what they say."""

from dataclasses import replace

import numpy as np
import pytest
from plain_loop import smooth_example

from pam_ident.leg import tuning
from pam_ident.leg.anatomy import KNEE, LEG
from pam_ident.leg.budget import SPEED_MM_S, Hinge, budget, linearised
from pam_ident.leg.control import Sensor
from pam_ident.leg.loop import Loop
from pam_ident.leg.muscle import Muscle
from pam_ident.leg.tuning import tune, tune_by_hand
from pam_ident.model import Model

RANGES = ((0.0, 0.6), (0.0, 0.25))
JUDGED = slice(10, 110)


def test_the_plane_nearest_to_a_muscle_is_the_textbooks_least_squares():
    """Of F = 1200 p(1 − 3ε) + 200 − 0.3 v the plane over a symmetric grid is known: the product p ε, about its middle
    (P, E), leaves P ε + E p − P E, because what remains, (p − P)(ε − E), is orthogonal to all columns."""
    law = {"a0": 900.0, "a1": 1200.0, "b0": 0.0, "b1": 3600.0, "c0": 0.0, "c1": 0.0, "mu": 45.0}
    values = {**law, "viscous_damping.B": 300.0}
    pair, _ = smooth_example()
    muscle = Muscle(Model.build("exponential_law", ("viscous_damping",)), pair.muscle.specimen, values, values)
    found = linearised(muscle, *RANGES).contraction
    middle_p, middle_e = 0.3, 0.125
    assert found["F0"] == pytest.approx(900.0 + 3600.0 * middle_p * middle_e, rel=1e-9)
    assert found["F1"] == pytest.approx(1200.0 - 3600.0 * middle_e, rel=1e-9)
    assert found["F2"] == pytest.approx(-3600.0 * middle_p, rel=1e-9)
    assert found["viscous_damping.B"] == pytest.approx(300.0, rel=1e-9)


def test_friction_becomes_the_damping_that_takes_as_much_at_its_speed():
    pair, _ = smooth_example()
    law = {"a0": 900.0, "a1": 1200.0, "b0": 0.0, "b1": 0.0, "c0": 0.0, "c1": 0.0, "mu": 45.0}
    values = {**law, "coulomb_friction.F_c": 20.0, "coulomb_friction.F_hold": 0.0}
    model = Model.build("exponential_law", ("coulomb_friction",))
    muscle = Muscle(model, pair.muscle.specimen, *(2 * ({n: values[n] for n in model.names},)))
    assert linearised(muscle, *RANGES).contraction["viscous_damping.B"] == pytest.approx(20.0 / (1e-3 * SPEED_MM_S))


def test_only_where_the_muscle_pulls_counts():
    """Below its threshold a muscle is slack, which no plane should be bent to."""
    pair, _ = smooth_example()
    law = {"a0": -300.0, "a1": 2400.0, "b0": 0.0, "b1": 0.0, "c0": 0.0, "c1": 0.0, "mu": 45.0}
    values = {**law, "viscous_damping.B": 0.0}
    muscle = replace(pair.muscle, contraction=values, extension=values)
    found = linearised(muscle, *RANGES).contraction
    assert (found["F0"], found["F1"]) == (pytest.approx(-300.0), pytest.approx(2400.0))


def test_a_hinge_turns_the_sprocket_by_the_mean_of_the_four_bar():
    ends = (0.0, 1.1)
    hinge = Hinge.like(KNEE, ends)
    turned = float(KNEE.at(ends[1]).sprocket) - float(KNEE.at(ends[0]).sprocket)
    assert float(hinge.at(ends[1]).sprocket) == pytest.approx(turned, rel=1e-12)
    posture = hinge.at(np.array([0.2, 0.7]))
    assert posture.centre == pytest.approx([0.0, 0.0]) and posture.ratio == pytest.approx(2 * [turned / 1.1])


@pytest.mark.long
def test_causes_that_are_absent_have_no_share(example, task, monkeypatch):
    """A linear muscle on a hinge: both other legs are the leg itself, so tuning ends at the same gains."""
    monkeypatch.setattr(tuning, "GENERATIONS", 2)
    pair, _ = example
    leg = replace(LEG, knee=Hinge.like(KNEE, (0.0, 1.1)))
    loop = Loop(replace(pair, leg=leg, muscle=linearised(pair.muscle, *RANGES)), Sensor(bits=40))
    by_hand = tune_by_hand(loop, task, JUDGED)
    automatic = tune(loop, task, JUDGED, by_hand.gains)
    found = budget(loop, task, JUDGED, by_hand, automatic)
    assert found.by_hand == by_hand.rms_deg > 0.1
    assert found.tuning == pytest.approx(by_hand.rms_deg - automatic.rms_deg)
    assert found.structure == pytest.approx(0.0, abs=0.02 * automatic.rms_deg)
    assert found.muscle == pytest.approx(0.0, abs=0.02 * automatic.rms_deg)


@pytest.mark.long
def test_a_muscle_that_bends_and_sticks_has_a_share(example, task, monkeypatch):
    monkeypatch.setattr(tuning, "GENERATIONS", 2)
    pair, _ = example
    loop = Loop(pair, Sensor(bits=40))
    by_hand = tune_by_hand(loop, task, JUDGED)
    automatic = tune(loop, task, JUDGED, by_hand.gains)
    found = budget(loop, task, JUDGED, by_hand, automatic)
    assert abs(found.muscle) > 0.02 * automatic.rms_deg
