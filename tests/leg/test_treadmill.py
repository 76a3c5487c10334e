"""The ground: forces of the pad by themselves, and on the joints of the prototype."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import UsageError
from pam_ident.leg.anatomy import LEG
from pam_ident.leg.gait import winter
from pam_ident.leg.leg_file import DEFAULT
from pam_ident.leg.mjcf import HIP_HEIGHT_M
from pam_ident.leg.treadmill import Treadmill, sole

GROUND = Treadmill(**DEFAULT["ground"])


def test_a_pad_pushes_in_proportion_to_depth_and_more_while_it_sinks():
    ahead, up = GROUND.force(0.01, 0.0, 0.0)
    assert (ahead, up) == (0.0, pytest.approx(0.01 * GROUND.stiffness_N_m))
    assert GROUND.force(0.01, 0.2, 0.0)[1] == pytest.approx(up * (1.0 + 0.2 * GROUND.damping_s_m))


def test_it_never_pulls_and_friction_opposes_slip():
    assert GROUND.force(-0.001, 0.3, 1.0) == (0.0, 0.0) and GROUND.force(0.01, -5.0, 1.0)[1] == 0.0
    for slip in (-1.0, 1.0):
        ahead, up = GROUND.force(0.01, 0.0, slip)
        assert ahead == pytest.approx(-slip * GROUND.friction * up)


def test_the_belt_goes_as_the_sole_does_and_a_ground_too_low_is_refused():
    assert 0.5 < GROUND.belt_m_s(LEG, winter(1.0)) < 1.2
    assert GROUND.belt_m_s(LEG, winter(0.5)) == pytest.approx(0.5 * GROUND.belt_m_s(LEG, winter(1.0)), rel=0.01)
    with pytest.raises(UsageError, match="below_hip_m"):
        replace(GROUND, below_hip_m=1.1).belt_m_s(LEG, winter(1.0))


@pytest.fixture(scope="module")
def prototype():
    pytest.importorskip("mujoco")
    from pam_ident.leg.prototype import Prototype

    return Prototype(LEG, winter(1.0), 5e-4, replace(GROUND, friction=0.0, damping_s_m=0.0))


def test_on_every_joint_it_is_the_slope_of_the_pads_energy(prototype):
    """Without friction and damping the pads store ½ k δ²; heel and ball are both pressed in at 5 % of the stride."""
    import mujoco

    def energy():
        deep = [HIP_HEIGHT_M - GROUND.below_hip_m - prototype.world("foot", p)[2] for p in sole(LEG)]
        return 0.5 * GROUND.stiffness_N_m * sum(max(d, 0.0) ** 2 for d in deep), deep

    prototype.reset(time_s=0.05)
    assert min(energy()[1]) > 0.0
    force, start = prototype._standing(prototype.ground), prototype.data.qpos.copy()
    for k in range(prototype.model.nv):
        ends = []
        for step in (-1e-6, 1e-6):
            prototype.data.qpos[:] = start
            prototype.data.qpos[k] += step
            mujoco.mj_kinematics(prototype.model, prototype.data)
            ends.append(energy()[0])
        assert force[k] == pytest.approx(-(ends[1] - ends[0]) / 2e-6, rel=1e-5, abs=1e-6)


def test_in_the_air_nothing_is_felt(prototype):
    prototype.reset(time_s=0.7)
    assert not np.any(prototype._standing(prototype.ground))
