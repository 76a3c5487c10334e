"""The whole leg as a MuJoCo model: hip, four-bar knee closed by a constraint, ankle, muscles drawn over the sprocket.

World: x forward, z up, so that a turn about +y flexes the knee and one about −y lifts thigh and toes. Geoms are there
to be seen: masses are given apart from them, and what the ground does is applied while stepping.
"""

from .anatomy import Leg, Segment, Servo
from .joint import GRAVITY
from .treadmill import Treadmill

HIP_HEIGHT_M = 1.0
"""Of the stand; the foot does not reach the floor."""
MUSCLE_M = 0.20
"""Drawn length of the muscles at rest."""
CHAIN_M = 0.040
"""How far to the left of the links muscles, chains and sprocket lie."""

STYLE = """
  <visual>
    <headlight ambient="0.42 0.42 0.44" diffuse="0.5 0.5 0.5" specular="0.1 0.1 0.1"/>
    <quality shadowsize="2048" offsamples="4"/>
    <global offwidth="1600" offheight="1600"/>
    <map znear="0.02" zfar="40"/>
  </visual>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.97 0.98 1" rgb2="0.86 0.90 0.95" width="64" height="384"/>
    <texture name="floor" type="2d" builtin="checker" rgb1=".93 .94 .95" rgb2=".88 .90 .92" width="256" height="256"/>
    <material name="floor" texture="floor" texrepeat="12 12" emission="0.30" reflectance="0.04"/>
    <material name="bone" rgba="0.90 0.88 0.83 1" specular="0.25" shininess="0.4"/>
    <material name="steel" rgba="0.42 0.47 0.54 1" specular="0.6" shininess="0.7"/>
    <material name="crank" rgba="0.90 0.62 0.00 1" specular="0.4"/>
    <material name="rocker" rgba="0.00 0.62 0.45 1" specular="0.4"/>
    <material name="flexor" rgba="0.84 0.37 0.00 1" specular="0.1"/>
    <material name="extensor" rgba="0.00 0.45 0.70 1" specular="0.1"/>
    <material name="dark" rgba="0.20 0.24 0.29 1"/>
  </asset>"""


def _at(place: complex, y: float = 0.0) -> str:
    return f"{place.real:.9g} {y:.9g} {place.imag:.9g}"


def _inertial(segment: Segment, shift: complex = 0.0, extra_kg: float = 0.0) -> str:
    """Mass and inertia of a segment whose frame lies at `shift` from the body's; the sideways inertia is not felt."""
    inertia = segment.inertia_kg_m2
    return (
        f'<inertial pos="{_at(segment.centre_m + shift)}" mass="{segment.mass_kg + extra_kg:.12g}" '
        f'diaginertia="{inertia:.12g} {inertia:.12g} {inertia:.12g}"/>'
    )


def _rod(name: str, pivot: complex, end: complex, mass: float, side: float, extra: float = 0.0, more: str = "") -> str:
    """Opening of a body for a link from its pivot, with its hinge; `side` is where it is drawn, m to the left."""
    link = end - pivot
    inertia = mass * abs(link) ** 2 / 12.0 + extra
    return f"""<body name="{name}" pos="{_at(pivot)}">
        <joint name="{name}" axis="0 1 0"/>
        {_inertial(Segment(abs(link), mass, 0.5 * link, inertia))}
        <geom type="capsule" fromto="{_at(0j, side)} {_at(link, side)}" size="0.006" material="{name}"/>{more}"""


def _prong(start: complex, pivot: complex) -> str:
    """A prong of a bone to a pivot of the linkage, and the pin there."""
    return (
        f'<geom type="capsule" fromto="{_at(start)} {_at(pivot)}" size="0.008" material="bone"/>'
        f'<geom type="cylinder" fromto="{_at(pivot, -0.034)} {_at(pivot, 0.012)}" size="0.0045" material="dark"/>'
    )


def _muscle(name: str, side: float, thigh: float) -> str:
    """A muscle along the thigh, before (side 1) or behind it (−1): fittings, braid, and where its chain begins."""
    x = 0.055 * side
    top, low = x - 0.06j, x - (0.06 + MUSCLE_M) * 1j
    return f"""
      <geom type="capsule" fromto="{_at(top, CHAIN_M)} {_at(low, CHAIN_M)}" size="0.017" material="{name}"/>
      <geom type="cylinder" fromto="{_at(top + 0.05j, CHAIN_M)} {_at(top, CHAIN_M)}" size="0.009" material="steel"/>
      <geom type="cylinder" fromto="{_at(low, CHAIN_M)} {_at(low - 0.03j, CHAIN_M)}" size="0.009" material="steel"/>
      <site name="{name}_chain" pos="{_at(low - 0.03j, CHAIN_M)}" size="0.001" rgba="0 0 0 0"/>
      <site name="{name}_side" pos="{_at(2.0 * x - 1j * thigh, CHAIN_M)}" size="0.001" rgba="0 0 0 0"/>"""


def _drive(joint: str, servo: Servo) -> str:
    return (
        f'<position name="{joint}" joint="{joint}" kp="{servo.stiffness_N_m}" kv="{servo.damping_N_m_s}" '
        f'forcerange="{-servo.torque_limit_N_m} {servo.torque_limit_N_m}"/>'
    )


def _thigh(leg: Leg, straight: complex) -> str:
    """Inside of the thigh's body, less the links; `straight` is the knee's origin in its frame."""
    fork = straight + 0.05j
    return f"""<joint name="hip" axis="0 -1 0" armature="{leg.hip_servo.reflected_kg_m2:.12g}"/>
      {_inertial(leg.thigh)}
      <geom type="cylinder" fromto="0 -0.035 0 0 0.035 0" size="0.042" material="dark"/>
      <geom type="capsule" fromto="{_at(0j)} {_at(fork)}" size="0.020" material="bone"/>
      <geom type="box" pos="{_at(-0.025j)}" size="0.075 0.012 0.010" material="steel"/>
      {_prong(fork, straight + leg.knee.crank_thigh)}{_prong(fork, straight + leg.knee.rocker_thigh)}
      {_muscle("extensor", 1.0, leg.thigh.length_m)}{_muscle("flexor", -1.0, leg.thigh.length_m)}"""


def _shank(leg: Leg) -> str:
    """Body of the shank on the crank's end, where its frame lies, with the foot."""
    knee, shift = leg.knee, -leg.knee.crank_shank
    ankle, fork, sole = shift - 1j * leg.shank.length_m, shift - 0.07j, -1j * leg.foot.length_m
    heel, toe = sole - 0.06 + 0.016j, sole + 0.16 + 0.016j
    return f"""<body name="shank" pos="{_at(knee.crank_shank - knee.crank_thigh)}">
          <joint name="coupler" axis="0 1 0"/>
          {_inertial(leg.shank, shift)}
          <geom type="capsule" fromto="{_at(fork)} {_at(ankle)}" size="0.018" material="bone"/>
          {_prong(fork, 0j)}{_prong(fork, knee.rocker_shank + shift)}
          <body name="foot" pos="{_at(ankle)}">
            <joint name="ankle" axis="0 -1 0" armature="{leg.ankle_servo.reflected_kg_m2:.12g}"/>
            {_inertial(leg.foot, extra_kg=leg.load_mass_kg)}
            <geom type="cylinder" fromto="0 -0.032 0 0 0.032 0" size="0.028" material="dark"/>
            <geom type="capsule" fromto="{_at(0j)} {_at(heel)}" size="0.016" material="bone"/>
            <geom type="capsule" fromto="{_at(0j)} {_at(toe)}" size="0.014" material="bone"/>
            <geom type="box" pos="{_at(sole + 0.065 + 0.006j)}" size="0.128 0.038 0.006" material="dark"/>
          </body>
        </body>"""


def _wheel(radius: float) -> str:
    """The sprocket on its axle, fixed to the crank, with the ends of both chains."""
    end = _at(-1j * radius, CHAIN_M)
    return f"""
        <geom name="sprocket" type="cylinder" fromto="0 .036 0 0 .044 0" size="{radius}" material="steel"/>
        <geom type="cylinder" fromto="0 -0.010 0 0 0.046 0" size="0.008" material="dark"/>
        <site name="flexor_end" pos="{end}" size="0.001" rgba="0 0 0 0"/>
        <site name="extensor_end" pos="{end}" size="0.001" rgba="0 0 0 0"/>"""


def _chain(name: str) -> str:
    """The chain from a muscle over the sprocket: it is drawn and pulls at nothing."""
    return f"""<spatial name="{name}" width="0.004" material="dark">
      <site site="{name}_chain"/><geom geom="sprocket" sidesite="{name}_side"/><site site="{name}_end"/>
    </spatial>"""


def _pad(ground: Treadmill | None) -> str:
    """The padded belt, as it lies."""
    if ground is None:
        return ""
    top = HIP_HEIGHT_M - ground.below_hip_m
    return f'\n    <geom type="box" pos="0 0 {top / 2:.4g}" size="0.6 0.12 {top / 2:.4g}" material="dark"/>'


def write(leg: Leg, step_s: float, ground: Treadmill | None = None) -> str:
    """The leg as MJCF text, straight at zero, stepped by `step_s`.

    The links are uniform rods, the coupler is part of the shank. The loop is closed at the rocker's end on the shank.
    The sprocket's inertia turns with the crank; its mass counts as the thigh's. Hip and ankle are position servos with
    the reflected inertia of their rotors. Knee damping, stops and load torque are not in the file: they act on the
    flexion, which is no joint of it, and are applied while stepping.
    """
    knee, straight = leg.knee, -1j * leg.thigh.length_m
    level, post = HIP_HEIGHT_M - leg.thigh.length_m + 0.03, HIP_HEIGHT_M / 2 + 0.05
    crank_ends = straight + knee.crank_thigh, straight + knee.crank_shank
    rocker_ends = straight + knee.rocker_thigh, straight + knee.rocker_shank
    wheel = _wheel(leg.sprocket_radius_m)
    return f"""<mujoco model="leg">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{step_s}" integrator="implicitfast" gravity="0 0 {-GRAVITY}" iterations="50" tolerance="1e-12"/>
  <default>
    <geom contype="0" conaffinity="0" mass="0"/>
    <equality solref=".002 1" solimp=".9999 .9999 .001"/>
  </default>{STYLE}
  <worldbody>
    <light pos="-1.2 -2.5 3" dir="0.35 0.65 -0.8" diffuse="0.55 0.55 0.55" specular="0.2 0.2 0.2"/>
    <camera name="side" pos="0.06 -2.0 0.60" xyaxes="1 0 0 0 0.04 1" fovy="36"/>
    <camera name="knee" pos="0.04 -0.50 {level:.4g}" xyaxes="1 0 0 0 .05 1" fovy="34"/>
    <geom type="plane" size="8 8 0.1" material="floor"/>
    <geom type="box" pos="0 0.14 {post:.4g}" size="0.02 0.02 {post:.4g}" material="steel"/>
    <geom type="box" pos="0 0.14 0.01" size="0.28 0.10 0.01" material="steel"/>{_pad(ground)}
    <geom type="cylinder" fromto="0 0.03 {HIP_HEIGHT_M} 0 0.13 {HIP_HEIGHT_M}" size="0.05" material="dark"/>
    <body name="thigh" pos="0 0 {HIP_HEIGHT_M}">
      {_thigh(leg, straight)}
      {_rod("rocker", *rocker_ends, leg.rocker_mass_kg, -0.018)}
      </body>
      {_rod("crank", *crank_ends, leg.crank_mass_kg, -0.026, leg.sprocket_inertia_kg_m2, wheel)}
        {_shank(leg)}
      </body>
    </body>
  </worldbody>
  <tendon>{_chain("flexor")}{_chain("extensor")}</tendon>
  <equality>
    <connect body1="rocker" body2="shank" anchor="{_at(knee.rocker_shank - knee.rocker_thigh)}"/>
  </equality>
  <actuator>{_drive("hip", leg.hip_servo)}{_drive("ankle", leg.ankle_servo)}</actuator>
</mujoco>
"""
