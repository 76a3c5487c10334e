"""The ideal braid: a thin cylinder, no friction, no wall."""

from ..core import Specimen
from .base import Array, Law, Values


def ideal_force(p: Array, e: Array, specimen: Specimen, values: Values) -> Array:
    """π r0² p [a(1−ε)² − b] in N, shape (n,)."""
    return specimen.ideal_force(p, e)


LAW = Law(
    name="chou_hannaford",
    title="ideal law of Chou and Hannaford",
    formula="F = π r0² p [a(1−ε)² − b],  a = 3/tan²θ0,  b = 1/sin²θ0",
    source="Chou & Hannaford 1996, IEEE Trans. Robotics and Automation 12(1), 90–102",
    fixed=ideal_force,
)
