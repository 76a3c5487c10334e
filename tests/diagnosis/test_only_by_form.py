"""No name rests on a form alone where the error shows that forms are in doubt."""

import math

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
from pam_ident.records import record_from_frame

MUSCLE = Specimen("made", 200.0, 10.0, 25.0)


def strokes(law, branches, speeds, seed):
    """Strokes over a fifth of the length at five pressures; a law and what differs by branch, in N, noise of 1 N."""
    rows, t = [], 0.0
    for p in (0.1, 0.2, 0.3, 0.4, 0.5):
        for speed in speeds:
            for _ in range(2):
                for sign, way in ((1.0, np.linspace(0.0, 0.2, 40)), (-1.0, np.linspace(0.2, 0.0, 40))):
                    times = t + np.arange(40) / speed
                    t = times[-1] + 1.0 / speed
                    rows += zip(times, np.full(40, p), way, np.full(40, sign), strict=True)
    time, p, e, sign = np.array(rows).T
    force = law(p, e) + branches(p, e, sign) + np.random.default_rng(seed).normal(0.0, 1.0, len(time))
    frame = pd.DataFrame({"time_s": time, "pressure_MPa": p, "displacement_mm": 200.0 * e, "force_N": force})
    return record_from_frame(frame, MUSCLE)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_a_snap_at_other_places_on_each_branch_is_unknown_and_no_static_effect_stands_beside_it(seed):
    """By its free form alone tapered ends could follow half of it."""

    def law(p, e):
        return -180.0 + 2400.0 * p - (1600.0 + 5500.0 * p) * e + (630.0 * p - 10.0) * np.exp(-40.0 * e)

    def snap(p, e, sign):
        return -27.0 * p * np.tanh((e - np.where(sign > 0.0, 0.18, 0.16)) / 0.01)

    found = diagnose(Model.build("exponential_law"), strokes(law, snap, (5.0, 20.0), seed))
    assert (found.verdict, found.selected) == ("unknown_effect", ()) and found.best is found.base
    assert max(one.probability for one in found.ranking) < 0.01


@pytest.mark.long
def test_memories_do_not_stand_for_what_follows_pressure_and_contraction():
    """Strokes that are all alike: creep, lag and softening in free forms can imitate a spring, and nothing shows that
    they are memory. Friction is there, and something else; by a law with a spring only the friction is missing."""
    angle = math.radians(25.0)
    area, slope, foot = math.pi * 100.0, 3.0 / math.tan(angle) ** 2, 1.0 / math.sin(angle) ** 2

    def law(p, e):
        return area * p * (slope * (1.0 - 1.05 * e) ** 2 - foot) - 400.0 * e + 60.0

    record = strokes(law, lambda p, e, sign: -15.0 * sign, (10.0,), 3)
    found = diagnose(Model.build("chou_hannaford"), record)
    named = ("coulomb_friction",)
    assert (found.verdict, found.selected, found.follows[0].what) == ("unknown_effect", named, "map")
    with_spring = diagnose(Model.build("martens_boblan"), record)
    assert with_spring.selected == named and with_spring.best.rmse < 1.1
