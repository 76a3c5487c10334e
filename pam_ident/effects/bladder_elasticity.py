"""The bladder resists being stretched around the hoop and shortened along the axis."""

import math

from ..core import Inputs, Param, Range
from .base import AddsForce, Array, Effect, Values, bernstein, one

RUBBER = "rubbers, 0.05 to 50 MPa in tension (Ashby, Materials Selection in Mechanical Design)"
SHEAR = Range(0.0, 17.0, RUBBER)
E_MOD = Param("E", "MPa", "Young's modulus of the bladder", 0.0, 200.0, scale=1.0, range=Range(0.0, 50.0, RUBBER))
K = Param("K", "N", "stiffness of the bladder over contraction", 0.0, 1e5, scale=50.0)
C1 = Param("C1", "MPa", "first Mooney–Rivlin constant", 0.0, 200.0, scale=0.2)
C2 = Param("C2", "MPa", "second Mooney–Rivlin constant", -200.0, 200.0, scale=0.2)
G = Param("G", "MPa", "shear modulus of the bladder", 0.0, 200.0, scale=0.3, range=SHEAR)
# Measured rubber softens before it stiffens, which the two constants of Mooney and Rivlin cannot follow.
C10 = Param("C10", "MPa", "first Yeoh constant, half the shear modulus", 0.0, 200.0, scale=0.3, range=SHEAR)
C20 = Param("C20", "MPa", "second Yeoh constant: softening where negative", -200.0, 200.0, scale=0.1)
C30 = Param("C30", "MPa", "third Yeoh constant: stiffening at large stretch", 0.0, 200.0, scale=0.05)
J_M = Param("J_m", "1", "limit of I1 − 3 at which the rubber locks", 0.3, 100.0, start=3.0, grid=(1.0, 3.0, 12.0))

RESISTS = tuple(Param(f"K_{i}", "N", f"resistance around ε = {0.075 * i:g}", 0.0, 1e5, scale=10.0) for i in range(1, 5))


def wall(inputs: Inputs) -> float:
    """Wall thickness in mm; 1 mm where the specimen does not give it, so that moduli come out times thickness."""
    return inputs.specimen.wall_thickness_mm or 1.0


def hoop_force(inputs: Inputs) -> Array:
    """Force in N per MPa of modulus of a bladder stretched around the hoop only, shape (n,), ≤ 0 in contraction."""
    s, shortened = inputs.specimen, 1.0 - inputs.contraction
    stretch = 1.0 - 1.0 / s.radius_ratio(inputs.contraction)
    return -2.0 * s.a / 3.0 * math.pi * s.initial_radius_mm * wall(inputs) * shortened * stretch


def _hoop(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(hoop_force(inputs))


def invariant_slopes(inputs: Inputs) -> tuple[Array, Array, Array]:
    """I1 − 3, dI1/dε and dI2/dε of an incompressible thin tube on the braid, λ_z = 1 − ε, λ_θ = r/r0.

    Values (n,) each, without unit.
    """
    z, g = 1.0 - inputs.contraction, inputs.specimen.radius_ratio(inputs.contraction) ** 2
    dg = 2.0 * inputs.specimen.a * z / 3.0
    product, d_product = z**2 * g, -2.0 * z * g + z**2 * dg
    i1 = z**2 + g + 1.0 / product - 3.0
    d1 = -2.0 * z + dg - d_product / product**2
    d2 = 2.0 / z**3 - dg / g**2 + d_product
    return i1, d1, d2


def _spring(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-inputs.contraction)


def _positive(inputs: Inputs, values: Values, force: Array) -> Array:
    """Bernstein's polynomials: sums of them are the smooth curves that resist from no contraction on."""
    share = inputs.contraction / 0.3
    return -inputs.xp.stack([bernstein(share, i, 4) for i in range(1, 5)]).T


def _mooney_rivlin(inputs: Inputs, values: Values, force: Array) -> Array:
    _, d1, d2 = invariant_slopes(inputs)
    section = 2.0 * math.pi * inputs.specimen.initial_radius_mm * wall(inputs)
    return -section * inputs.xp.stack([d1, d2]).T


def _gent(inputs: Inputs, values: Values, force: Array) -> Array:
    i1, d1, _ = invariant_slopes(inputs)
    section = 2.0 * math.pi * inputs.specimen.initial_radius_mm * wall(inputs)
    return one(-section * 0.5 * d1 / inputs.xp.maximum(1.0 - i1 / values["J_m"], 0.02))


def _yeoh(inputs: Inputs, values: Values, force: Array) -> Array:
    xp = inputs.xp
    i1, d1, _ = invariant_slopes(inputs)
    section = 2.0 * math.pi * inputs.specimen.initial_radius_mm * wall(inputs)
    return -section * d1[:, None] * xp.stack([xp.ones_like(i1), 2.0 * i1, 3.0 * i1**2]).T


EFFECT = Effect(
    name="bladder_elasticity",
    title="elasticity of the bladder",
    source="hoop energy by virtual work; Klute & Hannaford 2000, ASME J. Dyn. Syst. Meas. Control 122, 386–388 "
    "(Mooney–Rivlin); Gent 1996, Rubber Chemistry and Technology 69, 59–61; Yeoh 1993, ibid. 66, 754–771",
    forms=(
        AddsForce("textbook", "−(2a/3) π r0 t E (1−ε)(1 − r0/r)", (E_MOD,), _hoop),
        AddsForce("spring", "−K ε", (K,), _spring),
        AddsForce("mooney_rivlin", "−2π r0 t (C1 dI1/dε + C2 dI2/dε)", (C1, C2), _mooney_rivlin),
        AddsForce("gent", "−π r0 t G (dI1/dε)/(1 − (I1−3)/J_m)", (G,), _gent, (J_M,)),
        AddsForce("yeoh", "−2π r0 t (dI1/dε)(C10 + 2 C20 (I1−3) + 3 C30 (I1−3)²)", (C10, C20, C30), _yeoh),
        AddsForce("free", "−Σ K_i C(4, i) (ε/0.3)^i (1 − ε/0.3)^(4−i)", RESISTS, _positive),
    ),
    follows=("map",),
    test="a sweep at low pressure, down to none: the force that is left is the bladder's",
    levers=("pressure",),
)
