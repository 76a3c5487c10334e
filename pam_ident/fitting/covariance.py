"""What the parameters' errors are when residuals are correlated along a stroke, or when they are not."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core import Array
from ..records import Record

LEVEL = 0.95
"""Level of all intervals."""
FLAT = 1e-8
"""Singular value, relative to the largest, below which a direction of scaled parameters is flat."""
GRAM = 1e-9
"""Eigenvalue of a Gram matrix of scaled columns, relative to the largest, down to which it says as much as they do."""
BLOCK = 256
"""Rows of a table that are brought to a triangle at a time."""
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

    def of(self, rows: list[int]) -> "Covariance":
        """That of some of the parameters."""
        return replace(self, basis=self.basis[rows], sizes=self.sizes[rows])

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
        square = np.sum(own**2, axis=1) - 2.0 * np.sum(own * np.sum(seen**2, axis=2), axis=1)
        square += np.sum(cross**2, axis=(1, 2))
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
    """What n rows of a Jacobian (n, k) say of the parameters, with the residual as one more column, cluster by cluster.

    `triangle` (·, k + 1), with triangleᵀ · triangle their Gram matrix; of each cluster the Gram matrix of its rows,
    `tables` (clusters, k + 1, k + 1), and its number in `runs` (clusters,), one or none where the noise
    is taken as white.
    """

    n: int
    triangle: Array
    tables: Array
    runs: Array

    @property
    def squares(self) -> float:
        """Sum of squares of the residual."""
        return float(np.sum(self.triangle[:, -1] ** 2))

    def take(self, columns: list[int]) -> "Sums":
        """Of some of the parameters only."""
        kept = [*columns, -1]
        return replace(self, triangle=self.triangle[:, kept], tables=self.tables[:, kept][:, :, kept])

    def after(self, step: Array) -> "Sums":
        """Where a step (k,) of the parameters has led, to first order."""
        shift = np.eye(len(step) + 1)
        shift[:-1, -1] = step
        return replace(self, triangle=self.triangle @ shift, tables=shift.T @ self.tables @ shift)


def sums(table: Array, cluster: Array | None = None) -> Sums:
    """Sums of a Jacobian and residual side by side, (n, k + 1), as they are minimised, by `cluster` (n,) if given."""
    none = np.empty((0, table.shape[1], table.shape[1])), np.empty(0, int)
    return Sums(len(table), _triangle(table), *(none if cluster is None else grams(table, cluster)))


def grams(table: Array, cluster: Array | None) -> tuple[Array, Array]:
    """Gram matrices (clusters, k, k) of the rows of each cluster of a table (n, k), and their numbers (clusters,)."""
    if cluster is None:
        return (table.T @ table)[None], np.zeros(1, int)
    edges = np.flatnonzero(cluster[1:] != cluster[:-1]) + 1
    runs = cluster[np.r_[0, edges]]
    if np.any(np.diff(runs) <= 0):
        order = np.argsort(cluster, kind="stable")
        return grams(table[order], cluster[order])
    return np.array([part.T @ part for part in np.split(table, edges)]), runs


def joined(n: int, parts: Sequence[tuple[Array, Array]], triangles: Sequence[Array]) -> Sums | None:
    """Sums of n rows from the `grams` of some rows each, in the order of their clusters, which may go on from part to
    part.

    With the `triangles` of the parts, shape (k, k) each (Demmel et al. 2012, SIAM J. Sci. Comput. 34, A206–A239) no
    digit is lost; without them half of the digits are, and None is returned where that is too many.
    """
    tables, runs = (np.concatenate(both) for both in zip(*parts, strict=True))
    begins = np.flatnonzero(np.diff(runs, prepend=np.nan) != 0)
    tables, runs = np.add.reduceat(tables, begins), runs[begins]
    if triangles:
        return Sums(n, _triangle(np.concatenate(triangles)), tables, runs)
    whole = tables.sum(axis=0)
    scale = np.sqrt(np.diag(whole))
    if not (np.all(np.isfinite(whole)) and np.all(scale > 0.0)):
        return None
    weight, axes = np.linalg.eigh(whole / np.outer(scale, scale))
    return Sums(n, np.sqrt(weight)[:, None] * axes.T * scale, tables, runs) if weight[0] > GRAM * weight[-1] else None


def covariance(jacobian: Array, residual: Array, cluster: Array | None = None) -> Covariance:
    """Covariance of least-squares estimates from Jacobian (n, k) and residual (n,), both as they were minimised.

    `cluster` (n,) numbers runs of rows within which residuals may be correlated in any way; with at least six of
    them the bias-reduced cluster-robust estimator CR2 is used (Bell & McCaffrey 2002), else noise is white.
    """
    return covariance_of(sums(np.column_stack([jacobian, residual]), cluster))


def covariance_of(one: Sums) -> Covariance:
    """Covariance of least-squares estimates from sums, as `covariance`."""
    slopes = one.triangle[:, :-1]
    sizes = np.linalg.norm(slopes, axis=0)
    sizes[sizes < 1e-300] = 1.0
    _, sigma, vt = np.linalg.svd(slopes / sizes, full_matrices=False)
    kept = sigma > FLAT * np.max(sigma, initial=1e-300)
    basis = (vt[kept].T / sigma[kept]) / sizes[:, None]
    r = basis.shape[1]
    free = max(one.n - r, 1)
    if len(one.tables) < FEWEST_CLUSTERS or r == 0:
        empty = np.empty((0, r, r))
        return Covariance(basis, one.squares / free * np.eye(r), empty, empty, free, sizes)
    shares = basis.T @ one.tables[:, :-1, :-1] @ basis
    weight, axes = np.linalg.eigh(shares)
    # A direction that one cluster alone carries has no scatter between clusters; CR2 leaves it out.
    stretch = np.where(weight < 1.0 - 1e-9, 1.0 / np.sqrt(np.maximum(1.0 - weight, 1e-12)), 0.0)
    spreads = np.einsum("gri,gi,gsi->grs", axes, stretch, axes)
    pulled = np.einsum("grs,gs->gr", spreads, one.tables[:, :-1, -1] @ basis)
    return Covariance(basis, pulled.T @ pulled, shares, spreads, free, sizes)


def _triangle(table: Array) -> Array:
    """R of the QR decomposition of a table (n, k), of a long one by way of blocks that stay in the cache."""
    if len(table) > 8 * BLOCK:
        blocks, rest = np.split(table, [len(table) // BLOCK * BLOCK])
        parts: Array = np.linalg.qr(blocks.reshape(-1, BLOCK, table.shape[1]), mode="r")  # pyright: ignore
        table = np.concatenate([parts.reshape(-1, table.shape[1]), rest])
    return np.linalg.qr(table, mode="r")  # pyright: ignore
