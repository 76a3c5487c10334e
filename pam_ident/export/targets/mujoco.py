"""A fitted model as an actuator of MuJoCo: plain MJCF that is affine, and a Python file that makes it exact."""

from string import Template
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np

from ..fitted import Fitted, Span
from ..program import ARGUMENTS, Program, program
from ..target import Target, Written
from ..writer import check_name, harmless
from .python import PYTHON, python_function

USUAL = Span((0.0, 0.6), (0.0, 0.25))
"""Where the affine actuator is fitted if the range of the record is not known."""
GRID = 25

MODEL = Template("""<mujoco model="$name">
  <!-- $about
       A muscle that holds a load of 10 kg. Copy the tendon and the actuator into a model of your own: the tendon's
       length in m is the muscle's, control is the gauge pressure in MPa, and the muscle pulls with a negative force.
       The actuator is affine in length: force = control * (gain0 + gain1 * length) + bias0 + bias1 * length.
       At rest it misses the fitted model by $rms N rms, $most N at most, between $p_low and $p_high MPa and
       contractions of $e_low and $e_high. install() of $name.py makes it exact, hysteresis included. -->
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <site name="${name}_top" pos="0 0 0"/>
    <body name="${name}_load" pos="0 0 -$length">
      <joint name="${name}_slide" type="slide" axis="0 0 1" range="$down $up" limited="true" damping="50"/>
      <geom type="sphere" size="0.03" mass="10"/>
      <site name="${name}_end" pos="0 0 0"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="$name" width="0.01"><site site="${name}_top"/><site site="${name}_end"/></spatial>
  </tendon>
  <actuator>
    <general name="$name" tendon="$name" ctrllimited="true" ctrlrange="0 $p_high" gaintype="affine" biastype="affine"
             gainprm="$gain 0" biasprm="$bias 0"/>
  </actuator>
</mujoco>
""")
MARK = "def install(model, actuator="
INSTALL = Template('''

def install(model, actuator="$name", cycle=1.0, temperature_C=20.0):
    """Give an actuator on a tendon or slide (length in m, control in MPa) the force of the fitted model.

    The direction of motion is tanh(velocity/0.2 mm/s); `cycle` and `temperature_C` stay as they are. What the muscle
    remembers moves on with the time of the data: one data at a time, and no integrator that tries ahead (RK4).
    A reset of the time begins anew. Callbacks that were there before are kept for other actuators.
    """
    import mujoco

    index = model.actuator(actuator).id
    model.actuator_gaintype[index] = mujoco.mjtGain.mjGAIN_USER
    model.actuator_biastype[index] = mujoco.mjtBias.mjBIAS_USER
    low, high = model.actuator_ctrlrange[index] if model.actuator_ctrllimited[index] else (-np.inf, np.inf)
    other_gain, other_bias = mujoco.get_mjcb_act_gain(), mujoco.get_mjcb_act_bias()
    time, last, now = None, None, None

    def gain(m, d, k):
        if k == index:
            return 0.0
        return 1.0 if other_gain is None else other_gain(m, d, k)

    def bias(m, d, k):
        nonlocal time, last, now
        if k != index:
            return 0.0 if other_bias is None else other_bias(m, d, k)
        if time is None or d.time < time:
            last = None
        elif d.time > time:
            last = now
        time = d.time
        velocity_mm_s = -1000.0 * d.actuator_velocity[k]
        given = {
            "pressure_MPa": np.clip(d.ctrl[k], low, high),
            "contraction": 1.0 - 1000.0 * d.actuator_length[k] / $length_mm,
            "velocity_mm_s": velocity_mm_s,
            "direction": np.tanh(velocity_mm_s / 0.2),
            "time_s": d.time,
            "cycle": cycle,
            "temperature_C": temperature_C,
            "held": 0.0,
        }
        $call
        return -float(force)

    mujoco.set_mjcb_act_gain(gain)
    mujoco.set_mjcb_act_bias(bias)
''')


class Affine(NamedTuple):
    """Force = pressure (gain0 + gain1 length) + bias0 + bias1 length, MPa and m to N; what it misses, N."""

    gain: tuple[float, float]
    bias: tuple[float, float]
    rms_N: float
    most_N: float


def mujoco_actuator(fitted: Fitted, name: str) -> Written:
    """An actuator for a fitted model: an MJCF file, and beside it a Python file. Raises UsageError for a name that
    Python does not take, or a model that cannot be exported."""
    check_name(name, PYTHON)
    made = program(fitted)
    span, length_mm = fitted.span or USUAL, fitted.specimen.initial_length_mm
    line = affine(fitted, made)
    (p_low, p_high), (e_low, e_high) = span
    about = harmless(f"{fitted.model.law.name} fitted to {fitted.record} by pam-ident.")
    xml = MODEL.substitute(
        name=name,
        about=escape(about.replace("--", "- -").rstrip("-")),  # which cannot end a comment of XML
        length=repr(length_mm / 1000.0),
        down=repr(min(e_low, 0.0) * length_mm / 1000.0),
        up=repr(e_high * length_mm / 1000.0),
        rms=f"{line.rms_N:.3g}",
        most=f"{line.most_N:.3g}",
        p_low=f"{p_low:.4g}",
        p_high=f"{p_high:.4g}",
        e_low=f"{e_low:.4g}",
        e_high=f"{e_high:.4g}",
        gain=" ".join(repr(-x) for x in line.gain),
        bias=" ".join(repr(-x) for x in line.bias),
    )
    listed = ", ".join(f'given["{argument}"]' for argument in made.arguments)
    call = f"force = {name}({listed})" if made.later is None else f"force, now = {name}({listed}, state=last)"
    python = python_function(fitted, name) + INSTALL.substitute(name=name, length_mm=repr(length_mm), call=call)
    note = (
        f"{name}.xml alone is affine in length: off the fitted model by {line.rms_N:.3g} N rms, {line.most_N:.3g} N at "
        f"most; install() of {name}.py makes it exact"
    )
    return Written(xml, {".py": python}, (note,), MARK)


def affine(fitted: Fitted, made: Program) -> Affine:
    """Least squares over the range of the record, of the muscle at rest and before it has moved."""
    span, length_mm = fitted.span or USUAL, fitted.specimen.initial_length_mm
    p, e = (grid.ravel() for grid in np.meshgrid(*(np.linspace(*ends, GRID) for ends in span)))
    given = dict.fromkeys(ARGUMENTS, np.zeros(len(p))) | {"pressure_MPa": p, "contraction": e}
    given |= {"cycle": np.ones(len(p)), "temperature_C": np.full(len(p), 20.0)}
    force = np.broadcast_to(made.graph.evaluate(made.first.force, given | made.values(fitted)), p.shape)
    length = length_mm / 1000.0 * (1.0 - e)
    columns = np.stack([p, p * length, np.ones(len(p)), length], axis=1)
    found = np.linalg.lstsq(columns, force, rcond=None)[0]
    missed = force - columns @ found
    gain0, gain1, bias0, bias1 = (float(x) for x in found)
    return Affine((gain0, gain1), (bias0, bias1), float(np.sqrt(np.mean(missed**2))), float(np.abs(missed).max()))


TARGET = Target(".xml", mujoco_actuator)
