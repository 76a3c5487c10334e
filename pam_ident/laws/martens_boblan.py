"""Pressure on a braid, and rubber that is stretched around the hoop and shortened along the axis.

The wall keeps its volume, so that the pressure works on the cylinder of the braid whatever the wall's thickness. The
rubber's force around the hoop is the virtual work of a thin tube's hoop energy; along the axis it is a stress-strain
curve of second degree that begins with a preload. Angle and cross-section of the braid are parameters here, not the
specimen's, and the rubber's parameters may have either sign: together they describe a curve, not a material.
"""

from ..core import Param, Specimen
from .base import Array, Law, Values, braid_radius_ratio


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    xp = p.__array_namespace__()
    angle = xp.radians(values["theta"])
    a, b = 3.0 / xp.tan(angle) ** 2, 1.0 / xp.sin(angle) ** 2
    shortened = 1.0 - e
    hoop = a * shortened * (1.0 / braid_radius_ratio(a, b, shortened) - 1.0)
    return xp.stack([p * (a * shortened**2 - b), hoop, -xp.ones_like(p), -e, -e * e]).T


LAW = Law(
    name="martens_boblan",
    title="rubber law of Martens and Boblan",
    formula="F = A p [a(1−ε)² − b] − H a (1−ε)(1 − r0/r) − (X0 + X1 ε + X2 ε²),  a = 3/tan²θ,  b = 1/sin²θ",
    source=(
        "of the type of Martens & Boblan 2017, Actuators 6(4), 33: pressure on the braid less the rubber's forces "
        "along the axis and around the hoop; the printed form could not be checked, and its erratum (Actuators 2018, "
        "7(1), 9) was not seen"
    ),
    linear=(
        Param("A", "mm^2", "cross-section of the braid at rest, π r0²", start=300.0, lower=0.0, scale=100.0),
        Param("H", "N", "hoop stiffness of the rubber, (2π/3) r0 t E", scale=100.0),
        Param("X0", "N", "axial force of the rubber at rest length", scale=100.0),
        Param("X1", "N", "axial force of the rubber, linear in contraction", scale=1000.0),
        Param("X2", "N", "axial force of the rubber, quadratic in contraction", scale=1000.0),
    ),
    nonlinear=(
        Param(
            "theta",
            "deg",
            "braid angle at rest",
            15.0,
            40.0,
            start=25.0,
            symbol="θ",
            grid=(18.0, 24.0, 30.0, 36.0),
        ),
    ),
    columns=_columns,
    min_levels=2,
)
