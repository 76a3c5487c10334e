"""Force against the speed of motion."""

from ..core import Inputs, Param
from .base import AddsForce, Array, Effect, Values, free_form, one, speed

B = Param("B", "N·s/m", "damping (for n ≠ 1 at 10 mm/s)", 0.0, 1e5, scale=100.0)
B_C = Param("B_c", "N·s/m", "damping in contraction", 0.0, 1e5, scale=100.0)
B_E = Param("B_e", "N·s/m", "damping in extension", 0.0, 1e5, scale=100.0)
# Both parts stay above zero: damping that falls with pressure would give energy back at a high one.
B_P = Param("B_p", "N·s/(m·MPa)", "damping per pressure", 0.0, 1e5, scale=100.0)
# A power below 0.4 hardly changes with speed: it took the place of friction.
N = Param("n", "1", "exponent of the speed", 0.4, 2.5, start=0.7, grid=(0.5, 0.7, 1.0, 1.5))
V_1 = Param("v_1", "mm/s", "speed at which thinning has halved the damping", 4.0, 1000.0, start=20.0, grid=(8.0, 30.0))


def _linear(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.velocity is not None
    return one(-inputs.velocity * 1e-3)


def _power(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.velocity is not None
    return one(-inputs.xp.sign(inputs.velocity) * 0.01 * (speed(inputs) / 10.0) ** values["n"])


def _powers(inputs: Inputs, values: Values, force: Array) -> Array:
    xp, force = inputs.xp, 100.0 * _power(inputs, values, force)
    return xp.hstack([xp.minimum(force, 0.0), xp.maximum(force, 0.0)])


def _thinning(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.velocity is not None
    return one(-inputs.velocity * 1e-3 / (1.0 + speed(inputs) / values["v_1"]))


def _asymmetric(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.velocity is not None
    xp, v = inputs.xp, inputs.velocity * 1e-3
    return -xp.stack([xp.maximum(v, 0.0), xp.minimum(v, 0.0)]).T


def _pressure(inputs: Inputs, values: Values, force: Array) -> Array:
    column = _power(inputs, values, force)
    return inputs.xp.hstack([column, column * inputs.pressure[:, None]])


EFFECT = Effect(
    name="viscous_damping",
    title="viscous damping",
    source="Reynolds et al. 2003, Annals of Biomedical Engineering 31, 310–317",
    forms=(
        AddsForce("textbook", "−B ε̇ L0", (B,), _linear),
        AddsForce("power", "−B |ẋ|^n sgn(ẋ)", (B,), _power, (N,)),
        AddsForce("thinning", "−B ẋ/(1 + |ẋ|/v_1)", (B,), _thinning, (V_1,)),
        AddsForce("asymmetric", "−B_c ẋ in contraction, −B_e ẋ in extension", (B_C, B_E), _asymmetric),
        AddsForce("pressure", "−(B + B_p p) |ẋ|^n sgn(ẋ)", (B, B_P), _pressure, (N,)),
        free_form(
            "−|ẋ/10 mm/s|^n sgn(ẋ), in contraction and in extension",
            _powers,
            2,
            contraction=1,
            nonlinear=(N,),
            resisting=2,
        ),
    ),
    follows=("speed",),
    test="at least two speeds: the gap between the branches grows with speed",
    needs=("branch", "motion"),
    levers=("speed",),
)
