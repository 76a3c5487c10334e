"""The actuator in MuJoCo itself: plain, and made exact."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from cases import BY_NAME, MUSCLE

from pam_ident.core import Inputs
from pam_ident.core.recursion import Live
from pam_ident.export.program import program
from pam_ident.export.targets.mujoco import affine, mujoco_actuator
from pam_ident.leg import prototype

if find_spec("mujoco") is None:
    pytest.skip("no MuJoCo", allow_module_level=True)
mujoco = prototype.mujoco()  # set up to draw without a screen, as other tests in this process may want


@pytest.fixture(autouse=True)
def callbacks():
    """None left over from another test."""
    yield
    mujoco.set_mjcb_act_gain(None)
    mujoco.set_mjcb_act_bias(None)


def build(case, name="muscle"):
    made = mujoco_actuator(case.fitted, name)
    defined: dict = {}
    exec(made.beside[".py"], defined)
    model = mujoco.MjModel.from_xml_string(str(made.text))
    return made, model, mujoco.MjData(model), defined["install"]


def set_state(model, data, contraction, velocity_mm_s, pressure):
    """The load hangs lower the longer the muscle is."""
    data.qpos[0], data.qvel[0], data.ctrl[0] = 0.2 * contraction, 1e-3 * velocity_mm_s, pressure
    mujoco.mj_forward(model, data)
    return float(data.actuator_force[0])


def at_rest(case, p, e):
    one = Inputs(np.atleast_1d(p), np.atleast_1d(e), MUSCLE, np.zeros(np.size(p)), live=Live(None))
    return case.model.force(one, case.branches["together"])


@pytest.mark.parametrize("name", ["law_exponential_law", "law_hildebrandt", "bladder_elasticity_gent"])
def test_the_plain_actuator_is_off_by_what_it_says(name):
    """Asked of MuJoCo on a grid as fine as that of its least squares."""
    case = BY_NAME[name]
    made, model, data, _ = build(case)
    (p_low, p_high), (e_low, e_high) = case.fitted.span
    off = []
    for p in np.linspace(p_low, p_high, 25):
        for e in np.linspace(e_low, e_high, 25):
            off.append(-set_state(model, data, e, 0.0, p) - at_rest(case, p, e)[0])
    line = affine(case.fitted, program(case.fitted))
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(line.rms_N, rel=1e-6)
    assert np.abs(off).max() == pytest.approx(line.most_N, rel=1e-6)
    assert f"{line.rms_N:.3g} N rms" in made.text


def test_a_force_that_is_affine_is_met_without_error():
    """F = π r0² p [a(1−ε)² − b] is not; F = p (a0 + a1 ε) + b0 + b1 ε is."""
    case = BY_NAME["law_polynomial"]
    values = dict.fromkeys(case.branches["together"], 0.0) | {"a0": 2000.0, "a1": -6000.0, "b0": -50.0, "b1": 300.0}
    case = replace(case, branches={"together": values})
    _, model, data, _ = build(case)
    assert affine(case.fitted, program(case.fitted)).most_N < 1e-9
    assert set_state(model, data, 0.1, 0.0, 0.5) == pytest.approx(-(0.5 * 1400.0 - 20.0), rel=1e-9)


@pytest.mark.parametrize("name", ["law_martens_boblan", "coulomb_friction_smooth", "viscous_damping_power"])
def test_once_installed_the_actuator_pulls_with_the_models_force(name):
    case = BY_NAME[name]
    _, model, data, install = build(case)
    install(model)
    rng = np.random.default_rng(2)
    for p, e, v in rng.uniform((0.0, 0.0, -60.0), (0.7, 0.28, 60.0), (200, 3)):
        one = Inputs(
            np.array([p]),
            np.array([e]),
            MUSCLE,
            np.array([np.tanh(v / 0.2)]),
            velocity=np.array([v]),
            stroke_speed=np.array([abs(v)]),
            moving=np.ones(1, bool),
        )
        expected = case.model.force(one, case.branches["together"])[0]
        assert -set_state(model, data, e, v, p) == pytest.approx(expected, rel=1e-11, abs=1e-9)


@pytest.mark.long
def test_what_remembers_is_stepped_along_a_run_of_mujoco():
    """The forces that MuJoCo applied in 400 steps, against the model stepped along the motion that they led to."""
    case = BY_NAME["rich"]
    _, model, data, install = build(case)
    install(model)
    data.qpos[0] = 0.02
    seen = []
    for k in range(400):
        data.ctrl[0] = 0.35 + 0.2 * np.sin(0.02 * k)
        mujoco.mj_forward(model, data)  # a second look at the same instant changes nothing
        e, v = 1.0 - 5.0 * data.actuator_length[0], -1000.0 * data.actuator_velocity[0]
        seen.append((data.ctrl[0], e, v, data.time, -data.actuator_force[0]))
        mujoco.mj_step(model, data)
    memory = None
    values = case.branches["together"]
    for p, e, v, t, applied in seen:
        one = Inputs(
            np.array([p]),
            np.array([e]),
            MUSCLE,
            np.array([np.tanh(v / 0.2)]),
            np.array([t]),
            np.array([v]),
            np.array([abs(v)]),
            np.ones(1, bool),
            np.ones(1),
            np.full(1, 20.0),
            np.zeros(1, int),
        )
        force, memory = case.model.step(one, values, memory)
        assert applied == pytest.approx(force[0], rel=2e-9)
    lengths = np.array([e for _, e, *_ in seen])
    assert np.ptp(lengths) > 0.02  # it did move


def test_a_reset_begins_anew_and_other_actuators_keep_their_callbacks():
    case = BY_NAME["creep_textbook"]
    _, model, data, install = build(case)
    mujoco.set_mjcb_act_bias(lambda m, d, k: 12345.0)
    install(model)
    data.ctrl[0] = 0.4
    first = [_stepped(model, data) for _ in range(50)]
    mujoco.mj_resetData(model, data)
    data.ctrl[0] = 0.4
    assert [_stepped(model, data) for _ in range(50)] == first
    assert mujoco.get_mjcb_act_bias()(model, data, 7) == 12345.0


def _stepped(model, data):
    mujoco.mj_step(model, data)
    return float(data.actuator_force[0])


def test_a_hostile_record_stays_in_its_comment():
    case = BY_NAME["law_exponential_law"]
    made = mujoco_actuator(replace(case.fitted, record="a --><worldbody/> & <b> --"), "muscle")
    model = mujoco.MjModel.from_xml_string(str(made.text))
    assert model.nu == 1 and model.nbody == 2
