"""Pressure on an effective area, less the force of the membrane, which begins steeply."""

from ..core import Param, Specimen
from .base import Array, Law, Values


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    xp = p.__array_namespace__()
    square, root = e * e, xp.cbrt(e)
    # odd in ε, so that a stretched membrane pulls
    return xp.stack([p, p * e, p * square, -xp.ones_like(p), -e, -square, -root * xp.abs(root)]).T


LAW = Law(
    name="hildebrandt",
    title="area-and-spring law of Hildebrandt",
    formula="F = p (a0 + a1 ε + a2 ε²) − (b0 + b1 ε + b2 ε² + b3 ε^(2/3)),  ε^(2/3) with the sign of ε",
    source=(
        "of the type of Hildebrandt, Sawodny, Neumann & Hartmann 2005, Proc. American Control Conference, 680–685: "
        "effective area times pressure less a membrane spring with a power of 2/3; the degrees of the polynomials are "
        "ours, the printed ones could not be checked"
    ),
    linear=(
        Param("a0", "mm^2", "effective area at rest length", scale=1000.0),
        Param("a1", "mm^2", "effective area, linear in contraction", scale=1000.0),
        Param("a2", "mm^2", "effective area, quadratic in contraction", scale=1000.0),
        Param("b0", "N", "force of the membrane at rest length", scale=100.0),
        Param("b1", "N", "force of the membrane, linear in contraction", scale=1000.0),
        Param("b2", "N", "force of the membrane, quadratic in contraction", scale=1000.0),
        Param("b3", "N", "force of the membrane, steep at first", scale=1000.0),
    ),
    columns=_columns,
    min_levels=2,
)
