"""The ideal braid with conical ends and a bladder that resists being widened.

Each end is a truncated cone from the radius r0 of the fitting to the radius r of the cylinder, m (r − r0) long. The
muscle then holds (2π m/3)(r − r0)²(2r + r0) less than the whole cylinder, and the virtual work −p dV/dL of that loss is
what the ends cost, with r from the contraction of the whole muscle. The bladder's part is the virtual work of the hoop
energy of a thin tube.
"""

import math

from ..core import Param, Specimen
from .base import Array, Law, Values, braid_radius_ratio
from .chou_hannaford import ideal_force


def _columns(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    shortened = 1.0 - e
    ratio = braid_radius_ratio(specimen.a, specimen.b, shortened)
    radius, widening = specimen.initial_radius_mm, ratio - 1.0
    slope = -2.0 * math.pi / 3.0 * specimen.a * radius * shortened * widening
    ends = 2.0 * radius**2 / specimen.initial_length_mm * p * slope
    return p.__array_namespace__().stack([ends, slope / ratio]).T


LAW = Law(
    name="tsagarakis_caldwell",
    title="conical-ends law of Tsagarakis and Caldwell",
    formula=(
        "F = π r0² p [a(1−ε)² − b] − m (4π a r0²/(3 L0)) p (1−ε)(r − r0) − H (2π a/3)(1−ε) r0 (1 − r0/r),  "
        "r the radius of the ideal braid at ε"
    ),
    source=(
        "of the type of Tsagarakis & Caldwell 2000, Proc. IEEE Int. Conf. Robotics and Automation, 3641–3646: ends "
        "that are no cylinders and pressure lost to widen the bladder; the printed form could not be checked, this "
        "one follows from virtual work"
    ),
    linear=(
        Param("m", "1", "length of a conical end per growth of the radius", lower=0.0, upper=20.0),
        Param("H", "N/mm", "modulus times thickness of the bladder", lower=0.0, upper=200.0),
    ),
    fixed=ideal_force,
    columns=_columns,
)
