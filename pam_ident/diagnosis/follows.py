"""What the error follows, before any name: shares of its square, by smooth surfaces over what was driven.

    r = J b + Σ_k Φ_k a_k + what comes back in repeats + noise

r is what a model leaves (N), J its slopes over its own parameters, Φ_k the columns of a driver: what the force may
follow (direction, speed, the way since the last reversal, …) times low polynomials of pressure and contraction. No
physics and no catalogue enter. Drivers, and how much detail each has, are taken in as long as their gain exceeds its
penalty; a share is what a driver explains beyond those before it, the likeliest first.
"""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ..effects.base import Effect
from ..fitting import Fit
from ..fitting.estimate import at_bound
from ..fitting.solve import jacobian
from ..model import Model
from ..records import Record
from ..records.roughness import position_noise
from .dictionary import slopes
from .drivers import DRIVERS
from .leaps import ALONE, LEAP, Leap, farthest
from .nouns import Follows
from .own_noise import OwnNoise
from .repeats import comes_back, memory_of, step_of
from .schedule import one_speed, way_is_time
from .search import CLOSE, TEMPER, orthonormal
from .sentence import REST
from .steady import steadied, without_sensor
from .surfaces import Surfaces
from .track import SharedNoise, TrackError

Array = np.ndarray
BESIDE = 0.01
"""Share of the evidence that a driver must have to be more than what the surfaces of another leave."""
STATIC = 500.0
"""Loss of evidence by which nothing takes the place of the map: four static records lost 1,380 to 1,680."""


class Following:
    """What a model leaves, and how much of it smooth surfaces over each set of drivers explain.

    `variance` is that of what the richest surfaces over all drivers leave, `rough` the size of its white part, and
    `memory` the samples of it that count as one. `leap` is a jump that is none of theirs, if one stands alone. `unsure`
    is how far the driven track may be off: what it makes of the force is evened out, and where it is unread nothing is
    looked at.
    """

    def __init__(
        self, record: Record, model: Model, values: Mapping[str, float], unsure: TrackError | None = None
    ) -> None:
        self.record, self.unsure = record, unsure
        self.read = ~unsure.unread if unsure else np.ones(len(record), bool)
        self.shared: SharedNoise | None = None
        self._look(model, values)
        moment, size = self._farthest
        if size >= LEAP**2:
            self._look(model, values, moment)
            left, squares = self._farthest[1], self.leap.gain if self.leap else 0.0
            if left > size / ALONE or squares < LEAP**2 * self.variance * max(self.memory, 1.0):
                self._look(model, values)
        if unsure is not None:
            slope = unsure.slope(slopes(model, record.inputs, values), record.specimen)
            # Once for the record: noise with and without what rows share has likelihoods that nothing compares.
            if unsure.matters(slope, self.rough):
                self.shared = unsure.in_force(slope, math.sqrt(self.variance), every=True)
                self._look(model, values, self.leap and self.leap.moment)
            else:
                self.unsure = replace(unsure, blocks=())

    def _look(self, model: Model, values: Mapping[str, float], moment: float | None = None) -> None:
        """What is left, less a step at a `moment` in s, surfaces and noise, what rows share of it evened out."""
        inputs, even = without_sensor(self.record), self._even
        left = even(self.record.force - model.force(self.record.inputs, values))
        free = [not at_bound(p, values[p.name]) for p in model.bounded(inputs)]  # none can follow beyond its bound
        law = orthonormal(even(jacobian(model, inputs, values, self.record.force)[:, free]))
        self.left, self.leap = left - law @ (law.T @ left), None
        if moment is not None and inputs.time is not None:  # smooth courses of any driver would take it in
            later = even(np.where(inputs.time >= moment, 1.0, 0.0))
            later -= law @ (law.T @ later)
            self.leap = Leap.of(moment, later, self.left)
            law = np.column_stack([law, later / np.linalg.norm(later)])
            self.left = self.left - self.leap.size_N * later
        one = ("speed",) if one_speed(self.record) else ()  # which is then the direction
        self.surfaces = Surfaces(inputs, law, self.left, even, one)
        self.richest = self.surfaces.richest(int(np.count_nonzero(self.read)))
        remainder = self.left - self.surfaces.explained(self.richest)
        freedom = int(self.read.sum()) - self.surfaces.of(self.richest)[1]
        self.variance = float(remainder @ remainder) / max(freedom, 1.0)
        self.memory = memory_of(remainder)
        self.rough = position_noise(remainder, self.record.inputs.time)

    @property
    def _farthest(self) -> tuple[float, float]:
        """Of what the richest surfaces leave, as `farthest` has it; nowhere in a table."""
        time, remainder = self.record.inputs.time, self.left - self.surfaces.explained(self.richest)
        return (0.0, 0.0) if time is None else farthest(remainder[self.read], time[self.read], step_of(self.record))

    def _even(self, values: Array) -> Array:
        """Values (n,) or columns (n, k) with what rows share evened out, 0 where the track is unread."""
        seen = np.where(self.read[:, None] if values.ndim == 2 else self.read, values, 0.0)
        return self.shared.even(seen) if self.shared else seen

    @classmethod
    def of(cls, fit: Fit) -> "Following":
        """Of the rows of a fit."""
        whole = fit.record if fit.rows.all() else fit.record.take(fit.rows)
        record, unsure = steadied(whole, fit.model, fit.values)
        return cls(record, fit.model, fit.values, unsure)

    @cached_property
    def best(self) -> frozenset[int]:
        """The likeliest set of groups."""
        return min(self._criteria, key=self._criteria.__getitem__)

    @cached_property
    def _criteria(self) -> dict[frozenset[int], float]:
        """Criterion of the likeliest set of a search, of what could stand in its place, of single drivers and none, and
        of these with fewer drivers."""
        best, without = self._search
        sets = {best, *without.values(), frozenset[int]()}
        if self._own_noise:
            sets |= set(self._single)
            sets |= {one - {k} for one in sets for k in one}
        found: dict[frozenset[int], float] = {}
        while sets := {one for one in sets if one not in found}:
            found |= {one: self._criterion(one) for one in sets}
            here = min(found, key=found.__getitem__)
            sets = {here - {k} for k in here} if self._own_noise else set()
        return found

    @cached_property
    def _own_noise(self) -> OwnNoise | None:
        """What compares sets, None in a table and where nothing is followed."""
        best, _ = self._search
        compared = best and self.record.inputs.time is not None
        return OwnNoise(self.left, self.surfaces, best, self.read, self._each) if compared else None

    def _criterion(self, groups: frozenset[int]) -> float:
        return self._own_noise.criterion(groups) if self._own_noise else -self.evidence(groups)

    @property
    def _exchanged(self) -> list[frozenset[int]]:
        """The likeliest set with one driver exchanged for each other that is nearly as good."""
        found, least = [], self.evidence(self.best) - self._least
        for rest in (self.best - {k} for k in self.best):
            worth = self._adding(rest)
            others = [self._best_group(name, worth) for name in set(self.surfaces.names) - self.chosen]
            found += [rest | {other} for other in others if worth[other] > least]
        return found

    @cached_property
    def _single(self) -> list[frozenset[int]]:
        """Of each driver the likeliest group."""
        alone = self._adding(frozenset())
        return [frozenset({self._best_group(name, alone)}) for name in sorted(set(self.surfaces.names))]

    def _best_group(self, name: str, worth: Array) -> int:
        """Of a driver's groups that of most worth, (groups,)."""
        return max((k for k, other in enumerate(self.surfaces.names) if other == name), key=worth.__getitem__)

    @property
    def chosen(self) -> frozenset[str]:
        """The drivers of the likeliest set."""
        return self._named(self.best)

    def _named(self, groups: frozenset[int]) -> frozenset[str]:
        """The drivers of a set of groups."""
        return frozenset(self.surfaces.names[k] for k in groups)

    def evidence(self, groups: frozenset[int]) -> float:
        """Gain of a set of groups of surfaces, in variances of the noise, less its penalty.

        The penalty is the Bayesian information criterion's, that so many groups were looked at, and that one driver is
        likelier than two that are as good.
        """
        return self._worth(*self.surfaces.of(groups), len(groups))

    def _worth(self, gain: Any, freedom: Any, count: int) -> Any:
        penalty = freedom * math.log(max(len(self.left) / self.memory, 3.0))
        return gain / (self.variance * self.memory) - penalty - self._each * count

    @property
    def _each(self) -> float:
        """What a driver costs."""
        return CLOSE + 2.0 * math.log(max(len(self.surfaces.names), 1))

    def _adding(self, groups: frozenset[int]) -> Array:
        """Evidence of a set with each of all groups besides, shape (groups,)."""
        surfaces, (gain, freedom) = self.surfaces, self.surfaces.of(groups)
        more = np.array([len(columns) for columns in surfaces.columns])
        return self._worth(gain + surfaces.beyond(groups), freedom + more, len(groups) + 1)

    def likeliest(
        self, without: Collection[str] = (), start: frozenset[int] = frozenset(), kept: frozenset[int] = frozenset()
    ) -> frozenset[int]:
        """The set of groups, at most one a driver, that nothing added, dropped (but what is `kept`) or exchanged makes
        likelier.

        The place of one may be another's: what relaxes slowly is nearly the clock.
        """
        surfaces, chosen = self.surfaces, start
        while True:
            best, most = chosen, self.evidence(chosen)
            for rest in (chosen, *(chosen - {k} for k in chosen - kept)):
                if self.evidence(rest) > most:
                    best, most = rest, self.evidence(rest)
                taken = {surfaces.names[k] for k in rest}.union(without)
                free = [k for k, name in enumerate(surfaces.names) if name not in taken]
                if free:
                    worth = self._adding(rest)
                    k = max(free, key=worth.__getitem__)
                    if worth[k] > most + 1e-6:
                        best, most = rest | {k}, float(worth[k])
            if best == chosen:
                return chosen
            chosen = best

    @cached_property
    def _search(self) -> tuple[frozenset[int], dict[str, frozenset[int]]]:
        """The likeliest set, and the likeliest without each of its drivers, from which it is sought anew."""
        if not self.left.any():
            return frozenset(), {}
        names = self.surfaces.names
        # One that imitates two hides them from a search that begins with it.
        best = max((self.likeliest(start=one) for one in self._single), key=self.evidence)
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
        return self.in_newtons(self.left)

    @property
    def newtons_followed(self) -> Array:
        """What of it the likeliest drivers explain, in N, (n,); no number where the track is unread."""
        return np.where(self.read, self.in_newtons(self.surfaces.explained(self.best)), np.nan)

    def in_newtons(self, values: Array) -> Array:
        """Values (n,) or columns (n, k) as they are before what rows share is evened out."""
        return self.shared.back(values) if self.shared else values

    def _loss(self, groups: frozenset[int]) -> float:
        """What is lost by a set. What builds up after a reversal is one force, of one direction at the end: two drivers
        cost as one."""
        own, best = (
            self._criterion(one) - self._each * (self._named(one) >= {"way", "direction"})
            for one in (groups, self.best)
        )
        return own - best

    @cached_property
    def _instead(self) -> dict[str, tuple[float, frozenset[str]]]:
        """For each of the likeliest drivers what is lost without it, and the likeliest then."""
        found = {}
        for name in self.chosen:
            other = min((one for one in self._criteria if name not in self._named(one)), key=self._loss, default=None)
            if other is not None:
                found[name] = (self._loss(other), self._named(other))
        return found

    @property
    def _least(self) -> float:
        """Loss of evidence from which drivers are not as good."""
        return max(CLOSE, BESIDE * self.evidence(self.best))

    def _beside(self, name: str) -> float:
        """What is lost by a further driver beside the likeliest, in its best detail, the others in theirs."""
        added = self._best_group(name, self._adding(self.best))
        best = self.likeliest(start=self.best | {added}, kept=frozenset({added}))
        return self.evidence(self.best) - self.evidence(best)

    @cached_property
    def likely(self) -> frozenset[str]:
        """The likeliest drivers, and those that could stand in the place of one, at odds as good.

        With one speed alone the speed and the direction of motion are one; and where nothing rests, too, or in a locked
        muscle, of which nobody measures how far its braid slides, the way since a reversal and the relaxation since.
        """
        sets = [one for one in (*self._criteria, *self._exchanged) if not one >= self.best]
        as_good = [self._named(one) for one in sets if self._loss(one) <= CLOSE]
        return self._alike(self.chosen.union(*as_good))

    @property
    def possible(self) -> frozenset[str]:
        """The likeliest, and those without which none of these is `needed`; in the place of the map only those that
        lose less than STATIC: what has no history leaves nothing to them, however large it is."""
        least, place = self._least, self._instead.items()
        found = [others for name, (loss, others) in place if loss <= (min(least, STATIC) if name == "map" else least)]
        return self._alike(self.likely.union(*found))

    @cached_property
    def drivers(self) -> frozenset[str]:
        """The likely drivers, and those that could stand beside them, at odds as good."""
        beside = {name for name in set(self.surfaces.names) - self.likely if self.best and self._beside(name) < CLOSE}
        return self._alike(self.likely | beside)

    def _alike(self, found: frozenset[str]) -> frozenset[str]:
        """Drivers with those that are one with them in this record, or may be a part of them."""
        one = [{"speed", "pressure_rate"}] if "pressure_rate" in self.surfaces.names else []  # a lag follows both
        one += [{"speed", "direction"}] if one_speed(self.record) else []
        one += [{"way", "rest"}] if self.record.inputs.locked or way_is_time(self.record) else []
        return found.union(*(same for same in one if found & same))

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """Drivers that must be there; none in a table, which holds few of them."""
        if self.record.inputs.time is None:
            return ()
        return tuple(name for name, (loss, _) in self._instead.items() if loss > self._least)

    def uncovered(self, effects: Collection[Effect], among: Iterable[str] | None = None) -> tuple[str, ...]:
        """Drivers that must be there, or `among` some, that none of some effects follows; none where one may follow
        anything."""
        if any(not effect.follows for effect in effects):
            return ()
        covered = {name for effect in effects for name in effect.follows}
        return tuple(name for name in (self.needed if among is None else among) if name not in covered)

    def enough(self, drivers: Collection[str], without: str) -> bool:
        """Whether some drivers explain as much as the likeliest do, without a certain one."""
        loss, instead = self._instead.get(without, (0.0, self.chosen))
        return loss < CLOSE and instead.issubset(drivers)

    def as_good(self, driver: str) -> frozenset[str]:
        """What replaces one of the likeliest drivers at odds as good; nothing the map, which has no history."""
        loss, others = self._instead.get(driver, (math.inf, self.chosen))
        return others - self.chosen if loss < CLOSE and driver != "map" else frozenset()

    def unknown_instead(self, effect: Effect, known: Iterable[Effect]) -> float:
        """Chance that the force follows, in place of what an effect follows first, what none of the `known` follows."""
        if not effect.follows or self.record.inputs.time is None:
            return 0.0
        open_ = set(self.surfaces.names).difference(name for one in known for name in one.follows)
        loss, instead = self._instead.get(effect.follows[0], (-math.inf, self.chosen))
        if open_.isdisjoint(instead):
            return 0.0
        if loss < 0.0:
            loss = self.evidence(self.likeliest(open_)) - self.evidence(self.best)
        return 0.5 - 0.5 * math.tanh(loss / (4.0 * TEMPER))

    def supports(self, follows: Sequence[str]) -> bool:
        """Whether what follows these drivers may be missing; in a table, which holds few of them, anything may.

        The first of them is what tells it from others: friction whose speed does not matter is no Stribeck friction. So
        it must be possible, and where another of them is among the drivers be one itself. But what lags what is driven
        follows its rate, or relaxes once that has changed, by how long it lags.
        """
        drivers = self.drivers
        sought = drivers if drivers.intersection(follows) else self.possible
        first = {*follows[:1], *(("rest",) if {"pressure_rate", "rest"}.issubset(follows) else ())}
        return not follows or self.record.inputs.time is None or not first.isdisjoint(sought)

    def shares(self) -> tuple[Follows, ...]:
        """Shares of the squared error, largest first, noise last; they add to 1, and none is what chance would give."""
        moving = self.record.inputs.moving
        rests = moving is not None and not moving.all()
        words = {driver.what: driver.text if rests else driver.in_motion or driver.text for driver in DRIVERS}
        jump = self.leap.gain if self.leap else 0.0
        surfaces, total = self.surfaces, float(self.left @ self.left) + jump
        if not total > 0.0:
            return (Follows("noise", 1.0, "noise"),)
        jump /= total
        shares, taken = dict[int, float](), frozenset[int]()
        while rest := self.best - taken:
            worth = self._adding(taken)
            k = max(sorted(rest), key=worth.__getitem__)
            (gain, freedom), (before, fewer) = surfaces.of(taken | {k}), surfaces.of(taken)
            shares[k] = max(gain - before - self.variance * (freedom - fewer), 0.0) / total
            taken |= {k}
        whole = sum(shares.values())
        left = self.left - surfaces.explained(self.best)
        back = (1.0 - jump - whole) * comes_back(self.record, self.in_newtons(left), self.read)
        found = [
            Follows(surfaces.names[k], share, words[surfaces.names[k]]) for k, share in shares.items() if share > 0.0
        ]
        if self.leap:
            found.append(Follows("step", jump, self.leap.text))
        if back > 0.0:
            text = "a course of its own that comes back with every repeat, every second one, or the same force"
            found.append(Follows("repeats", back, text))
        found.sort(key=lambda one: -one.share)
        # What a table leaves may be noise; nothing in it repeats, to tell.
        text = REST if self.record.inputs.time is None else "noise"
        return (*found, Follows("noise", max(1.0 - jump - whole - back, 0.0), text))
