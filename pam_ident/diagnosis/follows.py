"""What the error follows, before any name: shares of its square, by smooth surfaces over what was driven.

    r = J b + Σ_k Φ_k a_k + what comes back in repeats + noise

r is what a model leaves (N), J its slopes over its own parameters, Φ_k the columns of a driver: what the force may
follow (direction, speed, the way since the last reversal, …) times low polynomials of pressure and contraction. No
physics and no catalogue enter. Drivers, and how much detail each has, are taken in as long as their gain exceeds its
price; a share is the gain of a driver averaged over all orders of those taken in (Lindeman, Merenda & Gold 1980).
"""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import get_lapack_funcs, solve_triangular

from ..core import Inputs
from ..effects._history import cycles_of_test, relax, runs, since_first, time_held, way_travelled
from ..effects.base import Effect, slip
from ..fitting import Fit
from ..fitting.solve import jacobian
from ..model import Model
from ..records import Record, thinned
from ..records.motion import noise_around
from .dictionary import slopes
from .nouns import Follows
from .repeats import comes_back
from .search import orthonormal

Array = np.ndarray
ROWS = 10_000
"""Rows of a record in time that are looked at: in so many what deserves a name earns ten times its cost."""
ORDERS = 120
"""Orders of drivers over which shares are averaged, at most."""
EQUAL = 20.0
"""Twice the log odds up to which drivers could stand in each other's place."""
NEGLIGIBLE = 0.05
"""Share of the noise's variance below which it does not matter how unsure the position is."""
SPEED_RATIO = 1.5
"""Speeds closer than this are one speed: within a stroke, speed varies with contraction and proves nothing."""
BESIDE = 0.01
"""Share of the evidence that a driver must have to be more than what the surfaces of another leave."""
(POSITIVE_SOLVE,) = get_lapack_funcs(("posv",), dtype=np.float64)
"""Solves with a positive definite matrix, at a third of the time of numpy's general one."""
SEEN, RIDGE = 1e-4, 1e-6
"""Share of a column that the model must leave for it to count, and what keeps dependent ones solvable."""


@dataclass(frozen=True)
class Driver:
    """What a force may follow: its word and words, and its states (n, k), None where the record does not hold it.

    States are times polynomials of pressure and contraction; `orders` are these two, from the simplest surface to the
    richest, and `some` says which of the states are taken together.
    """

    what: str
    text: str
    states: Callable[[Inputs], Array | None]
    some: tuple[tuple[int, ...], ...] = ((0,),)
    orders: tuple[tuple[int, int], ...] = ((0, 0), (1, 0), (0, 1), (0, 3), (1, 1), (2, 3))


def _polynomials(values: Array, most: int) -> Array:
    """Legendre polynomials of 0 … `most` over values (n,), fewer where few values are different, shape (n, orders)."""
    low, high = float(values.min()), float(values.max())
    order = min(most, len(np.unique(np.round((values - low) / max(high - low, 1e-12), 2))) - 1)
    return legendre.legvander((2.0 * values - low - high) / max(high - low, 1e-12), order)


def _direction(inputs: Inputs) -> Array | None:
    return np.column_stack(slip(inputs)) if inputs.has("branch") else None


def _speed(inputs: Inputs) -> Array | None:
    if inputs.velocity is None:
        return None
    v, (moves, _) = np.abs(inputs.velocity), slip(inputs)
    v = v / max(float(np.median(v[moves != 0.0])) if np.any(moves) else 1.0, 1e-9)
    return np.column_stack([v * moves, np.sqrt(v) * moves, np.log1p(10.0 * v) * moves, v])


def _acceleration(inputs: Inputs) -> Array | None:
    if inputs.velocity is None or inputs.time is None:
        return None
    moving = slip(inputs)[0] != 0.0
    within = moving & np.roll(moving, 1) & np.roll(moving, -1)
    steps = np.maximum(np.gradient(inputs.time), 1e-9)
    rate = np.where(within, np.gradient(inputs.velocity) / steps, 0.0)
    return rate[:, None] / max(float(np.sqrt(np.mean(rate**2))), 1e-9)


def _way(inputs: Inputs) -> Array | None:
    if inputs.moving is None:
        return None
    x = inputs.displacement_mm
    way = np.concatenate([np.abs(x[part] - x[part.start]) for part in runs(inputs)])
    stroke = max(float(np.ptp(x)), 1e-9)
    return np.exp(-way[:, None] / (stroke * np.array([0.01, 0.03, 0.1]))) * inputs.direction[:, None]


def _rest(inputs: Inputs) -> Array | None:
    if inputs.time is None or inputs.segment is None or inputs.moving is None:
        return None
    held = time_held(inputs, ~inputs.moving) * ~inputs.moving
    resting = [np.log1p(held / tau) * inputs.direction for tau in (0.3, 10.0)]
    longest = float(np.clip(0.1 * np.ptp(inputs.time), 2.0, 100.0))  # what takes longer is the clock's
    relaxed = [relax(inputs, inputs.contraction, float(tau)) for tau in np.geomspace(0.5, longest, 6)]
    return np.column_stack(relaxed + resting)


def _cycle(inputs: Inputs) -> Array | None:
    if inputs.cycle is None or len(np.unique(inputs.cycle)) < 2:
        return None
    count = inputs.cycle - inputs.cycle.min()
    way = way_travelled(inputs) / max(float(np.ptp(inputs.displacement_mm)), 1e-9)
    states = [np.exp(-count), 1.0 / (1.0 + count), np.log1p(way)]
    if inputs.segment is not None:
        test = cycles_of_test(inputs) - 1.0
        states += [np.exp(-0.5 * test), 1.0 / (1.0 + test)]
    return np.column_stack(states)


def _clock(inputs: Inputs) -> Array | None:
    if inputs.time is None or np.ptp(inputs.time) <= 0.0:
        return None
    since = (inputs.time - inputs.time[0]) / np.ptp(inputs.time)
    settling = [np.exp(-since / tau) for tau in (0.01, 0.04, 0.15)]
    return np.column_stack([_polynomials(inputs.time, 4)[:, 1:], *settling])


def _temperature(inputs: Inputs) -> Array | None:
    if inputs.temperature is None or np.ptp(inputs.temperature) <= 0.0:
        return None
    return since_first(inputs, inputs.temperature)[:, None]


MAP = ((1, 2), (0, 5), (2, 2), (1, 4), (3, 4), (2, 7), (4, 7))
ONE_OR_ALL = ((0,), (1,), (2,), (0, 1, 2))
COUNTED = ((0,), (1,), (2,), (3,), (4,), (0, 1, 2), (2, 3, 4), (0, 1, 2, 3, 4))
RELAXED = ((0, 2, 4), (1, 3, 5), (0, 1, 2, 3, 4, 5), (6, 7), (0, 1, 2, 3, 4, 5, 6, 7))
DRIFTED = ((0,), (0, 1), (0, 1, 2, 3), (0, 4, 5, 6), (0, 1, 2, 3, 4, 5, 6))
DRIVERS = (
    Driver("map", "pressure and contraction, alike on both branches", lambda i: np.ones((len(i), 1)), orders=MAP),
    Driver("direction", "the direction of motion", _direction, ((0,), (0, 1))),
    Driver("speed", "the speed", _speed, ((0,), (0, 1, 2), (0, 1, 2, 3))),
    Driver("acceleration", "the acceleration", _acceleration, orders=((0, 0),)),
    Driver("way", "the way since the last reversal", _way, ONE_OR_ALL),
    Driver("rest", "rest and relaxation", _rest, RELAXED),
    Driver("cycle", "the cycle and the distance travelled", _cycle, COUNTED),
    Driver("clock", "the clock", _clock, DRIFTED, ((0, 0),)),
    Driver("temperature", "the temperature", _temperature),
)


def one_speed(record: Record) -> bool:
    """Whether all strokes of a record in time have practically the same speed."""
    speed = record.inputs.stroke_speed
    if speed is None or record.inputs.moving is None:
        return False
    live = speed[record.inputs.moving]
    return len(live) > 0 and float(np.quantile(live, 0.95)) < SPEED_RATIO * float(np.quantile(live, 0.05))


def steadied(record: Record) -> tuple[Record, Array | None]:
    """At most ROWS rows of a record with its steady inputs, and how far their position may be off in mm, (n,).

    The noise of pressure and length, which a model turns into force, would follow what is measured. A smooth track has
    less of it, but rows that share one have the rest of it in common: together they are as unsure as the sensor makes
    each. None where there is no motion.
    """
    steady, raw = thinned(replace(record, inputs=record.steady), ROWS), thinned(record, ROWS).inputs
    if raw.time is None or raw.moving is None:
        return steady, None
    return steady, noise_around(raw.displacement_mm, raw.time)


def what_it_follows(fit: Fit) -> tuple[Follows, ...]:
    """Shares of a fit's squared error, largest first, noise last; they add to 1, and none is what chance would give."""
    return Following.of(fit).shares()


class Following:
    """What a model leaves, and how much of it smooth surfaces over each set of drivers explain.

    `variance` is that of what the richest surfaces over all drivers leave, and `memory` the samples of it that count as
    one. `unsure` (n,) is how far the position may be off, in mm: where the force is steep, such rows have less weight.
    """

    def __init__(self, record: Record, model: Model, values: Mapping[str, float], unsure: Array | None = None) -> None:
        self.record, self.unsure = record, unsure
        self._look(model, values, np.ones(len(record)))
        if unsure is not None:
            slope = slopes(model, record.inputs, values).contraction / record.specimen.initial_length_mm
            extra = (unsure * slope) ** 2 / max(self.variance, 1e-300)
            if np.mean(extra) > NEGLIGIBLE:
                self._look(model, values, 1.0 / np.sqrt(1.0 + extra))

    def _look(self, model: Model, values: Mapping[str, float], weight: Array) -> None:
        """Work out what is left, surfaces and noise, rows by their weight (n,)."""
        inputs, self.weight = self.record.inputs, weight
        left = (self.record.force - model.force(inputs, values)) * weight
        law = orthonormal(jacobian(model, inputs, values, self.record.force) * weight[:, None])
        self.left = left - law @ (law.T @ left)
        self.surfaces = Surfaces(inputs, law, self.left, weight)
        richest = frozenset({name: k for k, name in enumerate(self.surfaces.names)}.values())
        remainder = self.left - self.surfaces.explained(richest)
        self.variance = float(remainder @ remainder) / max(len(left) - self.surfaces.of(richest)[1], 1.0)
        self.memory = _memory(remainder)

    @classmethod
    def of(cls, fit: Fit) -> "Following":
        """Of the rows of a fit."""
        record, unsure = steadied(fit.record if fit.rows.all() else fit.record.take(fit.rows))
        return cls(record, fit.model, fit.values, unsure)

    @cached_property
    def best(self) -> frozenset[int]:
        """The likeliest set of groups."""
        return self._search[0]

    @property
    def chosen(self) -> frozenset[str]:
        """The drivers of the likeliest set."""
        return frozenset(self.surfaces.names[k] for k in self.best)

    def evidence(self, groups: frozenset[int]) -> float:
        """Gain of a set of groups of surfaces, in variances of the noise, less its price.

        The price is the Bayesian information criterion's, that so many groups were looked at, and that one driver is
        likelier than two that are as good.
        """
        return self._worth(*self.surfaces.of(groups), len(groups))

    def _worth(self, gain: Any, freedom: Any, count: int) -> Any:
        price = freedom * math.log(max(len(self.left) / self.memory, 3.0))
        each = EQUAL + 2.0 * math.log(max(len(self.surfaces.names), 1))
        return gain / (self.variance * self.memory) - price - each * count

    def likeliest(self, without: Collection[str] = (), start: frozenset[int] = frozenset()) -> frozenset[int]:
        """The set of groups, at most one a driver, that nothing added, dropped or exchanged makes likelier.

        The place of one may be another's: what relaxes slowly is nearly the clock.
        """
        surfaces, chosen = self.surfaces, start
        freedom = np.array([len(columns) for columns in surfaces.columns])
        while True:
            best, most = chosen, self.evidence(chosen)
            for rest in (chosen, *(chosen - {k} for k in chosen)):
                if self.evidence(rest) > most:
                    best, most = rest, self.evidence(rest)
                taken = {surfaces.names[k] for k in rest}.union(without)
                free = [k for k, name in enumerate(surfaces.names) if name not in taken]
                if free:
                    gains = surfaces.of(rest)[0] + surfaces.beyond(rest)[free]
                    worth = self._worth(gains, freedom[free] + sum(freedom[k] for k in rest), len(rest) + 1)
                    k = int(np.argmax(worth))
                    if worth[k] > most + 1e-6:
                        best, most = rest | {free[k]}, float(worth[k])
            if best == chosen:
                return chosen
            chosen = best

    @cached_property
    def _search(self) -> tuple[frozenset[int], dict[str, frozenset[int]]]:
        """The likeliest set, and the likeliest without each of its drivers, from which it is sought anew."""
        if not self.left.any():
            return frozenset(), {}
        best, names = self.likeliest(), self.surfaces.names
        while True:
            without = {names[k]: self.likeliest({names[k]}, best - {k}) for k in best}
            others = [self.likeliest(start=one) for one in without.values()]
            better = max(others, key=self.evidence, default=best)
            if self.evidence(better) <= self.evidence(best):
                return best, without
            best = better

    @property
    def newtons(self) -> Array:
        """What the model leaves in N, its own slopes projected out, (n,)."""
        return self.left / self.weight

    @cached_property
    def _instead(self) -> dict[str, tuple[float, frozenset[str]]]:
        """For each of the likeliest drivers what is lost without it, and the likeliest then."""
        best, without = self._search
        return {
            name: (self.evidence(best) - self.evidence(other), frozenset(self.surfaces.names[k] for k in other))
            for name, other in without.items()
        }

    @cached_property
    def drivers(self) -> frozenset[str]:
        """The likeliest drivers, and those that could stand in the place of one at odds that are as good.

        With one speed alone the speed and the direction of motion are one.
        """
        found = self.chosen.union(*(others for loss, others in self._instead.values() if loss < EQUAL))
        same = {"speed", "direction"}
        return found | same if one_speed(self.record) and found & same else found

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """Drivers that must be there; none in a table, which holds few of them."""
        if self.record.inputs.time is None:
            return ()
        least = max(EQUAL, BESIDE * self.evidence(self.best))
        return tuple(name for name, (loss, _) in self._instead.items() if loss > least)

    def uncovered(self, effects: Iterable[Effect]) -> tuple[str, ...]:
        """Drivers that must be there and that none of some effects follows; none where one may follow anything."""
        if any(not effect.follows for effect in effects):
            return ()
        covered = {name for effect in effects for name in effect.follows}
        return tuple(name for name in self.needed if name not in covered)

    def supports(self, follows: Collection[str]) -> bool:
        """Whether what follows these drivers may be missing; in a table, which holds few of them, anything may."""
        return not follows or self.record.inputs.time is None or not self.drivers.isdisjoint(follows)

    def shares(self) -> tuple[Follows, ...]:
        """As `what_it_follows` gives them."""
        words = {driver.what: driver.text for driver in DRIVERS}
        surfaces, total = self.surfaces, float(self.left @ self.left)
        if not total > 0.0:
            return (Follows("noise", 1.0, "noise"),)
        shares = dict.fromkeys(sorted(self.best), 0.0)
        orders = list(permutations(shares)) if len(shares) <= 5 else _drawn_orders(list(shares))
        for order in orders:
            taken: frozenset[int] = frozenset()
            for k in order:
                more = taken | {k}
                (gain, freedom), (before, fewer) = surfaces.of(more), surfaces.of(taken)
                step = gain - before - self.variance * (freedom - fewer)
                shares[k] += max(step, 0.0) / total / len(orders)
                taken = more
        whole = sum(shares.values())
        rest = self.left - surfaces.explained(self.best)
        back = (1.0 - whole) * comes_back(self.record, rest, np.ones(len(rest), bool))
        found = [
            Follows(surfaces.names[k], share, words[surfaces.names[k]]) for k, share in shares.items() if share > 0.0
        ]
        found += [Follows("repeats", back, "what comes back with every repeat, but follows none of these")] * (
            back > 0.0
        )
        found.sort(key=lambda one: -one.share)
        return (*found, Follows("noise", max(1.0 - whole - back, 0.0), "noise"))


class Surfaces:
    """Gain in squares of sets of groups of columns, free of what the model can follow.

    A group is a driver at one degree of detail: some of its states, times polynomials up to some orders.
    """

    def __init__(self, inputs: Inputs, law: Array, left: Array, weight: Array) -> None:
        parts: list[Array] = []
        self.names: list[str] = []
        self.columns: list[Array] = []
        begin = 0
        for driver in DRIVERS:
            states = driver.states(inputs)
            if states is None:
                continue
            over_p, over_e = (
                _polynomials(values, max(order[k] for order in driver.orders))
                for k, values in enumerate((inputs.pressure, inputs.contraction))
            )
            product = states[:, :, None, None] * over_p[:, None, :, None] * over_e[:, None, None, :]
            place = begin + np.arange(product[0].size).reshape(product.shape[1:])
            for which in (some for some in driver.some if max(some) < states.shape[1]):
                for p, e in driver.orders:
                    self.columns.append(place[list(which), : p + 1, : e + 1].ravel())
                    self.names.append(driver.what)
            parts.append(product.reshape(len(left), -1) * weight[:, None])
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


def _drawn_orders(names: list[int]) -> Sequence[tuple[int, ...]]:
    draw = np.random.default_rng(0)
    return [tuple(draw.permutation(names).tolist()) for _ in range(ORDERS)]


def _memory(noise: Array) -> float:
    """Samples that count as one because they are correlated, at least 1: the sum of the first correlations, twice."""
    power = np.abs(np.fft.rfft(noise, 2 * len(noise))) ** 2
    correlation = np.fft.irfft(power)[: len(noise)] / max(float(noise @ noise), 1e-300)
    below = np.flatnonzero(correlation < 0.05)
    return 1.0 + 2.0 * float(np.sum(correlation[1 : below[0]])) if len(below) and below[0] > 1 else 1.0


def told(found: Sequence[Follows]) -> str:
    """The largest shares in one sentence."""
    parts = [f"{one.share:.0%} follows {one.text}" for one in found if one.what != "noise" and one.share >= 0.01][:4]
    noise = next((one.share for one in found if one.what == "noise"), 0.0)
    if not parts:
        return "None of the squared error follows anything beyond chance: it is noise."
    return f"Of the squared error {', '.join(parts)}; {noise:.0%} is noise."
