"""The virtual prototype: the leg in MuJoCo, stepped under a torque on its sprocket."""

import os
import sys
from ctypes.util import find_library
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from ..core import UsageError
from . import mjcf
from .anatomy import Leg
from .gait import Gait, LegAngles
from .joint import passive_torque
from .treadmill import Treadmill, sole


class Angles(NamedTuple):
    """What the prototype's bodies show: rad and rad/s, in the senses of the gait and the sprocket."""

    knee: float
    knee_rate: float
    sprocket: float
    sprocket_rate: float
    hip: float
    ankle: float


def mujoco() -> Any:
    """The module, set up to draw without a screen unless MUJOCO_GL says otherwise. Raises UsageError without it."""
    if sys.platform == "linux":
        os.environ.setdefault("MUJOCO_GL", "egl" if find_library("EGL") else "off")
    try:
        return import_module("mujoco")
    except ModuleNotFoundError:
        raise UsageError("the prototype needs MuJoCo, which is missing: pip install 'pam-ident[prototype]'") from None
    except Exception as error:  # it sets up its drawing on import, and each backend fails in a type of its own
        raise UsageError(
            f"MuJoCo cannot be loaded with MUJOCO_GL={os.environ.get('MUJOCO_GL')} ({error}); "
            "set MUJOCO_GL to egl, osmesa, glfw or off, whichever this machine has"
        ) from None


class Prototype:
    """The leg on its stand, hip and ankle led along `gait` by their servos, `step_s` a step.

    Its knee is the linkage itself: four bodies, their loop closed by a stiff constraint. It shares with the reduced
    joint the dimensions and the passive torque on the flexion, and none of the equations of motion.
    """

    def __init__(self, leg: Leg, gait: Gait, step_s: float = 5e-4, ground: Treadmill | None = None) -> None:
        """Build the model and put it at the gait's start. Raises UsageError where MuJoCo is missing, or where the gait
        does not touch a `ground`."""
        self._mj = mujoco()
        self.leg, self.gait, self.step_s, self.ground = leg, gait, step_s, ground
        self._belt = 0.0 if ground is None else ground.belt_m_s(leg, gait)
        self.model = self._mj.MjModel.from_xml_string(mjcf.write(leg, step_s, ground))
        self.data = self._mj.MjData(self.model)
        self._joint = {name: int(self.model.joint(name).id) for name in ("hip", "rocker", "crank", "coupler", "ankle")}
        self._body = {name: int(self.model.body(name).id) for name in ("thigh", "shank", "foot", "rocker")}
        self.reset()

    def reset(self, flexion: float | None = None, rate: float | None = None, time_s: float = 0.0) -> None:
        """Put the leg where the gait is at `time_s`, the knee at `flexion` in rad and `rate` in rad/s if given."""
        motion = self.gait.at(time_s)
        flexion = float(motion.knee.angle) if flexion is None else flexion
        rate = float(motion.knee.rate) if rate is None else rate
        self._mj.mj_resetData(self.model, self.data)
        self._place(self.data, flexion, motion.hip.angle, motion.ankle.angle)
        posture = self.leg.knee.at(flexion)
        link, moving = posture.rocker[0], posture.rocker[1]
        turning = -float((link.conjugate() * moving).imag) / abs(link) ** 2
        speeds = {
            "hip": motion.hip.rate,
            "ankle": motion.ankle.rate,
            "crank": posture.ratio * rate,
            "coupler": (1.0 - posture.ratio) * rate,
            "rocker": turning * rate,
        }
        for name, speed in speeds.items():
            self.data.qvel[self._joint[name]] = speed
        self._mj.mj_forward(self.model, self.data)

    def _place(self, data: Any, flexion: float, hip: float, ankle: float) -> None:
        """Angles of all joints of `data`, the linkage closed exactly."""
        posture = self.leg.knee.at(flexion)
        rocker = self.leg.knee.rocker_shank - self.leg.knee.rocker_thigh
        places = {
            "hip": hip,
            "ankle": ankle,
            "crank": posture.sprocket,
            "coupler": flexion - posture.sprocket,
            "rocker": -np.angle(posture.rocker[0] / rocker),
        }
        for name, angle in places.items():
            data.qpos[self._joint[name]] = angle

    def posed(self, angles: Angles) -> Any:
        """MuJoCo's data of another posture, its linkage closed, for drawing; this prototype's own stays as it is."""
        data = self._mj.MjData(self.model)
        self._place(data, angles.knee, angles.hip, angles.ankle)
        self._mj.mj_forward(self.model, data)
        return data

    def step(self, sprocket_torque: float, time_s: float) -> None:
        """One step from `time_s` under that torque, N·m, positive flexes; the servos follow the gait."""
        now, motion, data = self.angles(), self.gait.at(time_s), self.data
        data.ctrl[:] = self._targets(motion)
        data.qfrc_applied[:] = 0.0 if self.ground is None else self._standing(self.ground)
        data.qfrc_applied[self._joint["crank"]] += sprocket_torque
        passive = float(passive_torque(self.leg, now.knee, now.knee_rate))
        data.xfrc_applied[self._body["shank"], 4] = passive
        data.xfrc_applied[self._body["thigh"], 4] = -passive
        self._mj.mj_step(self.model, data)

    def _standing(self, ground: Treadmill) -> np.ndarray:
        """Generalised forces of the ground on all joints, shape (joints,)."""
        found = np.zeros(self.model.nv)
        along = np.zeros((3, self.model.nv))
        for point in sole(self.leg):
            place = self.world("foot", point)
            depth = mjcf.HIP_HEIGHT_M - ground.below_hip_m - place[2]
            if depth > 0.0:
                self._mj.mj_jac(self.model, self.data, along, None, place, self._body["foot"])
                forward, _, rising = along @ self.data.qvel
                ahead, up = ground.force(depth, -rising, forward + self._belt)
                found += along.T @ np.array([ahead, 0.0, up])
        return found

    def angles(self) -> Angles:
        """Angles now; the knee's is what the shank has turned against the thigh, by way of the crank."""
        q, v = self.data.qpos, self.data.qvel
        crank, coupler = self._joint["crank"], self._joint["coupler"]
        return Angles(
            float(q[crank] + q[coupler]),
            float(v[crank] + v[coupler]),
            float(q[crank]),
            float(v[crank]),
            float(q[self._joint["hip"]]),
            float(q[self._joint["ankle"]]),
        )

    def _targets(self, motion: LegAngles) -> tuple[float, float]:
        """Angles that hip and ankle are told: the gait's, led by what the servo's stiffness will give way.

        That is its damping, and the torque that the wanted acceleration takes under the weight, as a drive with a
        model of its load computes it. The knee's acceleration is left out of that: what it shakes the hip by remains.
        """
        led = (
            (self._joint["hip"], self.leg.hip_servo, motion.hip),
            (self._joint["ankle"], self.leg.ankle_servo, motion.ankle),
        )
        wanted, torque = np.zeros(self.model.nv), np.zeros(self.model.nv)
        for place, _, swing in led:
            wanted[place] = swing.acceleration
        self._mj.mj_mulM(self.model, self.data, torque, wanted)
        torque += self.data.qfrc_bias
        hip, ankle = (
            float(swing.angle + (servo.damping_N_m_s * swing.rate + torque[place]) / servo.stiffness_N_m)
            for place, servo, swing in led
        )
        return hip, ankle

    def world(self, body: str, place: complex) -> np.ndarray:
        """A place in a body's frame, m, in the world; (3,)."""
        turn = self.data.xmat[self._body[body]].reshape(3, 3)
        return self.data.xpos[self._body[body]] + turn @ np.array([place.real, 0.0, place.imag])
