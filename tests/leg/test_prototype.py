"""The MuJoCo prototype against the reduced joint, the linkage's closed form and the file it is built from."""

import os
import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from PIL import Image

from pam_ident.core import UsageError
from pam_ident.leg import prototype as prototypes
from pam_ident.leg.anatomy import LEG
from pam_ident.leg.gait import winter
from pam_ident.leg.joint import acceleration, inverse
from pam_ident.leg.prototype import Angles, Prototype
from pam_ident.leg.render import animation, frames, pictures

if find_spec("mujoco") is None:  # looked for only: to draw without a screen it must be imported by the prototype
    pytest.skip("MuJoCo is not installed; pip install 'pam-ident[prototype]'", allow_module_level=True)

STEP, GAIT = 5e-4, winter(1.0)
TIMES = STEP * np.arange(2001)


def reduced_stride(leg):
    """One stride of the reduced joint under inverse dynamics and a PD law: angles (n + 1,) rad, torques (n,) N·m."""
    motion = GAIT.at(TIMES)
    middle = GAIT.at(TIMES + STEP / 2)
    ahead = inverse(leg, motion.knee.angle, motion.knee.rate, motion.knee.acceleration, motion)

    def slope(y, torque, at, k):
        frozen = type(at)(*(type(s)(s.angle[k], s.rate[k], s.acceleration[k]) for s in at))
        return np.array([y[1], acceleration(leg, y[0], y[1], torque, frozen)])

    y, path, torques = np.array([motion.knee.angle[0], motion.knee.rate[0]]), [], []
    for k in range(len(TIMES) - 1):
        path.append(y)
        torque = ahead[k] + 100.0 * (motion.knee.angle[k] - y[0]) + 6.0 * (motion.knee.rate[k] - y[1])
        torques.append(torque)
        a = slope(y, torque, motion, k)
        b = slope(y + STEP / 2 * a, torque, middle, k)
        c = slope(y + STEP / 2 * b, torque, middle, k)
        d = slope(y + STEP * c, torque, motion, k + 1)
        y = y + STEP / 6 * (a + 2 * b + 2 * c + d)
    return np.array([*path, y])[:, 0], np.array(torques)


def run(leg, torques):
    """The prototype under torques given in advance: rows of angles (n + 1, 6) and the greatest gap of the loop, mm."""
    body = Prototype(leg, GAIT, STEP)
    rows, gap = [body.angles()], 0.0
    for time, torque in zip(TIMES, torques, strict=False):
        body.step(torque, time)
        rows.append(body.angles())
        gap = max(gap, gap_mm(body))
    return np.array(rows), gap


@pytest.mark.long
@pytest.mark.parametrize("leg", [LEG, replace(LEG, load_mass_kg=1.0, load_torque_N_m=-2.0)], ids=["bare", "loaded"])
def test_a_stride_under_the_same_torques_agrees_with_the_reduced_joint(leg):
    """No feedback from the prototype: what differs adds up over the stride.

    Found with the bare leg: knee 0.06° rms, gap 0.02 mm, hip within 0.04°; with the load the hip stays within 0.07°.
    """
    path, torques = reduced_stride(leg)
    rows, gap = run(leg, torques)
    assert np.ptp(np.degrees(path)) > 60.0
    assert np.degrees(np.sqrt(np.mean((rows[:, 0] - path) ** 2))) < 0.2
    assert gap < 0.05
    assert np.degrees(np.max(np.abs(leg.knee.at(rows[:, 0]).sprocket - rows[:, 2]))) < 0.02
    motion = GAIT.at(TIMES)
    assert np.degrees(np.max(np.abs(rows[:, 4] - motion.hip.angle))) < 0.1
    assert np.degrees(np.max(np.abs(rows[:, 5] - motion.ankle.angle))) < 0.1


def orientation(body, name):
    """Angle of a body against the world, counter-clockwise seen with x to the right and z up."""
    turn = body.data.body(name).xmat.reshape(3, 3)
    return np.arctan2(turn[2, 0], turn[0, 0])


def test_reset_puts_every_body_where_the_gait_is():
    body = Prototype(LEG, GAIT)
    for time in (0.0, 0.3, 0.72):
        body.reset(time_s=time)
        motion = GAIT.at(time)
        hip, knee, ankle = (float(s.angle) for s in (motion.hip, motion.knee, motion.ankle))
        assert orientation(body, "thigh") == pytest.approx(hip, abs=1e-12)
        assert orientation(body, "shank") == pytest.approx(hip - knee, abs=1e-12)
        assert orientation(body, "foot") == pytest.approx(hip - knee + ankle, abs=1e-12)
        assert gap_mm(body) < 1e-9
        foot = np.exp(1j * hip) * (-1j * LEG.thigh.length_m + LEG.knee.at(knee).knee[0])
        foot = foot + np.exp(1j * (hip - knee)) * -1j * LEG.shank.length_m
        place = body.data.body("foot").xpos
        assert complex(place[0], place[2] - 1.0) == pytest.approx(foot, abs=1e-12)
        # the loop's gap does not open either: all five rates fit together
        rates = np.array(body.data.qvel)
        before = gap_mm(body)
        body.data.qpos[:] += 1e-6 * rates
        prototypes.mujoco().mj_forward(body.model, body.data)
        assert gap_mm(body) - before < 1e-6


def test_it_weighs_what_the_leg_weighs():
    loaded = replace(LEG, load_mass_kg=2.0)
    expected = 7.0 + 3.255 + 1.015 + 2.0 + LEG.crank_mass_kg + LEG.rocker_mass_kg
    assert Prototype(loaded, GAIT).model.body_mass.sum() == pytest.approx(expected, rel=1e-9)


def test_the_flexor_s_torque_flexes():
    body = Prototype(LEG, GAIT)
    body.reset(flexion=0.5, rate=0.0)
    for k in range(40):
        body.step(30.0, k * STEP)
    pushed = body.angles()
    assert pushed.knee > 0.5 and pushed.sprocket > float(LEG.knee.at(0.5).sprocket)
    assert pushed.sprocket_rate / pushed.knee_rate == pytest.approx(float(LEG.knee.at(pushed.knee).ratio), rel=2e-3)


def test_missing_mujoco_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(UsageError, match=r"pip install 'pam-ident\[prototype\]'"):
        Prototype(LEG, GAIT)


def test_no_pictures_where_drawing_is_off_but_the_prototype_runs(root):
    script = (
        "from pam_ident.leg import prototype, anatomy, gait, render\n"
        "body = prototype.Prototype(anatomy.LEG, gait.winter())\n"
        "body.step(1.0, 0.0)\n"
        "try: render.frames(body, [body.angles()])\n"
        "except Exception as error: print(type(error).__name__, error)\n"
    )
    environment = {**os.environ, "MUJOCO_GL": "off", "PYTHONPATH": str(root)}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("UsageError no pictures: MuJoCo cannot draw here with MUJOCO_GL=off")


def gap_mm(body):
    """How far the rocker's end and its pivot on the shank lie apart."""
    knee = body.leg.knee
    end = body.world("rocker", knee.rocker_shank - knee.rocker_thigh)
    return 1e3 * np.linalg.norm(end - body.world("shank", knee.rocker_shank - knee.crank_shank))


@pytest.fixture(scope="module")
def drawing():
    body = Prototype(LEG, GAIT)
    try:
        frames(body, [body.angles()])
    except UsageError as error:
        pytest.skip(str(error))
    return body


def posture(time):
    motion = GAIT.at(time)
    return Angles(float(motion.knee.angle), 0.0, 0.0, 0.0, float(motion.hip.angle), float(motion.ankle.angle))


@pytest.mark.long
def test_pictures_show_the_leg_s_colours_and_move(drawing, tmp_path):
    state = drawing.data.qpos.copy()
    one, other = pictures(drawing, [posture(0.0), posture(0.7)], tmp_path / "new")
    assert [one.name, other.name] == ["leg_000.png", "leg_001.png"]
    a, b = (np.asarray(Image.open(path)).astype(int) for path in (one, other))
    assert a.shape == (760, 640, 3) and a.mean() > 128.0
    for picture in (a, b):
        red, _, blue = np.moveaxis(picture, -1, 0)
        assert np.sum(red - blue > 120) > 500 and np.sum(blue - red > 120) > 500  # flexor and extensor
    assert np.mean(np.abs(a - b).sum(axis=-1) > 60) > 0.02
    np.testing.assert_array_equal(drawing.data.qpos, state)


def test_animation_has_a_frame_a_posture(drawing, tmp_path):
    path = animation(drawing, [posture(t) for t in (0.0, 0.35, 0.7)], tmp_path / "gait.gif", 0.05)
    with Image.open(path) as film:
        assert film.n_frames == 3 and film.info["duration"] == 50 and film.info["loop"] == 0
