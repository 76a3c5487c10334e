"""Intercept and slope of the force over pressure, each a polynomial in contraction."""

from ..core import Param, Specimen
from .base import Array, Law, Values


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    xp = p.__array_namespace__()
    square = e * e
    return xp.stack([p, p * e, p * square, xp.ones_like(p), e, square, square * e]).T


LAW = Law(
    name="polynomial",
    title="polynomial law over pressure",
    formula="F = p (a0 + a1 ε + a2 ε²) + b0 + b1 ε + b2 ε² + b3 ε³",
    source=(
        "of the type used by Aschemann & Schindele 2008, IEEE Trans. Industrial Electronics 55(11), 3855–3864 (slope "
        "and intercept polynomials over the contraction); the degrees here are ours: 2, as in the ideal braid, and 3"
    ),
    linear=(
        Param("a0", "N/MPa", "slope over pressure at rest length", scale=1000.0),
        Param("a1", "N/MPa", "slope over pressure, linear in contraction", scale=1000.0),
        Param("a2", "N/MPa", "slope over pressure, quadratic in contraction", scale=1000.0),
        Param("b0", "N", "force without pressure at rest length", scale=100.0),
        Param("b1", "N", "force without pressure, linear in contraction", scale=1000.0),
        Param("b2", "N", "force without pressure, quadratic in contraction", scale=1000.0),
        Param("b3", "N", "force without pressure, cubic in contraction", scale=10000.0),
    ),
    columns=_columns,
    min_levels=2,
)
