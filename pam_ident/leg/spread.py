"""How uncertain the parameters of a fitted model are, and draws from that."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core import Param
from ..model import Values

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class ParameterSpread:
    """Covariance of some parameters, `matrix` (k, k) in the order of `names`; the others are taken as known."""

    names: tuple[str, ...]
    matrix: Array

    def given(self, held: Sequence[str]) -> "ParameterSpread":
        """What is left where some of the parameters are known: a conditional normal distribution."""
        known = np.array([name in held for name in self.names])
        free, cross = self.matrix[np.ix_(~known, ~known)], self.matrix[np.ix_(~known, known)]
        left = free - cross @ np.linalg.pinv(self.matrix[np.ix_(known, known)]) @ cross.T
        return ParameterSpread(tuple(name for name in self.names if name not in held), left)

    def draws(self, values: Values, params: Sequence[Param], normal: Array) -> dict[str, Array]:
        """Parameter sets by name, (draws,) each, kept within the bounds; `normal` (draws, k) are standard normal."""
        size, axes = np.linalg.eigh(self.matrix)
        moved = normal @ (axes * np.sqrt(np.maximum(size, 0.0))).T
        found = {p.name: np.full(len(normal), float(values[p.name])) for p in params}
        bounds = {p.name: (p.lower, p.upper) for p in params}
        for k, name in enumerate(self.names):
            found[name] = np.clip(found[name] + moved[:, k], *bounds[name])
        return found
