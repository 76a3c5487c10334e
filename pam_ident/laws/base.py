"""What a static force law is."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..core import Param, Range, Specimen
from ..core.shown import Shown

Array = np.ndarray
Values = Mapping[str, float]
PULL = "ten times the pull of Festo's largest muscle, DMSP-40, 6 kN at 0.6 MPa"
PEAK, PEAK_PER_MPA = Range(-60_000.0, 60_000.0, PULL, 6000.0), Range(-100_000.0, 100_000.0, PULL, 6000.0)
"""An exponential in contraction at rest length, N and N/MPa: a slow one, that makes a parabola, needs several times
the pull of the muscle; a fast one that is told by readings away from rest goes up without end."""


def no_columns(pressure: Array, contraction: Array, specimen: Specimen, values: Values) -> Array:
    """A law without linear parameters, shape (n, 0)."""
    return pressure[:, None][:, :0]


def no_force(pressure: Array, contraction: Array, specimen: Specimen, values: Values) -> Array:
    """A law without a fixed part, shape (n,)."""
    return pressure.__array_namespace__().zeros(len(pressure))


def braid_radius_ratio(a: float, b: float, shortened: Array) -> Array:
    """r / r0 of the ideal braid with a = 3/tan²θ0 and b = 1/sin²θ0 at L/L0 = `shortened`, any shape.

    From cosθ = (L/L0) cosθ0 (Chou & Hannaford 1996); held at a tenth where the threads lie along the axis.
    """
    xp = shortened.__array_namespace__()
    return xp.sqrt(xp.maximum(b - a / 3.0 * shortened**2, 0.01))


@dataclass(frozen=True, repr=False)
class Law(Shown):
    """F(p, ε) = fixed + columns · linear: linear in `linear`, not in `nonlinear`.

    `columns(pressure, contraction, specimen, values)` has shape (n, len(linear)), `fixed` shape (n,), both
    in N per unit of the parameter, for p in MPa (gauge) and contraction ratio ε. Both take their functions from
    the arrays they are given and change none in place, so that JAX can trace them, values included; the
    specimen stays plain numbers. Columns are stacked as rows and turned, because whole columns in memory make a
    fit faster. `min_levels` is the number of isobars without which the parameters cannot be
    told apart.
    """

    name: str
    title: str
    formula: str
    source: str
    linear: tuple[Param, ...] = ()
    nonlinear: tuple[Param, ...] = ()
    columns: Callable[[Array, Array, Specimen, Values], Array] = no_columns
    fixed: Callable[[Array, Array, Specimen, Values], Array] = no_force
    min_levels: int = 1

    def __repr__(self) -> str:
        names = ", ".join(p.name for p in self.params) or "none"
        return f"{self.name}: {self.title}\n  {self.formula}\n  parameters: {names}\n  source: {self.source}"

    @property
    def params(self) -> tuple[Param, ...]:
        """Linear, then nonlinear."""
        return self.linear + self.nonlinear

    @property
    def pinned(self) -> dict[str, float]:
        """The parameters that `at_one` has pinned, and the 0 at which they are."""
        return {p.name: 0.0 for p in self.linear if p.lower == p.upper == 0.0}

    def at_one(self, pressure: float, contraction: Array, specimen: Specimen) -> "Law":
        """The law with those parameters pinned at 0 whose part others can take at one `pressure` in MPa, by their
        columns over `contraction` (n,): of such the last stays free, with which the force grows with the pressure."""
        values = {p.name: p.start for p in self.nonlinear}
        columns = self.columns(np.full(len(contraction), pressure), contraction, specimen, values)
        size = np.linalg.norm(columns, axis=0)
        columns = columns / np.where(size > 0.0, size, 1.0)
        kept: list[int] = []
        for k in reversed(range(len(self.linear))):
            kept = [k, *kept] if np.linalg.matrix_rank(columns[:, [k, *kept]]) > len(kept) else kept
        gone = {"lower": 0.0, "upper": 0.0, "start": 0.0, "range": None}
        told = tuple(p if k in kept else replace(p, **gone) for k, p in enumerate(self.linear))
        return replace(self, linear=told, min_levels=1)

    def force(self, pressure: Array, contraction: Array, specimen: Specimen, values: Values) -> Array:
        """Force in N, shape (n,), for parameter values by name."""
        columns = self.columns(pressure, contraction, specimen, values)
        linear = pressure.__array_namespace__().asarray([values[p.name] for p in self.linear], dtype=pressure.dtype)
        return self.fixed(pressure, contraction, specimen, values) + columns @ linear
