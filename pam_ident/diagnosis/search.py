"""Which set of effects explains the residual best, on compressed data.

All signatures are whitened and freed of what the law itself can follow; then every set costs only a small
linear solve in their Gram matrix.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np

from ..effects import Effect
from ..model import Term
from .dictionary import Regressor
from .noise import Noise

Array = np.ndarray


FLAT = 1e-9
"""Singular value, relative to the largest, below which columns of unit norm count as dependent."""
ROUNDED = 1e-7
"""Share of a column that rounding leaves of it once the law, which can follow it, has been taken off its squares."""
NEARLY = 1e-10
"""Share of a column's square that hides what rounding does to columns that nearly depend on others."""
TEMPER = 4.0
"""Criteria are divided by this before they become odds: forms are never exactly right, so evidence counts for less."""
CLOSE = 20.0
"""Criterion, or twice the log odds, by which two answers may differ and not be told apart: odds of 12, tempered."""
SPECIAL = -1.0
"""What a special case costs beyond the effect that it is a case of: where it is needed, it has the nearer name."""


@dataclass(frozen=True)
class Choice:
    """A set of regressors, its gain (fall of the whitened sum of squares) and criterion (what is minimised)."""

    regressors: tuple[int, ...]
    gain: float
    criterion: float
    coefficients: tuple[Array, ...] = ()


class Frame:
    """What a fitted model can follow, and what it leaves beyond that: both whitened.

    `rows` (k + 1, m) are an orthonormal basis of the slopes `law` (m, ·), and last the `residual` (m,) freed of them,
    whose square is `total`.
    """

    def __init__(self, law: Array, residual: Array) -> None:
        basis = orthonormal(law)
        residual = residual - basis @ (basis.T @ residual)
        self.total = float(residual @ residual)
        self.rows = np.ascontiguousarray(np.column_stack([basis, residual]).T)


class Compressed:
    """Gram matrix of the regressors' signatures after projection off the law, and their products with the residual.

    `before` (k,) are the squares of all signatures, side by side, `gram` (k, k) and `product` (k,) what is left of them
    beyond the law, and `total` the square of the residual.
    """

    def __init__(
        self, regressors: Sequence[Regressor], before: Array, gram: Array, product: Array, total: float
    ) -> None:
        self.regressors = tuple(regressors)
        self.starts = np.r_[0, np.cumsum([a.columns.shape[1] for a in regressors])].astype(int)
        before = self.before = np.sqrt(before)
        norm = np.sqrt(np.maximum(np.diag(gram), 0.0))
        more = norm > ROUNDED * np.maximum(before, 1e-300)
        self.left = np.divide(norm, before, out=np.zeros_like(before), where=more)
        self.scale = np.where(more, norm, np.inf)
        self.gram = gram / self.scale / self.scale[:, None]
        self.product = product / self.scale
        self.total = total
        bounds = [(p.lower - p.neutral, p.upper - p.neutral) for a in self.regressors for p in a.linear]
        self.lower = np.array([b[0] for b in bounds]) if bounds else np.empty(0)
        self.upper = np.array([b[1] for b in bounds]) if bounds else np.empty(0)

    @classmethod
    def together(cls, regressors: Sequence[Regressor], matrix: Array, frame: Frame) -> "Compressed":
        """From all signatures side by side and whitened, `matrix` (m, k)."""
        own, seen = matrix.T @ matrix, frame.rows @ matrix
        return cls(regressors, np.diag(own), own - seen[:-1].T @ seen[:-1], seen[-1], frame.total)

    @classmethod
    def singly(cls, blocks: Sequence["FormBlock"], frame: Frame) -> "Compressed":
        """For regressors that are looked at one by one: what they have in common is not worked out."""
        regressors = [regressor for block in blocks for regressor in block.regressors]
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
        return cls(regressors, np.concatenate(before), gram, np.concatenate(product), frame.total)

    def only(self, regressors: Sequence[int]) -> "Compressed":
        """The same with some of the regressors."""
        columns = self.columns(regressors)
        fewer = copy(self)
        fewer.regressors = tuple(self.regressors[a] for a in regressors)
        fewer.starts = np.r_[0, np.cumsum(np.diff(self.starts)[list(regressors)])].astype(int)
        fewer.before, fewer.left, fewer.scale = self.before[columns], self.left[columns], self.scale[columns]
        fewer.gram, fewer.product = self.gram[np.ix_(columns, columns)], self.product[columns]
        fewer.lower, fewer.upper = self.lower[columns], self.upper[columns]
        return fewer

    def columns(self, regressors: Iterable[int]) -> Array:
        """Column numbers of some regressors."""
        parts = [np.arange(self.starts[a], self.starts[a + 1]) for a in regressors]
        return np.concatenate(parts) if parts else np.empty(0, int)

    def solve(self, columns: Array) -> tuple[float, Array]:
        """Gain and coefficients in units of the parameters, zero for a column at its bound; bounds obeyed by sign."""
        active = [int(c) for c in columns if np.isfinite(self.scale[c])]
        x = np.zeros(0)
        while active:
            x = np.linalg.solve(self._grams(np.array(active)), self.product[active])
            wrong = [i for i, c in enumerate(active) if x[i] < 0 <= self.lower[c] or x[i] > 0 >= self.upper[c]]
            if not wrong:
                break
            worst = max(wrong, key=lambda i: abs(x[i]))
            active.pop(worst)
        coefficients = dict(zip(active, x, strict=False)) if active else {}
        gain = float(sum(coefficients[c] * self.product[c] for c in active))
        return gain, np.array([coefficients.get(int(c), 0.0) / self.scale[c] for c in columns])

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
            gains, coefficients = np.sum(x * product, axis=1), x / scale
            for i in np.flatnonzero(np.all(np.isfinite(scale) & ~held, axis=1)):
                found[which[i]] = float(gains[i]), coefficients[i]
        return [self.solve(sets[k]) if one is None else one for k, one in enumerate(found)]

    def singles(self) -> list[tuple[float, Array]]:
        """The same for each regressor by itself."""
        return self.solve_all([self.columns([k]) for k in range(len(self.regressors))])

    def best_of_each(self, penalty: "Penalty | None" = None) -> dict[str, tuple[float, int]]:
        """The best regressor of each effect: its criterion, or minus its gain without a penalty, and its number."""
        best: dict[str, tuple[float, int]] = {}
        for k, (regressor, (gain, _)) in enumerate(zip(self.regressors, self.singles(), strict=True)):
            criterion = (penalty.of(regressor) if penalty else 0.0) - gain
            if criterion < best.get(regressor.effect, (np.inf, 0))[0]:
                best[regressor.effect] = (criterion, k)
        return best

    def _grams(self, columns: Array) -> Array:
        """Gram matrices of sets of columns (…, k), shape (…, k, k)."""
        return self.gram[columns[..., :, None], columns[..., None, :]] + 1e-9 * np.eye(columns.shape[-1])

    def gains_beyond(self, chosen: Sequence[int]) -> Array:
        """Bound on the gain of each further regressor once `chosen` are in, signs ignored, shape (regressors,)."""
        used = [c for c in self.columns(chosen) if np.isfinite(self.scale[c])]
        gram, product = self.gram, self.product
        if used:
            factor = np.linalg.solve(self._grams(np.array(used)), gram[used])
            gram = gram - gram[:, used] @ factor
            product = product - factor.T @ product[used]
        gains = np.zeros(len(self.regressors))
        widths = np.diff(self.starts)
        for width in np.unique(widths):
            which = np.flatnonzero(widths == width)
            index = self.starts[which][:, None] + np.arange(width)
            blocks = gram[index[:, :, None], index[:, None, :]] + 1e-6 * np.eye(width)
            vectors = product[index]
            gains[which] = np.sum(vectors * np.linalg.solve(blocks, vectors[..., None])[..., 0], axis=1)
        return gains


class FormBlock:
    """The regressors of one form, side by side and whitened, `matrix` (m, k), and what each has squared."""

    def __init__(self, regressors: Sequence[Regressor], noise: Noise) -> None:
        self.regressors = regressors
        self.matrix = noise.whiten(np.hstack([a.columns for a in regressors]))
        parts = self.matrix.reshape(len(self.matrix), len(regressors), -1)
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

    A ridge of NEARLY keeps dependent columns solvable, at the penalty of a Gram matrix.
    """
    norm = np.linalg.norm(matrix, axis=0)
    matrix = matrix / np.where(norm > 0, norm, 1.0)
    gram = matrix.T @ matrix
    inverse = np.linalg.inv(gram + NEARLY * np.eye(len(gram)))
    return target - matrix @ (inverse @ (matrix.T @ target)), float(np.sum(inverse * gram))


def beam_search(data: Compressed, penalty: "Penalty", most: int, width: int = 24) -> list[Choice]:
    """Best sets of up to `most` effects, best first; the empty set is among them."""
    front = [Choice((), 0.0, 0.0)]
    seen: dict[tuple[int, ...], Choice] = {(): front[0]}
    penalties = np.array([penalty.of(regressor) for regressor in data.regressors])
    for _ in range(most):
        wanted: dict[tuple[int, ...], None] = {}
        for choice in front:
            taken_groups = {data.regressors[a].term.effect.exclusion_group for a in choice.regressors}
            bound = data.gains_beyond(choice.regressors)
            promise = bound - penalties
            taken: dict[str, int] = {}
            for a in np.argsort(-promise)[: 12 * width]:
                effect = data.regressors[a].effect
                if (
                    data.regressors[a].term.effect.exclusion_group in taken_groups
                    or taken.get(effect, 0) >= 3
                    or bound[a] < penalty.least
                ):
                    continue
                taken[effect] = taken.get(effect, 0) + 1
                wanted.setdefault(tuple(sorted((*choice.regressors, int(a)))))
        grown = {choice.regressors: choice for choice in evaluate(data, penalty, [w for w in wanted if w not in seen])}
        if not grown:
            break
        seen |= grown
        front = _diverse(sorted(grown.values(), key=lambda c: c.criterion), data, width)
    return sorted(seen.values(), key=lambda c: c.criterion)


def evaluate(data: Compressed, penalty: "Penalty", sets: Sequence[tuple[int, ...]]) -> list[Choice]:
    """Gain and criterion of sets of regressors."""
    found = []
    for regressors, (gain, coefficients) in zip(
        sets, data.solve_all([data.columns(regressors) for regressors in sets]), strict=True
    ):
        parts = np.split(coefficients, np.cumsum([len(data.regressors[a].linear) for a in regressors])[:-1])
        criterion = -gain + sum(penalty.of(data.regressors[a]) for a in regressors)
        found.append(Choice(regressors, gain, criterion, tuple(parts)))
    return found


def _diverse(choices: list[Choice], data: Compressed, width: int) -> list[Choice]:
    """The best_of_each, at most three of one set of names."""
    kept: list[Choice] = []
    count: dict[frozenset[str], int] = {}
    for choice in choices:
        names = frozenset(data.regressors[a].effect for a in choice.regressors)
        if count.get(names, 0) < 3:
            kept.append(choice)
            count[names] = count.get(names, 0) + 1
        if len(kept) == width:
            break
    return kept


@dataclass(frozen=True)
class Penalty:
    """What an effect must earn, in whitened squares: per parameter and per name.

    `per_name_alone` is the part for the search among candidates; `tolerance` what an unforeseen form may leave. `odds`
    are the prior odds of effects by name, over those that any effect has.
    """

    per_parameter: float
    per_name_alone: float
    tolerance: float
    odds: Mapping[str, float] = field(default_factory=dict)

    @property
    def per_name(self) -> float:
        """Penalty of a name, tolerance included."""
        return self.per_name_alone + self.tolerance

    @property
    def least(self) -> float:
        """Gain below which nothing is looked at."""
        return 0.5 * self.per_name

    def of(self, regressor: Regressor) -> float:
        """Penalty of one regressor."""
        return self.total([regressor.term])

    def total(self, terms: Iterable[Term]) -> float:
        """Penalty of a set of terms. The tolerance counts twice for a name that follows what another does, too: one
        effect in a form that nobody foresaw is likelier than two that follow the same. Here a rate is a rate, whether
        of the length or of the pressure."""
        terms = list(terms)
        followed = [_lengths_own(t.effect) for t in terms if t.effect.follows]
        again = len(followed) - len(set(followed))
        each = sum(self.alone(t) + self.tolerance + SPECIAL * bool(t.effect.special_case_of) for t in terms)
        return each + again * self.tolerance

    def alone(self, term: Term) -> float:
        """Penalty of a term where no tolerance is needed."""
        prior = 2.0 * TEMPER * math.log(self.odds.get(term.effect.name, 1.0))
        return self.per_parameter * len(term.form.params) + self.per_name_alone - prior


def _lengths_own(effect: Effect) -> tuple[str, ...]:
    """What an effect follows, but for what it follows of the pressure as of the length."""
    return tuple(driver for driver in effect.follows if driver != "pressure_rate")
