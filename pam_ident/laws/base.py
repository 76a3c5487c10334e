"""What a static force law is."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..core import Param, Specimen

Array = np.ndarray
Shape = Mapping[str, float]


def no_columns(pressure: Array, contraction: Array, specimen: Specimen, shape: Shape) -> Array:
    """A law without linear parameters, shape (n, 0)."""
    return np.empty((len(pressure), 0))


def no_force(pressure: Array, contraction: Array, specimen: Specimen, shape: Shape) -> Array:
    """A law without a fixed part, shape (n,)."""
    return np.zeros(len(pressure))


@dataclass(frozen=True)
class Law:
    """F(p, ε) = fixed + columns · linear: linear in `linear`, curved in `shape` alone.

    `columns(pressure, contraction, specimen, shape)` has shape (n, len(linear)), `fixed` shape (n,), both
    in N per unit of the parameter, for p in MPa (gauge) and contraction ratio ε. `min_levels` is the number
    of isobars without which the parameters cannot be told apart.
    """

    name: str
    title: str
    formula: str
    source: str
    linear: tuple[Param, ...] = ()
    shape: tuple[Param, ...] = ()
    columns: Callable[[Array, Array, Specimen, Shape], Array] = no_columns
    fixed: Callable[[Array, Array, Specimen, Shape], Array] = no_force
    min_levels: int = 1

    @property
    def params(self) -> tuple[Param, ...]:
        """Linear parameters, then shapes."""
        return self.linear + self.shape

    def force(self, pressure: Array, contraction: Array, specimen: Specimen, values: Shape) -> Array:
        """Force in N, shape (n,), for parameter values by name."""
        columns = self.columns(pressure, contraction, specimen, values)
        sizes = np.array([values[p.name] for p in self.linear])
        return self.fixed(pressure, contraction, specimen, values) + columns @ sizes
