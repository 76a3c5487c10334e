"""Which set of effects explains the residual best, on compressed data.

All signatures are whitened and freed of what the law itself can follow; then every set costs only a small
linear solve in their Gram matrix.
"""

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from ..model import Term
from .dictionary import Atom
from .noise import Noise

Array = np.ndarray


FLAT = 1e-9
"""Singular value, relative to the largest, below which columns of unit norm count as dependent."""
NEARLY = 1e-10
"""Share of a column's square that hides what rounding does to columns that nearly depend on others."""
SPECIAL = -1.0
"""What a special case costs beyond the effect that it is a case of: where it is needed, it has the nearer name."""


@dataclass(frozen=True)
class Choice:
    """A set of atoms, its gain (fall of the whitened sum of squares) and cost (what is minimised)."""

    atoms: tuple[int, ...]
    gain: float
    cost: float
    sizes: tuple[Array, ...] = ()


class Frame:
    """What a fitted model can follow, and what it leaves beyond that: both whitened.

    `rows` (k + 1, m) are an orthonormal basis of the slopes `law` (m, ·), and last the `residual` (m,) freed of them,
    whose square is `total`.
    """

    def __init__(self, law: Array, residual: Array) -> None:
        self.basis = orthonormal(law)
        self.residual = self.free(residual)
        self.total = float(self.residual @ self.residual)
        self.rows = np.ascontiguousarray(np.column_stack([self.basis, self.residual]).T)

    def free(self, columns: Array) -> Array:
        """Columns (m, …) less what the model can follow."""
        return columns - self.basis @ (self.basis.T @ columns)


class Compressed:
    """Gram matrix of the atoms' signatures after projection off the law, and their products with the residual.

    `before` (k,) are the squares of all signatures, side by side, `gram` (k, k) and `product` (k,) what is left of them
    beyond the law, and `total` the square of the residual.
    """

    def __init__(self, atoms: Sequence[Atom], before: Array, gram: Array, product: Array, total: float) -> None:
        self.atoms = tuple(atoms)
        self.starts = np.r_[0, np.cumsum([a.columns.shape[1] for a in atoms])].astype(int)
        before = self.before = np.sqrt(before)
        norm = np.sqrt(np.maximum(np.diag(gram), 0.0))
        self.left = np.divide(norm, before, out=np.zeros_like(before), where=before > 0)
        self.scale = np.where(norm > 1e-7 * np.maximum(before, 1e-300), norm, np.inf)
        self.gram = gram / self.scale / self.scale[:, None]
        self.product = product / self.scale
        self.total = total
        bounds = [(p.lower - p.neutral, p.upper - p.neutral) for a in self.atoms for p in a.sizes]
        self.lower = np.array([b[0] for b in bounds]) if bounds else np.empty(0)
        self.upper = np.array([b[1] for b in bounds]) if bounds else np.empty(0)

    @classmethod
    def together(cls, atoms: Sequence[Atom], matrix: Array, frame: Frame) -> "Compressed":
        """From all signatures side by side and whitened, `matrix` (m, k)."""
        before = np.einsum("mk,mk->k", matrix, matrix)
        matrix = frame.free(matrix)
        return cls(atoms, before, matrix.T @ matrix, matrix.T @ frame.residual, frame.total)

    @classmethod
    def singly(cls, blocks: Sequence["FormBlock"], frame: Frame) -> "Compressed":
        """For atoms that are only looked at one by one: what they have in common is left out, and not worked out."""
        atoms = [atom for block in blocks for atom in block.atoms]
        before, product, begin = [np.empty(0)], [np.empty(0)], 0
        size = sum(block.matrix.shape[1] for block in blocks)
        gram = np.zeros((size, size))
        for block in blocks:
            seen = frame.rows @ block.matrix
            m, width, _ = block.own.shape
            basis = seen[:-1].reshape(-1, m, width)
            own = block.own - np.einsum("bmi,bmj->mij", basis, basis)
            index = begin + np.arange(m * width).reshape(m, width)
            gram[index[:, :, None], index[:, None, :]] = own
            before.append(np.diagonal(block.own, axis1=1, axis2=2).ravel())
            product.append(seen[-1])
            begin += m * width
        return cls(atoms, np.concatenate(before), gram, np.concatenate(product), frame.total)

    def only(self, atoms: Sequence[int]) -> "Compressed":
        """The same with some of the atoms."""
        columns = self.columns(atoms)
        fewer = copy(self)
        fewer.atoms = tuple(self.atoms[a] for a in atoms)
        fewer.starts = np.r_[0, np.cumsum(np.diff(self.starts)[list(atoms)])].astype(int)
        fewer.before, fewer.left, fewer.scale = self.before[columns], self.left[columns], self.scale[columns]
        fewer.gram, fewer.product = self.gram[np.ix_(columns, columns)], self.product[columns]
        fewer.lower, fewer.upper = self.lower[columns], self.upper[columns]
        return fewer

    def columns(self, atoms: Iterable[int]) -> Array:
        """Column numbers of some atoms."""
        parts = [np.arange(self.starts[a], self.starts[a + 1]) for a in atoms]
        return np.concatenate(parts) if parts else np.empty(0, int)

    def solve(self, columns: Array) -> tuple[float, Array]:
        """Gain and sizes (in units of the parameters, zero for a column held at its bound), bounds obeyed by sign."""
        active = [int(c) for c in columns if np.isfinite(self.scale[c])]
        x = np.zeros(0)
        while active:
            x = np.linalg.solve(self._grams(np.array(active)), self.product[active])
            wrong = [i for i, c in enumerate(active) if x[i] < 0 <= self.lower[c] or x[i] > 0 >= self.upper[c]]
            if not wrong:
                break
            worst = max(wrong, key=lambda i: abs(x[i]))
            active.pop(worst)
        sizes = dict(zip(active, x, strict=False)) if active else {}
        gain = float(sum(sizes[c] * self.product[c] for c in active))
        return gain, np.array([sizes.get(int(c), 0.0) / self.scale[c] for c in columns])

    def solve_all(self, sets: Sequence[Array]) -> list[tuple[float, Array]]:
        """The same for many sets of columns, those of one number at once."""
        found: list[tuple[float, Array] | None] = [None] * len(sets)
        alike: dict[int, list[int]] = {}
        for k, columns in enumerate(sets):
            alike.setdefault(len(columns), []).append(k)
        for which in alike.values():
            columns = np.stack([sets[k] for k in which])
            product, scale = self.product[columns], self.scale[columns]
            x = np.linalg.solve(self._grams(columns), product[..., None])[..., 0]
            held = ((x < 0.0) & (self.lower[columns] >= 0.0)) | ((x > 0.0) & (self.upper[columns] <= 0.0))
            gains, sizes = np.sum(x * product, axis=1), x / scale
            for i in np.flatnonzero(np.all(np.isfinite(scale) & ~held, axis=1)):
                found[which[i]] = float(gains[i]), sizes[i]
        return [self.solve(sets[k]) if one is None else one for k, one in enumerate(found)]

    def singles(self) -> list[tuple[float, Array]]:
        """The same for each atom by itself."""
        return self.solve_all([self.columns([k]) for k in range(len(self.atoms))])

    def cheapest(self, price: "Price | None" = None) -> dict[str, tuple[float, int]]:
        """The best atom of each effect: its cost, or minus its gain where nothing has a price, and its number."""
        best: dict[str, tuple[float, int]] = {}
        for k, (atom, (gain, _)) in enumerate(zip(self.atoms, self.singles(), strict=True)):
            cost = (price.of(atom) if price else 0.0) - gain
            if cost < best.get(atom.effect, (np.inf, 0))[0]:
                best[atom.effect] = (cost, k)
        return best

    def _grams(self, columns: Array) -> Array:
        """Gram matrices of sets of columns (…, k), shape (…, k, k)."""
        return self.gram[columns[..., :, None], columns[..., None, :]] + 1e-9 * np.eye(columns.shape[-1])

    def gains_beyond(self, chosen: Sequence[int]) -> Array:
        """Upper bound on the gain of each further atom once `chosen` are in, signs ignored, shape (atoms,)."""
        used = [c for c in self.columns(chosen) if np.isfinite(self.scale[c])]
        gram, product = self.gram, self.product
        if used:
            factor = np.linalg.solve(self._grams(np.array(used)), gram[used])
            gram = gram - gram[:, used] @ factor
            product = product - factor.T @ product[used]
        gains = np.zeros(len(self.atoms))
        widths = np.diff(self.starts)
        for width in np.unique(widths):
            which = np.flatnonzero(widths == width)
            index = self.starts[which][:, None] + np.arange(width)
            blocks = gram[index[:, :, None], index[:, None, :]] + 1e-6 * np.eye(width)
            vectors = product[index]
            gains[which] = np.sum(vectors * np.linalg.solve(blocks, vectors[..., None])[..., 0], axis=1)
        return gains


class FormBlock:
    """The atoms of one form, their signatures side by side and whitened, `matrix` (m, k), and what each has squared."""

    def __init__(self, atoms: Sequence[Atom], noise: Noise) -> None:
        self.atoms = atoms
        self.matrix = noise.whiten(np.hstack([a.columns for a in atoms]))
        parts = self.matrix.reshape(len(self.matrix), len(atoms), -1)
        self.own = np.einsum("nmi,nmj->mij", parts, parts)


def orthonormal(matrix: Array) -> Array:
    """Orthonormal basis of the columns, nearly dependent ones left out, shape (m, rank)."""
    if matrix.shape[1] == 0:
        return np.empty((len(matrix), 0))
    norm = np.linalg.norm(matrix, axis=0)
    u, s, _ = np.linalg.svd(matrix / np.where(norm > 0, norm, 1.0), full_matrices=False)
    return u[:, s > FLAT * s[0]]


def remainder(matrix: Array, target: Array) -> tuple[Array, float]:
    """What of a target (m,) columns (m, k) leave, and how many degrees of freedom they take (Hastie & Tibshirani 1990).

    A ridge of NEARLY keeps dependent columns solvable, at the price of a Gram matrix.
    """
    norm = np.linalg.norm(matrix, axis=0)
    matrix = matrix / np.where(norm > 0, norm, 1.0)
    gram = matrix.T @ matrix
    inverse = np.linalg.inv(gram + NEARLY * np.eye(len(gram)))
    return target - matrix @ (inverse @ (matrix.T @ target)), float(np.sum(inverse * gram))


def beam_search(data: Compressed, price: "Price", most: int, width: int = 24) -> list[Choice]:
    """Best sets of up to `most` effects, cheapest first; the empty set is among them."""
    front = [Choice((), 0.0, 0.0)]
    seen: dict[tuple[int, ...], Choice] = {(): front[0]}
    prices = np.array([price.of(atom) for atom in data.atoms])
    for _ in range(most):
        wanted: dict[tuple[int, ...], None] = {}
        for choice in front:
            kin = {data.atoms[a].term.effect.kin for a in choice.atoms}
            bound = data.gains_beyond(choice.atoms)
            promise = bound - prices
            taken: dict[str, int] = {}
            for a in np.argsort(-promise)[: 12 * width]:
                effect = data.atoms[a].effect
                if data.atoms[a].term.effect.kin in kin or taken.get(effect, 0) >= 3 or bound[a] < price.least:
                    continue
                taken[effect] = taken.get(effect, 0) + 1
                wanted.setdefault(tuple(sorted((*choice.atoms, int(a)))))
        grown = {choice.atoms: choice for choice in evaluate(data, price, [w for w in wanted if w not in seen])}
        if not grown:
            break
        seen |= grown
        front = _diverse(sorted(grown.values(), key=lambda c: c.cost), data, width)
    return sorted(seen.values(), key=lambda c: c.cost)


def evaluate(data: Compressed, price: "Price", sets: Sequence[tuple[int, ...]]) -> list[Choice]:
    """Gain and cost of sets of atoms."""
    found = []
    for atoms, (gain, sizes) in zip(sets, data.solve_all([data.columns(atoms) for atoms in sets]), strict=True):
        parts = np.split(sizes, np.cumsum([len(data.atoms[a].sizes) for a in atoms])[:-1])
        cost = -gain + sum(price.of(data.atoms[a]) for a in atoms)
        found.append(Choice(atoms, gain, cost, tuple(parts)))
    return found


def _diverse(choices: list[Choice], data: Compressed, width: int) -> list[Choice]:
    """The cheapest, at most three of one set of names."""
    kept: list[Choice] = []
    count: dict[frozenset[str], int] = {}
    for choice in choices:
        names = frozenset(data.atoms[a].effect for a in choice.atoms)
        if count.get(names, 0) < 3:
            kept.append(choice)
            count[names] = count.get(names, 0) + 1
        if len(kept) == width:
            break
    return kept


@dataclass(frozen=True)
class Price:
    """What an effect must earn, in whitened squares: per parameter and per name.

    `per_name_alone` is the part for the search among suspects; `tolerance` what an unforeseen form may leave.
    """

    per_parameter: float
    per_name_alone: float
    tolerance: float

    @property
    def per_name(self) -> float:
        """Price of a name, tolerance included."""
        return self.per_name_alone + self.tolerance

    @property
    def least(self) -> float:
        """Gain below which nothing is looked at."""
        return 0.5 * self.per_name

    def of(self, atom: Atom) -> float:
        """Price of one atom."""
        return self.total([atom.term])

    def total(self, terms: Iterable[Term]) -> float:
        """Price of a set of terms."""
        return sum(
            self.per_parameter * len(t.form.params) + self.per_name + SPECIAL * bool(t.effect.special_case_of)
            for t in terms
        )
