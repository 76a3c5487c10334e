"""What the parameters' errors are when residuals are correlated along a stroke, or when they are not."""

from dataclasses import dataclass

import numpy as np

Array = np.ndarray
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


def covariance(jacobian: Array, residual: Array, cluster: Array | None = None) -> Covariance:
    """Covariance of least-squares estimates from Jacobian (n, k) and residual (n,), both as they were minimised.

    `cluster` (n,) numbers runs of rows within which residuals may be correlated in any way; with at least six of
    them the bias-reduced cluster-robust estimator CR2 is used (Bell & McCaffrey 2002), else noise is white.
    """
    n, k = jacobian.shape
    sizes = np.linalg.norm(jacobian, axis=0)
    dead = sizes < 1e-300
    scaled = np.where(dead, 1.0, sizes)
    triangle = np.linalg.qr(jacobian / scaled, mode="r") if n else np.zeros((0, k))
    _, sigma, vt = np.linalg.svd(triangle, full_matrices=True)
    sigma = np.r_[sigma, np.zeros(k - len(sigma))]
    kept = sigma > 1e-8 * max(float(sigma[0]) if k else 0.0, 1e-300)
    basis = (vt[kept].T / sigma[kept]) / scaled[:, None]
    r = basis.shape[1]
    free = max(n - r, 1)
    groups = np.unique(cluster, return_inverse=True)[1] if cluster is not None else np.zeros(n, int)
    count = int(groups.max()) + 1 if n else 0
    empty = np.empty((0, r, r))
    if count < FEWEST_CLUSTERS or r == 0:
        variance = float(residual @ residual) / free
        return Covariance(basis, variance * np.eye(r), empty, empty, free, sizes)
    directions = jacobian @ basis
    order = np.argsort(groups, kind="stable")
    edges = np.searchsorted(groups[order], np.arange(count))
    scores = np.add.reduceat((directions * residual[:, None])[order], edges, axis=0)
    shares = np.array([part.T @ part for part in np.split(directions[order], edges[1:])])
    weight, axes = np.linalg.eigh(shares)
    stretch = np.where(weight < 1.0 - 1e-9, 1.0 / np.sqrt(np.maximum(1.0 - weight, 1e-12)), 0.0)
    spreads = np.einsum("gri,gi,gsi->grs", axes, stretch, axes)
    pulled = np.einsum("grs,gs->gr", spreads, scores)
    return Covariance(basis, pulled.T @ pulled, shares, spreads, free, sizes)
