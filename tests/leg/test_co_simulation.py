"""The leg in the prototype under control: beside the reduced leg, and the goals of tracking over a whole stride."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from pam_ident.leg.control import Gains
from pam_ident.leg.course import Course
from pam_ident.leg.gait import winter
from pam_ident.leg.loop import Loop
from pam_ident.leg.muscle import Muscle
from pam_ident.leg.pair import pair_of
from pam_ident.leg.track import _Prototype, _Reduced
from pam_ident.records.datasets import dataset_path

pytestmark = pytest.mark.long

if find_spec("mujoco") is None:  # looked for only: to draw without a screen it must be imported by the prototype
    pytest.skip("MuJoCo is not installed; pip install 'pam-ident[prototype]'", allow_module_level=True)

GAINS = Gains(2.7, 1.7, 0.26)
"""Near those that `pam-ident track` finds by itself."""


@pytest.fixture(scope="module")
def runs():
    """Plain PID and the embedded ladder's last rung, in both legs; and the prototype's bench."""
    folder = dataset_path("leg_muscle")
    plant, last = Muscle.read(folder / "plant.json")[-1], Muscle.read(folder / "ladder.json")[-1]
    course = Course(winter(1.0))
    loop = Loop(pair_of(plant))
    bench = _Prototype(loop, course, loop)
    mean = np.full((1, len(course.time), 2), bench.plant.pair.mean_MPa)
    found = {"pid": bench.run(course.task(mean), GAINS)}
    reduced = _Reduced(loop, course, loop).run(course.task(mean), GAINS)
    found["rung"] = bench.rung(replace(loop.pair, muscle=last), GAINS, seed=1).tracking
    return bench, found, reduced


def test_the_last_rung_follows_a_whole_stride_within_the_goal(runs):
    """0.5° rms, 1.5° at most, three times better than the PID alone; none of it tuned for this."""
    _, found, _ = runs
    assert np.ptp(found["pid"].target) > 60.0 and len(found["pid"].time) == 200
    assert found["rung"].rms_deg <= 0.5 and found["rung"].peak_deg <= 1.5
    assert found["pid"].rms_deg >= 3.0 * found["rung"].rms_deg


def test_both_legs_agree_in_the_last_rung_and_without_feed_forward(runs):
    bench, found, reduced = runs
    assert bench.agreement_deg <= 0.2
    assert np.sqrt(np.mean((found["pid"].flexion - reduced.flexion) ** 2)) <= 0.2


def test_the_motion_kept_is_that_of_the_last_run(runs):
    bench, found, _ = runs
    assert np.degrees([a.knee for a in bench.motion]) == pytest.approx(found["rung"].flexion)
    hip = bench.course.gait.at(bench.course.time[bench.course.judged]).hip.angle
    assert np.array([a.hip for a in bench.motion]) == pytest.approx(hip, abs=np.radians(0.1))
