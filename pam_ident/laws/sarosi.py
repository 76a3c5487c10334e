"""Sárosi's six-parameter law."""

from ..core import Param, Specimen
from .base import PEAK, PEAK_PER_MPA, Array, Law, Values


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    xp = p.__array_namespace__()
    decay = xp.exp(values["s3"] * e)
    return xp.stack([decay * p, decay, e * p, p, xp.ones_like(p)]).T


LAW = Law(
    name="sarosi",
    title="six-parameter law of Sárosi",
    formula="F = (s1 p + s2) exp(s3 ε) + s4 ε p + s5 p + s6",
    source=(
        "Sárosi et al., force model of Fluidic Muscles (parameters there for p in bar and ε in %: "
        "s1 and s5 are 10 times, s4 1000 times and s3 100 times the printed figures)"
    ),
    linear=(
        Param("s1", "N/MPa", "initial peak per pressure", scale=100.0, range=PEAK_PER_MPA),
        Param("s2", "N", "initial peak", scale=100.0, range=PEAK),
        Param("s4", "N/MPa", "slope over contraction, per pressure", scale=1000.0),
        Param("s5", "N/MPa", "blocked force per pressure", scale=1000.0),
        Param("s6", "N", "offset", scale=100.0),
    ),
    nonlinear=(
        Param(
            "s3",
            "1",
            "decay of the initial peak over contraction",
            -400.0,
            -1.0,
            start=-33.0,
            grid=(-12.0, -33.0, -100.0),
        ),
    ),
    columns=_columns,
    min_levels=2,
)
