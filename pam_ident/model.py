"""A model is one law plus labelled effects; nothing else."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Any

import numpy as np

from .core import Inputs, Param, UsageError
from .core.lmfit_names import from_lmfit_names, to_parameters
from .core.recursion import Live, Memory
from .effects import (
    AddsForce,
    Effect,
    Form,
    ScalesForce,
    TransformsContraction,
    TransformsPressure,
    catalogue,
    get_effect,
    in_words,
)
from .laws import Law, get_law

if TYPE_CHECKING:
    import lmfit

Array = np.ndarray
Values = Mapping[str, float]


@dataclass(frozen=True)
class Term:
    """An effect in one of its forms, as part of a model."""

    effect: Effect
    form: Form

    def __reduce__(self) -> tuple[Any, ...]:
        known = catalogue().get(self.effect.name)  # whose forms may hold functions made on the spot
        by_name = known is not None and self.form in known.forms
        return (as_term, (f"{self.effect.name}:{self.form.name}",)) if by_name else (Term, (self.effect, self.form))

    @property
    def label(self) -> str:
        """The effect's name, with the form's behind a colon where that is not the simplest."""
        simplest = self.form.name == self.effect.simplest
        return self.effect.name if simplest else f"{self.effect.name}:{self.form.name}"

    def qualified(self, params: tuple[Param, ...]) -> tuple[Param, ...]:
        """Parameters under the name `effect.parameter`."""
        return tuple(replace(p, name=f"{self.effect.name}.{p.name}") for p in params)

    def columns(self, inputs: Inputs, values: Values, force: Array) -> Array:
        """The form's columns, shape (n, k), at the nonlinear parameters in `values`."""
        shape = {p.name: values[f"{self.effect.name}.{p.name}"] for p in self.form.nonlinear}
        return self.form.columns(inputs, shape, force)

    def amount(self, inputs: Inputs, values: Values, force: Array) -> Array:
        """columns · (linear − neutral), shape (n,)."""
        linear = _vector(inputs, [values[f"{self.effect.name}.{p.name}"] - p.neutral for p in self.form.linear])
        return self.columns(inputs, values, force) @ linear


def as_term(effect: "str | Effect | Term", extra: tuple[Effect, ...] = ()) -> Term:
    """A term from `name` or `name:form`, from an effect (its simplest form), or as it is. Raises UsageError."""
    if isinstance(effect, str):
        return Term(*get_effect(effect, extra))
    if isinstance(effect, Effect):
        return Term(effect, effect.forms[0])
    if isinstance(effect, Term):
        return effect
    raise UsageError(f"effect {effect!r}: expected a name, such as 'creep', or an Effect")


@dataclass(frozen=True, init=False, repr=False)
class Model:
    """F(p, ε, …): one law, and effects in one of their forms each. It holds no numbers; a fit finds them.

    Args:
        law: the static force law, or its name.
        effects: its effects: names, `name` or `name:form`, effects, or terms.
        free_geometry: whether radius and braid angle are fitted, and counted, too.
        terms: more terms.

    Raises:
        UsageError: for a name that is unknown, or an effect that is named twice.

    Example:
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> inputs = read_record(dataset_record("dmsp20_300")).inputs
        >>> model = Model.build("chou_hannaford", free_geometry=True)
        >>> print(model.names, model.force(inputs, {"r0": 10.0, "theta0": 25.0})[:2].round(1), "N")
        ('r0', 'theta0') [159.9 209.2] N
    """

    law: Law
    terms: tuple[Term, ...] = ()
    free_geometry: bool = False

    def __init__(
        self,
        law: Law | str,
        effects: "Sequence[str | Effect | Term] | str" = (),
        free_geometry: bool = False,
        *,
        terms: tuple[Term, ...] = (),
    ) -> None:
        if not isinstance(law, str | Law):
            raise UsageError(f"law {law!r}: expected a name, such as 'exponential_law', or a Law")
        given = (effects,) if isinstance(effects, str | Effect | Term) else effects
        object.__setattr__(self, "law", get_law(law) if isinstance(law, str) else law)
        object.__setattr__(self, "terms", (*map(as_term, given), *terms))
        object.__setattr__(self, "free_geometry", free_geometry)
        names = self.effect_names
        twice = {n for n in names if names.count(n) > 1}
        if twice:
            raise UsageError(f"effect {', '.join(sorted(twice))} named twice; name each effect once")

    @classmethod
    def build(
        cls, law: str, effects: tuple[str, ...] = (), extra: tuple[Effect, ...] = (), free_geometry: bool = False
    ) -> "Model":
        """A model from names.

        Args:
            law: name of a law of the catalogue.
            effects: names of effects, `name` or `name:form`.
            extra: effects of the user's own, which may be named too.
            free_geometry: whether radius and braid angle are fitted, too.

        Raises:
            UsageError: for a name that is unknown, or an effect that is named twice.

        Example:
            >>> from pam_ident.model import Model
            >>> print(Model.build("chou_hannaford", ("viscous_damping",)))
            chou_hannaford: F = π r0² p [a(1−ε)² − b],  a = 3/tan²θ0,  b = 1/sin²θ0
            + viscous_damping: −B ε̇ L0
        """
        return cls(law, tuple(as_term(name, extra) for name in effects), free_geometry)

    def __repr__(self) -> str:
        return f"Model {self}"

    def __str__(self) -> str:
        """The equation in text: the law's formula, and a line an effect."""
        effects = [f"+ {term.label}: {term.form.formula}" for term in self.terms]
        return "\n".join([f"{self.law.name}: {self.law.formula}", *effects])

    def adding(self, *terms: Term) -> "Model":
        """This model with more terms."""
        return replace(self, terms=self.terms + terms)

    @property
    def effect_names(self) -> list[str]:
        """Names of the effects, in order, without their forms."""
        return [term.effect.name for term in self.terms]

    @property
    def labels(self) -> list[str]:
        """Names of the effects with their forms."""
        return [term.label for term in self.terms]

    @property
    def own(self) -> tuple[Effect, ...]:
        """Its effects, which need not be the catalogue's."""
        return tuple(term.effect for term in self.terms)

    @property
    def words(self) -> str:
        """What a sentence calls it: `exponential law + creep and stress relaxation`."""
        return " + ".join([self.law.title, *(effect.title for effect in self.own)])

    @cached_property
    def linear(self) -> tuple[Param, ...]:
        """Parameters in which the force is linear while all others stay."""
        added = [t.qualified(t.form.linear) for t in self.terms if isinstance(t.form, AddsForce)]
        return sum(added, self.law.linear)

    @cached_property
    def nonlinear(self) -> tuple[Param, ...]:
        """The others: geometry, the law's and the forms' own, and the linear ones of what acts inside the law."""
        geometry = GEOMETRY if self.free_geometry else ()
        inside = [t.qualified(t.form.linear) for t in self.terms if not isinstance(t.form, AddsForce)]
        own = [t.qualified(t.form.nonlinear) for t in self.terms]
        return sum(inside + own, geometry + self.law.nonlinear)

    @property
    def params(self) -> tuple[Param, ...]:
        """All free parameters: linear, then nonlinear."""
        return self.linear + self.nonlinear

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all free parameters."""
        return tuple(p.name for p in self.params)

    @property
    def separable(self) -> bool:
        """Whether `design` is exact, that is, no effect depends on the force itself."""
        return not any(term.form.uses_force for term in self.terms)

    def neutral(self, inputs: Inputs) -> dict[str, float]:
        """Start values of all parameters, with the effects' linear ones where they vanish."""
        values = {p.name: p.start for p in self.params}
        for term in self.terms:
            values |= {p.name: p.neutral for p in term.qualified(term.form.linear)}
        if self.free_geometry:
            values |= {"r0": inputs.specimen.initial_radius_mm, "theta0": inputs.specimen.braid_angle_deg}
        return values

    def bounded(self, inputs: Inputs) -> tuple[Param, ...]:
        """All free parameters, linear then nonlinear, the radius within 15 % of the specimen's, and relaxation times
        within the record."""
        r0 = inputs.specimen.initial_radius_mm
        near = {"lower": 0.85 * r0, "upper": 1.15 * r0, "start": r0}
        return tuple(
            replace(p, **near) if p.name == "r0" else p.within(inputs.seconds, inputs.interval) for p in self.params
        )

    def to_lmfit(self, inputs: Inputs, rows: Array | None = None) -> "tuple[lmfit.Model, lmfit.Parameters]":
        """This model for lmfit: `model.fit(force[rows], parameters, inputs=inputs)`, force (n,) in N.

        `rows` (mask, shape (n,), default all) picks the samples to fit. A parameter `effect.name` is `effect__name` in
        lmfit; `fitting.from_lmfit` leads back. Bounds as here, starts off the bounds, where lmfit would stick. Raises
        UsageError for a name that could not come back.
        """
        import lmfit

        neutral = self.neutral(inputs)
        parameters = to_parameters((p, p.inside(neutral[p.name])) for p in self.bounded(inputs))

        def force(inputs: Inputs, **values: float) -> Array:
            found = self.force(inputs, from_lmfit_names(values))
            return found if rows is None else found[rows]

        names = [Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in ("inputs", *parameters)]
        force.__signature__ = Signature(names)  # pyright: ignore[reportFunctionMemberAccess]
        return lmfit.Model(force, independent_vars=["inputs"], name=self.law.name), parameters

    def design(self, inputs: Inputs, values: Values, force: Array) -> tuple[Array, Array]:
        """Columns (n, len(linear)) and fixed part (n,) in N, so that F = fixed + columns · linear.

        `values` needs the nonlinear parameters; `force` (n,) in N is what force-dependent effects are given.
        """
        inputs = self._geometry(inputs, values)
        xp = inputs.xp
        pressure, contraction = inputs.pressure, inputs.contraction
        factor: Array | None = None
        added: list[Array] = []
        for term in self.terms:
            if isinstance(term.form, TransformsPressure):
                pressure = pressure + term.amount(inputs, values, force)
            elif isinstance(term.form, TransformsContraction):
                contraction = contraction + term.amount(inputs, values, force)
            elif isinstance(term.form, ScalesForce):
                scale = 1.0 + term.amount(inputs, values, force)
                factor = scale if factor is None else factor * scale
            else:
                added.append(term.columns(inputs, values, force))
        # An effect may spend the pressure, but leaves no vacuum that was not measured.
        if pressure is not inputs.pressure:
            pressure = xp.maximum(pressure, xp.minimum(inputs.pressure, 0.0))
        if contraction is not inputs.contraction:
            contraction = xp.clip(contraction, -0.5, 0.95)
        columns = self.law.columns(pressure, contraction, inputs.specimen, values)
        fixed = self.law.fixed(pressure, contraction, inputs.specimen, values)
        if factor is not None:
            columns, fixed = columns * factor[:, None], fixed * factor
        return xp.hstack([columns, *added]) if added else columns, fixed

    def force(self, inputs: Inputs, values: Values, near: Array | None = None) -> Array:
        """Force in N, shape (n,); effects that depend on the force are solved for it, sample by sample.

        They are from `near` (n,), a force in N not far from it, sooner than from none.
        """
        linear = _vector(inputs, [values[p.name] for p in self.linear])

        def step(force: Array) -> Array:
            columns, fixed = self.design(inputs, values, force)
            return fixed + columns @ linear

        if self.separable or near is None:
            near = step(inputs.xp.zeros(len(inputs)))
        if self.separable:
            return near
        remembered = inputs.xp is np and any(term.form.uses_force and term.form.remembers for term in self.terms)
        return _solve_together(step, near) if remembered else _solve(step, near, ROUNDS)

    def step(self, inputs: Inputs, values: Values, memory: Memory | None) -> tuple[Array, Memory]:
        """Force in N, shape (n,), of n muscles side by side at one instant, and what they then remember.

        `memory` is that of the last accepted instant, or None at the first, where the muscles are at rest. Trial
        steps from the same instant may share it, for nothing is changed in place. All of it can be traced by JAX.
        Effects that depend on the force begin at the last one and are solved by a fixed number of rounds.
        """
        linear = _vector(inputs, [values[p.name] for p in self.linear])
        if memory is None:
            last, slots = inputs.xp.zeros(len(inputs)), None
        else:
            (last,), *slots = memory

        def at(force: Array) -> tuple[Array, Memory]:
            live = Live(slots)
            columns, fixed = self.design(replace(inputs, live=live), values, force)
            return fixed + columns @ linear, live.slots

        if not self.separable:
            last = _solve(lambda force: at(force)[0], last, START_ROUNDS if memory is None else LIVE_ROUNDS)
        force, found = at(last)
        return force, ((force,), *found)

    def _geometry(self, inputs: Inputs, values: Values) -> Inputs:
        return inputs.with_geometry(values["r0"], values["theta0"]) if self.free_geometry else inputs


def steps(models: Iterable[Model], say: Callable[[str, tuple[Effect, ...]], str] = in_words) -> tuple[str, ...]:
    """What each model has that the one before had not, a line each: the law's title first, then `+ effect`, as `say`
    calls it."""
    found: list[str] = []
    before: list[str] = []
    own: tuple[Effect, ...] = ()
    for model in models:
        new = [f"+ {say(label, model.own)}" for label in model.labels if label not in before]
        gone = [f"− {say(label, own)}" for label in sorted(set(before) - set(model.labels))]
        found.append("\n".join([model.law.title] * (not found) + new + gone) or "=")
        before, own = model.labels, model.own
    return tuple(found)


def _vector(inputs: Inputs, values: list[float]) -> Array:
    """Numbers, which may be traced, as an array of the kind of the inputs."""
    return inputs.xp.asarray(values, dtype=float)


def _solve(step: Callable[[Array], Array], force: Array, rounds: int) -> Array:
    """Force (n,) that `step` returns unchanged, each sample by Steffensen's iteration from `force`.

    Ends early where all have settled, except under JAX, which cannot know that while it traces.
    """
    xp = force.__array_namespace__()
    for _ in range(rounds):
        first = step(force)
        second = step(first)
        if xp is np:
            miss = float(np.max(np.abs(second - first)))
            if not miss > 1e-11 * (1.0 + float(np.max(np.abs(second)))):
                return second
        change = first - force
        moves = xp.abs(change) > 1e-12
        slope = xp.where(moves, (second - first) / xp.where(moves, change, 1.0), 0.0)
        force = first + (second - first) / (1.0 - xp.clip(slope, -20.0, 0.7))
    return force


def _solve_together(step: Callable[[Array], Array], force: Array) -> Array:
    """The same where a sample's force depends on those before it, too: by Anderson's iteration of all samples together
    (Walker & Ni 2011, SIAM J. Numer. Anal. 49, 1715–1735)."""
    found: list[Array] = []
    changes: list[Array] = []
    for _ in range(2 * ROUNDS):
        here = step(force)
        found, changes = [*found[-DEPTH:], here], [*changes[-DEPTH:], here - force]
        miss = float(np.max(np.abs(changes[-1])))
        if not (math.isfinite(miss) and miss > 1e-11 * (1.0 + float(np.max(np.abs(here))))):
            break
        force = here
        if len(found) > 1:
            apart = np.diff(changes, axis=0)
            share = np.linalg.lstsq(apart @ apart.T, apart @ changes[-1], rcond=1e-14)[0]
            force = force - share @ np.diff(found, axis=0)
    return found[-1]


DEPTH = 4
"""Rounds before the last that Anderson's iteration looks back on."""
ROUNDS = 12
START_ROUNDS = 4
LIVE_ROUNDS = 2
"""Rounds of the force's own iteration: over a record, at most; live, from no force, and from that an instant ago."""
GEOMETRY = (
    Param("r0", "mm", "initial radius of the braid", 0.5, 100.0, start=10.0, scale=1.0),
    Param("theta0", "deg", "initial braid angle", 20.0, 35.0, start=25.0, scale=1.0, symbol="θ0", grid=(23.0, 27.0)),
)
