"""The muscle as a spring whose stiffness depends on pressure and on its own stretch."""

from ..core import Param, Specimen
from .base import Array, Law, Values


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    xp = p.__array_namespace__()
    stretch = specimen.initial_length_mm * (values["e_free"] - e)
    square = stretch * stretch
    return xp.stack([stretch, square * stretch, p * square, p * p * stretch]).T


LAW = Law(
    name="wickramatunge_leephakpreeda",
    title="spring law of Wickramatunge and Leephakpreeda",
    formula="F = K L_s,  K = c3 p² + c2 p L_s + c1 L_s² + c0,  L_s = L0 (e_free − ε)",
    source=(
        "Wickramatunge & Leephakpreeda 2010, Int. J. Engineering Science 48(2), 188–198; the length from which the "
        "stretch L_s is measured is a parameter here, the same for all pressures"
    ),
    linear=(
        Param("c0", "N/mm", "stiffness without pressure", scale=1.0),
        Param("c1", "N/mm^3", "stiffness per square of the stretch", scale=1e-3),
        Param("c2", "N/(MPa·mm^2)", "stiffness per pressure and stretch", scale=0.1),
        Param("c3", "N/(MPa^2·mm)", "stiffness per square of the pressure", scale=10.0),
    ),
    nonlinear=(
        Param(
            "e_free",
            "1",
            "contraction at which the force vanishes",
            0.05,
            1.0,
            start=0.3,
            scale=0.1,
            symbol="ε_free",
            grid=(0.2, 0.3, 0.45, 0.7),
        ),
    ),
    columns=_columns,
    min_levels=2,
)
