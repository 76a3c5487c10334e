"""The ideal braid with the three corrections of the paper, shared by all pressures."""

from ..core import Param, Specimen
from .base import Array, Law, Values
from .chou_hannaford import ideal_force


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    xp = p.__array_namespace__()
    return xp.stack([ideal_force(p, values["k1"] * e, specimen, values), xp.ones_like(p)]).T


LAW = Law(
    name="modified_chou_hannaford",
    title="modified Chou–Hannaford law",
    formula="F = k0 π r0² p [a(1 − k1 ε)² − b] + k2",
    source="equation (1) of the heterogeneous-leg paper without F_t, which is the effect bladder_elasticity",
    linear=(
        Param("k0", "1", "what geometry and pressure scale leave over", start=1.0, lower=0.0, upper=10.0),
        Param("k2", "N", "static friction or offset of the force", start=0.0, scale=100.0),
    ),
    nonlinear=(
        Param(
            "k1",
            "1",
            "effective contraction of non-cylindrical ends",
            0.2,
            20.0,
            start=1.2,
            grid=(1.2, 3.0, 7.0),
        ),
    ),
    columns=_columns,
)
