"""Fixture and load cell give way under load, so that the muscle is shorter than the sensor says."""

from dataclasses import replace

from ..core import Inputs, Param, Range
from .base import Array, Effect, TransformsContraction, Values, free_form, one

COMPLIANCE = Param("compliance", "mm/kN", "stretch of fixture and load cell per force, 1/K", 0.0, 100.0, scale=1.0)
STIFF = Range(0.0, 60.0, "fixtures, as soft as a cord that gives way by 3 mm at 50 N")
CONSTANT = replace(COMPLIANCE, range=STIFF)
N = Param("n", "1", "exponent of the stretch over force", 0.3, 1.0, start=0.67, grid=(0.5, 0.67))
KNOTS = (0.0, 0.06, 0.2, 0.5, 1.2)
"""Forces, as shares of the ideal blocked force at 0.5 MPa, between which the free form's compliance is linear."""
F_1 = Param("F_1", "N", "force at which the compliance has halved", 20.0, 1e5, start=400.0, grid=(80.0, 400.0))


def _columns(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(force * 1e-3 / inputs.specimen.initial_length_mm)


def _stiffening(inputs: Inputs, values: Values, force: Array) -> Array:
    return _columns(inputs, values, force) / (1.0 + inputs.xp.maximum(force, 0.0)[:, None] / values["F_1"])


def _contact(inputs: Inputs, values: Values, force: Array) -> Array:
    """As of bodies that touch in a point or a line: half to two thirds as the exponent (Hertz 1882)."""
    share = inputs.xp.maximum(force, 1e-3) / 1000.0
    return one(share ** values["n"] / inputs.specimen.initial_length_mm)


def _giving(inputs: Inputs, values: Values, force: Array) -> Array:
    """Any stretch that grows with the force: integrals over it of hats at KNOTS (I-splines: Ramsay 1988, Statistical
    Science 3, 425–441)."""
    xp = inputs.xp
    knots = inputs.specimen.ideal_force(xp.asarray(0.5), xp.asarray(0.0)) * xp.asarray(KNOTS)
    width, above = knots[1:] - knots[:-1], force[:, None] - knots[:-1]
    ramps = xp.clip(above, 0.0, width) ** 2 / (2.0 * width) + xp.maximum(above - width, 0.0)
    whole, nothing = xp.maximum(force, 0.0)[:, None], xp.zeros((len(force), 1))
    stretch = xp.concat([whole, ramps], axis=1) - xp.concat([ramps, nothing], axis=1)
    return 1e-3 * stretch / inputs.specimen.initial_length_mm


EFFECT = Effect(
    name="series_compliance",
    title="compliance in series",
    source="machine compliance in force–length tests, ε_muscle = ε_measured + F/(K L0)",
    forms=(
        TransformsContraction("textbook", "ε → ε + F/(K L0)", (CONSTANT,), _columns, uses_force=True),
        TransformsContraction(
            "stiffening", "ε → ε + F/(K L0 (1 + F/F_1))", (COMPLIANCE,), _stiffening, (F_1,), uses_force=True
        ),
        free_form(
            "ε → ε + ∫ B_k(F) dF / L0",
            _giving,
            count=len(KNOTS),
            pressure=0,
            contraction=0,
            role=TransformsContraction,
            unit=("mm/kN", 1.0),
            uses_force=True,
            resisting=len(KNOTS),
        ),
        TransformsContraction("contact", "ε → ε + (F/1000 N)^n/(K L0)", (COMPLIANCE,), _contact, (N,), uses_force=True),
    ),
    follows=("map",),
    test="a steel bar in place of the muscle",
    levers=("pressure",),
)
