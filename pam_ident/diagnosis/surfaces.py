"""Smooth surfaces over each driver, and how much any set of them explains."""

from collections.abc import Callable, Collection

import numpy as np
from scipy.linalg import get_lapack_funcs, solve_triangular

from ..core import Inputs
from .drivers import DRIVERS, polynomials

Array = np.ndarray
(POSITIVE_SOLVE,) = get_lapack_funcs(("posv",), dtype=np.float64)
"""Solves with a positive definite matrix, at a third of the time of numpy's general one."""
SEEN, RIDGE = 1e-4, 1e-6
"""Share of a column that the model must leave for it to count, and what keeps dependent ones solvable."""


class Surfaces:
    """Gain in squares of sets of groups of columns, free of what the model can follow.

    A group is a driver at one degree of detail: some of its states, times polynomials up to some orders.
    """

    def __init__(
        self, inputs: Inputs, law: Array, left: Array, even: Callable[[Array], Array], without: Collection[str] = ()
    ) -> None:
        parts: list[Array] = []
        self.names: list[str] = []
        self.columns: list[Array] = []
        begin = 0
        for driver in DRIVERS:
            states = driver.states(inputs)
            if states is None or driver.what in without:
                continue
            over_p, over_e = (
                polynomials(values, max(order[k] for order in driver.orders))
                for k, values in enumerate((inputs.pressure, inputs.contraction))
            )
            product = states[:, :, None, None] * over_p[:, None, :, None] * over_e[:, None, None, :]
            place = begin + np.arange(product[0].size).reshape(product.shape[1:])
            for which in (some for some in driver.some if max(some) < states.shape[1]):
                for p, e in driver.orders:
                    self.columns.append(place[list(which), : p + 1, : e + 1].ravel())
                    self.names.append(driver.what)
            parts.append(even(product.reshape(len(left), -1)))
            begin += place.size
        matrix = np.hstack([np.empty((len(left), 0)), *parts])
        before = np.linalg.norm(matrix, axis=0)
        matrix = matrix - law @ (law.T @ matrix)
        size = np.linalg.norm(matrix, axis=0)
        seen = size > SEEN * before
        self.matrix = np.where(seen, matrix / np.where(seen, size, 1.0), 0.0)
        self.gram, self.product = self.matrix.T @ self.matrix, self.matrix.T @ left
        self.columns = [which[seen[which]] for which in self.columns]
        self.known: dict[frozenset[int], tuple[float, int]] = {}
        self.added: dict[frozenset[int], Array] = {}

    def richest(self, rows: int) -> frozenset[int]:
        """The richest group of each driver; of few rows, one that leaves half of them to the noise."""
        groups: dict[str, list[int]] = {}
        for k, name in enumerate(self.names):
            groups.setdefault(name, []).append(k)
        while True:
            found = frozenset(each[-1] for each in groups.values())
            poorer = {name: each[:-1] or each for name, each in groups.items()}
            if 2.0 * self.of(found)[1] <= rows or poorer == groups:
                return found
            groups = poorer

    def of(self, groups: frozenset[int]) -> tuple[float, int]:
        """Gain of a set of groups, and the degrees of freedom that it takes."""
        if groups not in self.known:
            which = self._which(groups)
            self.known[groups] = float(self.product[which] @ self._sizes(which)), len(which)
        return self.known[groups]

    def beyond(self, groups: frozenset[int]) -> Array:
        """What each group gains beyond a set of others, shape (groups,)."""
        if groups not in self.added:
            gram, product = self.gram, self.product
            which = self._which(groups)
            if len(which):
                root = np.linalg.cholesky(gram[np.ix_(which, which)] + RIDGE * np.eye(len(which)))
                seen = solve_triangular(root, np.column_stack([gram[which], product[which]]), lower=True)
                gram, product = gram - seen[:, :-1].T @ seen[:, :-1], product - seen[:, :-1].T @ seen[:, -1]
            self.added[groups] = np.array([product[own] @ _solved(gram, product, own) for own in self.columns])
        return self.added[groups]

    def explained(self, groups: frozenset[int]) -> Array:
        """What a set of groups explains of what is left, (n,)."""
        which = self._which(groups)
        return self.matrix[:, which] @ self._sizes(which)

    def without(self, groups: frozenset[int], values: Array) -> Array:
        """Values (n,) less what a set of groups explains of them."""
        which = self._which(groups)
        return values - self.matrix[:, which] @ _solved(self.gram, self.matrix.T @ values, which)

    def _which(self, groups: frozenset[int]) -> Array:
        return np.concatenate([np.empty(0, int), *(self.columns[k] for k in sorted(groups))])

    def _sizes(self, which: Array) -> Array:
        return _solved(self.gram, self.product, which)


def _solved(gram: Array, product: Array, which: Array) -> Array:
    """Sizes of some columns by their Gram matrix, with a ridge."""
    if not len(which):
        return np.empty(0)
    own = gram[which[:, None], which]
    own.flat[:: len(which) + 1] += RIDGE
    return POSITIVE_SOLVE(own, product[which])[1]
