"""The empirical law of the paper: a line and a decaying exponential in contraction, each linear in pressure."""

from ..core import Param, Specimen
from .base import PEAK, PEAK_PER_MPA, Array, Law, Values


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    xp = p.__array_namespace__()
    decay = xp.exp(-values["mu"] * e)
    return xp.stack([xp.ones_like(p), p, -e, -e * p, decay, decay * p]).T


LAW = Law(
    name="exponential_law",
    title="exponential law",
    formula="F = (a0 + a1 p) − (b0 + b1 p) ε + (c0 + c1 p) exp(−μ ε)",
    source="equations (3) to (5) of the heterogeneous-leg paper; μ = 45 there",
    linear=(
        Param("a0", "N", "intercept", scale=100.0),
        Param("a1", "N/MPa", "intercept per pressure", scale=1000.0),
        Param("b0", "N", "slope over contraction", scale=1000.0),
        Param("b1", "N/MPa", "slope per pressure", scale=1000.0),
        Param("c0", "N", "initial peak", scale=100.0, range=PEAK),
        Param("c1", "N/MPa", "initial peak per pressure", scale=100.0, range=PEAK_PER_MPA),
    ),
    nonlinear=(
        Param(
            "mu",
            "1",
            "decay of the initial peak over contraction",
            1.0,
            400.0,
            start=45.0,
            symbol="μ",
            grid=(15.0, 45.0, 120.0),
        ),
    ),
    columns=_columns,
    min_levels=2,
)
