"""What the parameters' errors are when residuals are correlated along a stroke, or when they are not."""

from dataclasses import dataclass, replace

import numpy as np

from ..records import Record

Array = np.ndarray
LEVEL = 0.95
"""Level of all intervals."""
FLAT = 1e-8
"""Singular value, relative to the largest, below which a direction of scaled parameters is flat."""
FEWEST_CLUSTERS = 6
"""Below this many strokes there is nothing to learn correlation from."""


@dataclass(frozen=True)
class Covariance:
    """Covariance of k parameters in r identified directions, Σ = basis · middle · basisᵀ.

    `basis` (k, r) carries unit vectors of the orthonormalised Jacobian into parameters, `middle` (r, r) is the
    covariance there. `shares` and `spreads` (clusters, r, r) are each cluster's part K of the identity and
    (1 − K)^(−1/2); both empty where the noise is taken as white. `clusters` says how many there are, `white` the
    degrees of freedom n − r. `sizes` (k,) are the norms of the Jacobian's columns. Flat directions are left out.
    """

    basis: Array
    middle: Array
    shares: Array
    spreads: Array
    white: int
    sizes: Array

    @property
    def clusters(self) -> int:
        """How many clusters of correlated rows were allowed for; 0 where the noise is taken as white."""
        return len(self.shares)

    @property
    def matrix(self) -> Array:
        """Covariance of the parameters, shape (k, k), zero along flat directions."""
        return self.basis @ self.middle @ self.basis.T

    def error(self, contrasts: Array) -> tuple[Array, Array]:
        """Standard error of contrasts · parameters and its degrees of freedom, (m, k) → (m,) and (m,).

        Satterthwaite's degrees of freedom under white noise of the estimator below (Bell & McCaffrey 2002, Survey
        Methodology 28, 169–181), so that a parameter on which few strokes bear gets a wide interval.
        """
        c = contrasts @ self.basis
        stderr = np.sqrt(np.maximum(np.einsum("mr,rs,ms->m", c, self.middle, c), 0.0))
        if not self.clusters:
            return stderr, np.full(len(c), float(max(self.white, 1)))
        held = np.einsum("grs,ms->mgr", self.spreads, c)
        seen = np.einsum("grs,mgs->mgr", self.shares, held)
        own = np.einsum("mgr,mgr->mg", held, seen)
        trace = own.sum(axis=1) - np.sum(seen**2, axis=(1, 2))
        cross = np.einsum("mgr,mgs->mrs", seen, seen)
        square = (
            np.sum(own**2, axis=1) - 2.0 * np.sum(own * np.sum(seen**2, axis=2), axis=1) + np.sum(cross**2, axis=(1, 2))
        )
        return stderr, np.maximum(np.divide(trace**2, square, out=np.ones(len(c)), where=square > 0), 1.0)


def student(dof: Array) -> Array:
    """Half the width of an interval at LEVEL in standard errors, by degrees of freedom (any shape)."""
    from scipy.special import stdtrit

    return stdtrit(dof, 0.5 + 0.5 * LEVEL)


def clusters(record: Record, rows: Array | slice) -> Array | None:
    """Numbers the runs of `rows` along which residuals may be correlated, shape (rows,); None in a static table.

    On one branch a run is a stroke of a cycle. On both it goes from the middle of a stroke to the middle of the
    next one, because what a law gets wrong, and much of what it must learn, sits at the reversals.
    """
    if record.inputs.time is None:
        return None
    direction = record.inputs.direction[rows]
    both = bool(np.any(direction > 0) and np.any(direction < 0))
    return (record.turn if both else record.stroke)[rows]


@dataclass(frozen=True)
class Sums:
    """What n rows of a Jacobian J (n, k) and a residual say of the parameters, cluster by cluster.

    `triangle` (k, k) with triangleᵀ · triangle = JᵀJ, `squares` of the residual; of each cluster the Gram matrix of its
    rows, `grams` (clusters, k, k), and their product with the residual, `scores` (clusters, k), both empty where the
    noise is taken as white.
    """

    n: int
    triangle: Array
    squares: float
    grams: Array
    scores: Array

    def take(self, columns: list[int]) -> "Sums":
        """Of some of the parameters only."""
        grams = self.grams[:, columns][:, :, columns]
        return Sums(self.n, self.triangle[:, columns], self.squares, grams, self.scores[:, columns])


def sums(jacobian: Array, residual: Array, cluster: Array | None = None) -> Sums:
    """Sums of a Jacobian (n, k) and residual (n,), both as they were minimised, by `cluster` (n,) if given."""
    n, k = jacobian.shape
    sizes = _sizes(jacobian)
    triangle: Array = np.linalg.qr(jacobian / sizes, mode="r") * sizes  # pyright: ignore
    empty = Sums(n, triangle, float(residual @ residual), np.empty((0, k, k)), np.empty((0, k)))
    if cluster is None or not n:
        return empty
    groups = np.unique(cluster, return_inverse=True)[1]
    order = np.argsort(groups, kind="stable")
    edges = np.searchsorted(groups[order], np.arange(groups.max() + 1))
    parts = np.split(jacobian[order], edges[1:])
    scores = np.add.reduceat((jacobian * residual[:, None])[order], edges, axis=0)
    return replace(empty, grams=np.array([part.T @ part for part in parts]), scores=scores)


def covariance(jacobian: Array, residual: Array, cluster: Array | None = None) -> Covariance:
    """Covariance of least-squares estimates from Jacobian (n, k) and residual (n,), both as they were minimised.

    `cluster` (n,) numbers runs of rows within which residuals may be correlated in any way; with at least six of
    them the bias-reduced cluster-robust estimator CR2 is used (Bell & McCaffrey 2002), else noise is white.
    """
    return covariance_of(sums(jacobian, residual, cluster))


def covariance_of(one: Sums) -> Covariance:
    """Covariance of least-squares estimates from sums, as `covariance`."""
    sizes = _sizes(one.triangle)
    _, sigma, vt = np.linalg.svd(one.triangle / sizes, full_matrices=False)
    kept = sigma > FLAT * np.max(sigma, initial=1e-300)
    basis = (vt[kept].T / sigma[kept]) / sizes[:, None]
    r = basis.shape[1]
    free = max(one.n - r, 1)
    if len(one.grams) < FEWEST_CLUSTERS or r == 0:
        empty = np.empty((0, r, r))
        return Covariance(basis, one.squares / free * np.eye(r), empty, empty, free, sizes)
    shares = basis.T @ one.grams @ basis
    weight, axes = np.linalg.eigh(shares)
    # A direction that one cluster alone carries has no scatter between clusters; CR2 leaves it out.
    stretch = np.where(weight < 1.0 - 1e-9, 1.0 / np.sqrt(np.maximum(1.0 - weight, 1e-12)), 0.0)
    spreads = np.einsum("gri,gi,gsi->grs", axes, stretch, axes)
    pulled = np.einsum("grs,gs->gr", spreads, one.scores @ basis)
    return Covariance(basis, pulled.T @ pulled, shares, spreads, free, sizes)


def _sizes(columns: Array) -> Array:
    """Norms of columns, 1 where there is nothing."""
    found = np.linalg.norm(columns, axis=0)
    return np.where(found < 1e-300, 1.0, found)
