"""What a muscle did before its record began is not in it."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
from pam_ident.records import build_record

pytestmark = pytest.mark.long

MUSCLE = Specimen("made", 200.0, 10.0, 25.0)
LAW, TRUE = Model.build("modified_chou_hannaford"), {"k0": 0.9, "k1": 1.2, "k2": 5.0}
NOISE_N = 6.0


def bent(way, width, begun=-0.9):
    """Bouc and Wen's hysteresis along a way (n,), step by step, from a state that is not that of rest."""
    state, found = begun, [begun]
    for step in np.diff(way) / width:
        state += step * (1.0 - (0.6 * np.sign(step) * np.sign(state) + 0.4) * abs(state) ** 1.4)
        found.append(state)
    return np.array(found)


def made(time, pressure, contraction, hidden, rng):
    plain = build_record("made", MUSCLE, pressure, contraction, 0.0 * time, time=time)
    force = LAW.force(plain.inputs, TRUE) + hidden + NOISE_N * rng.standard_normal(len(time))
    return build_record("made", MUSCLE, pressure, contraction, force, time=time)


def test_the_first_way_of_a_contact_that_was_bent_is_no_softening():
    """Softening that fades within a stroke did for it, at 84 %."""
    rng = np.random.default_rng(3)
    time = 0.02 * np.arange(1500)

    def course():
        waves = zip(rng.uniform(0.1, 0.5, 4), rng.uniform(0.0, 1.0, 4), strict=True)
        return sum(np.sin(2.0 * np.pi * (f * time + phase)) for f, phase in waves) / 4.0

    contraction, pressure = 0.10 + 0.09 * course(), 0.3 + 0.15 * course()
    found = diagnose(LAW, made(time, pressure, contraction, -25.0 * bent(200.0 * contraction, 6.0), rng), detail=False)
    assert found.selected == ("presliding_hysteresis",), found.sentence
    assert found.best.values["presliding_hysteresis.z_0"] < -0.5


@pytest.mark.parametrize("seed", [1, 2])
def test_a_contact_of_a_locked_muscle_bends_by_the_pressure_from_wherever_it_was(seed):
    """Widths in mm of a braid that hardly slides were all out of reach, and the answer was something unknown."""
    rng = np.random.default_rng(seed)
    corners = [0.05, 0.2, 0.2, 0.5, 0.5, 0.3, 0.05]
    pressure = np.tile(np.interp(np.arange(300), np.linspace(0, 299, 7), corners), 5)
    time = 0.02 * np.arange(1500) + 20.0 * np.repeat(np.arange(5), 300)
    contraction = np.repeat([0.02, 0.04, 0.06, 0.08, 0.1], 300)
    found = diagnose(LAW, made(time, pressure, contraction, -20.0 * bent(100.0 * pressure, 6.0), rng), detail=False)
    assert (found.verdict, found.selected) == ("missing_effect", ("presliding_hysteresis",)), found.sentence
