"""A fitted model as a muscle that is stepped through time."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..core import DataError, Inputs, Specimen, UsageError
from ..core.recursion import Slot
from ..effects import Effect
from ..model import GEOMETRY, Model, Values
from .arrays import Array, jnp
from .fit_file import ParameterSpread, fitted_branches, read_answer, read_specimen_of
from .loop_check import loop_fault

ByBranch = Mapping[str, Values]
"""Parameter values by branch and name."""
Memory = tuple[Any, ...]
"""What muscles side by side remember of an instant: nested tuples of arrays (n,)."""
SPEED_OF_REVERSAL = 0.2
"""mm/s over which the direction of motion turns over: the sign of a record, made smooth so that dry friction can be
integrated. Slower than any stroke of a rig, faster than what a joint at rest creeps by."""
TEMPERATURE_C = 20.0
BRANCHES = ("contraction", "extension")


@dataclass(frozen=True, eq=False)
class Muscle:
    """A fitted model, stepped through time. `contraction` and `extension` are its parameters by branch, the same where
    both were fitted together, `spreads` the covariances of both where they are known, `rmse` in N what the fit left of
    the record, NaN where that is not known.

    Live, the direction of motion is tanh(v/0.2 mm/s), with 0 at rest; where the branches have parameters of their own,
    their forces are blended by it. Nothing counts as a rig's hold: at rest, friction takes what the load asks for and
    the model adds nothing. A cycle is two reversals, the temperature stays what it was. What the model says of the
    rig (bias and drift of the load cell, compliance of the fixture) it says here too.

    Raises DataError for a parameter that is missing or no number, UsageError for an effect that cannot be traced.
    """

    model: Model
    specimen: Specimen
    contraction: Values
    extension: Values
    spreads: tuple[ParameterSpread | None, ParameterSpread | None] = (None, None)
    seen: Mapping[str, Sequence[float]] = field(default_factory=dict)
    rmse: float = math.nan

    def __post_init__(self) -> None:
        for branch, given in zip(BRANCHES, (self.contraction, self.extension), strict=True):
            for name in self.model.names:
                if not math.isfinite(given.get(name, math.nan)):
                    raise DataError(f"muscle: parameter {name} of {branch} is {given.get(name)}; expected a number")
        for term in self.model.terms:
            fault = loop_fault(term.form, self.specimen)
            if fault:
                raise UsageError(f"effect {term.label} cannot be stepped through time: {fault}")

    @classmethod
    def read(
        cls, path: str | Path, specimen: Specimen | None = None, extra_effects: tuple[Effect, ...] = ()
    ) -> list[Self]:
        """From a file of `pam-ident fit --json` or `add --json` one muscle, from one of `ladder --json` a muscle for
        each rung, the law alone first. `specimen` stands in for the file's.

        Raises DataError for another file, UsageError for an effect that is not known.
        """
        found = read_answer(path)
        given = specimen or read_specimen_of(found)
        muscles = []
        for effects, holders in found.stages:
            fits = {name: found.fitted(holder) for name, holder in holders.items()}
            one, other = fitted_branches(fits, str(path))
            left = [holder.get("rmse_N", math.nan) for holder in holders.values()]
            model, rmse = found.model(effects, extra_effects), float(np.sqrt(np.mean(np.square(left))))
            muscles.append(cls(model, given, one[0], other[0], (one[1], other[1]), found.seen, rmse))
        return muscles

    @property
    def together(self) -> bool:
        """Whether both branches have the same parameters, so that the force is asked for once."""
        return self.contraction == self.extension

    def values(self) -> dict[str, dict[str, float]]:
        """Parameters by branch and name, to be traced or mapped over; fitted together, those of contraction count.

        A fitted geometry is not among them: it stays as it was fitted.
        """
        names = [name for name in self.model.names if name not in self._geometry(self.contraction)]
        given = zip(BRANCHES, (self.contraction, self.extension), strict=True)
        return {branch: {name: float(one[name]) for name in names} for branch, one in given}

    def draws(self, count: int, seed: int) -> dict[str, dict[str, Array]] | None:
        """As `values`, arrays (1 + count,): what was fitted, then draws from its uncertainty, None without that."""
        found = {}
        for branch, own, spread in zip(BRANCHES, (self.contraction, self.extension), self.spreads, strict=True):
            left = None if spread is None else spread.given(tuple(self._geometry(own)))
            if left is None or not left.names:
                return None
            normal = np.random.default_rng(seed).standard_normal((1 + count, len(left.names)))
            normal[0] = 0.0
            params = [p for p in self.model.params if p.name not in self._geometry(own)]
            found[branch] = left.draws(own, params, normal)
        return found

    def start(
        self, pressure_MPa: Array, contraction: Array, time_s: float = 0.0, values: ByBranch | None = None
    ) -> Memory:
        """Memory of n muscles at rest at gauge pressures and contraction ratios (n,); `values` where not its own."""
        given = self.values() if values is None else values
        return self.force(given, None, time_s, pressure_MPa, contraction, jnp.zeros_like(jnp.asarray(contraction)))[1]

    def force(
        self,
        values: ByBranch,
        memory: Memory | None,
        time_s: float | Array,
        pressure_MPa: Array,
        contraction: Array,
        velocity_mm_s: Array,
    ) -> tuple[Array, Memory]:
        """Force in N, shape (n,), at a trial instant, and the memory there; `memory` is that of the last accepted one,
        None at the first.

        Pressure is gauge, velocity dx/dt of the contraction, shape (n,) each. The force may be negative: a muscle that
        cannot push is the joint's to know. To be traced, mapped over and differentiated by JAX.
        """
        p, e, v = (jnp.asarray(x, float) for x in (pressure_MPa, contraction, velocity_mm_s))
        turn, *before = (None, None, None) if memory is None else memory
        direction = jnp.tanh(v / SPEED_OF_REVERSAL)
        turn, cycle = count_reversals(turn, direction)
        inputs = Inputs(
            pressure=p,
            contraction=e,
            specimen=self.specimen,
            direction=direction,
            time=jnp.broadcast_to(jnp.asarray(time_s, float), p.shape),
            velocity=v,
            stroke_speed=jnp.abs(v),
            moving=jnp.ones(p.shape, bool),
            cycle=cycle,
            temperature=jnp.full(p.shape, TEMPERATURE_C),
            segment=jnp.zeros(p.shape, int),
        )
        own = {"contraction": self.contraction, "extension": self.extension}
        asked = [
            self.model.step(inputs, {**self._geometry(own[branch]), **values[branch]}, last)
            for branch, last in zip(BRANCHES[:1] if self.together else BRANCHES, before, strict=False)
        ]
        share = 0.5 * (1.0 + direction)
        force = asked[0][0] if self.together else share * asked[0][0] + (1.0 - share) * asked[1][0]
        return force, (turn, *(after for _, after in asked))

    def _geometry(self, values: Values) -> dict[str, float]:
        return {p.name: values[p.name] for p in GEOMETRY} if self.model.free_geometry else {}


def count_reversals(turn: Slot | None, direction: Array) -> tuple[Slot, Array]:
    """The way each muscle last clearly went with its reversals so far, and the cycle that makes, from 1, (n,) each.

    `turn` is the same of the last accepted instant, None at the first; `direction` is tanh(v/0.2 mm/s), shape (n,).
    """
    if turn is None:
        turn = (jnp.zeros_like(direction), jnp.zeros_like(direction))
    way, reversals = turn
    now = jnp.where(jnp.abs(direction) > 0.5, jnp.sign(direction), way)
    reversals = reversals + (now * way < 0.0)
    return (now, reversals), 1.0 + reversals // 2.0
