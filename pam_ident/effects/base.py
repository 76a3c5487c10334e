"""What an effect is: a name with forms from simplest to richest, each with its role by type."""

import math
from abc import ABC
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..core import Inputs, Param, UsageError
from ..core.shown import Shown

Array = np.ndarray
Values = Mapping[str, float]
Columns = Callable[[Inputs, Values, Array], Array]
"""(inputs, values of the nonlinear parameters, force of the model in N, shape (n,)) → shape (n, linear parameters)."""


MOST = 200.0
"""Usual sizes that a free coefficient may have: of what the record hardly shows it would be without end."""
MOST_MPA, MOST_CONTRACTION = 0.8, 0.35
"""Ends of the surfaces of what resists: the pressure and the contraction that muscles reach."""


@dataclass(frozen=True)
class Form(ABC):
    """One way to write an effect down: its linear and its nonlinear parameters, and the columns.

    What `columns` · (linear parameters − their neutral values) does is the form's role, told by its type.
    `uses_force` marks columns that depend on the force itself, so that the model is solved implicitly; `remembers`
    those that depend on what lies between the record's first sample and their own, which cannot be read in pieces.
    `needs` names what a record must hold, beyond what the effect needs, for the form to say more than another.
    `same_as` is another effect, which the formula holds as well: no record tells by this form which of them it is.
    """

    name: str
    formula: str
    linear: tuple[Param, ...]
    columns: Columns
    nonlinear: tuple[Param, ...] = ()
    uses_force: bool = False
    remembers: bool = False
    needs: tuple[str, ...] = ()
    same_as: str = ""

    @property
    def free(self) -> bool:
        """Whether its dependence on pressure and contraction is left free."""
        return self.name.startswith("free")

    @property
    def params(self) -> tuple[Param, ...]:
        """Linear, then nonlinear."""
        return self.linear + self.nonlinear


@dataclass(frozen=True)
class AddsForce(Form):
    """columns · linear is a force in N, added to the law's."""


@dataclass(frozen=True)
class ScalesForce(Form):
    """The law's force is multiplied by 1 + columns · linear."""


@dataclass(frozen=True)
class TransformsPressure(Form):
    """The law is given p + columns · linear, in MPa, never below zero."""


@dataclass(frozen=True)
class TransformsContraction(Form):
    """The law is given ε + columns · (linear − neutral)."""


@dataclass(frozen=True, repr=False)
class Effect(Shown):
    """A physical effect that a static law leaves out; its forms go from the simplest to the richest.

    `needs` names what a record must hold (branch, motion, time, cycle, temperature); `levers` what must be
    varied on the rig to see it, in the words of the contract; `special_case_of` the effect one of whose richer
    forms is the same physics, and whose name is preferred where both explain a record alike; `own` the size that makes
    it what it is, where forms have others, too; `alike` a group of which a model takes one, if that is another.
    `follows` says what its force follows, in the words of `diagnosis.follows`: it is named only where the error follows
    one of these; an effect that says nothing may follow anything.
    `candidate` False keeps an effect out of the diagnosis. `simplest` is the form that goes by the effect's name: the
    first, where nothing is said. Raises UsageError without a form or a source.
    """

    name: str
    title: str
    source: str
    forms: tuple[Form, ...]
    test: str
    needs: tuple[str, ...] = ()
    levers: tuple[str, ...] = ()
    follows: tuple[str, ...] = ()
    special_case_of: str = ""
    own: str = ""
    alike: str = ""
    candidate: bool = True
    warning: str = ""
    simplest: str = ""

    def __post_init__(self) -> None:
        if not self.forms or not self.source or not self.name.isidentifier():
            raise UsageError(f"effect {self.name!r}: expected a Python name, at least one form and a source")
        if any(type(form) is Form for form in self.forms):
            raise UsageError(
                f"effect {self.name}: write each form as AddsForce, ScalesForce, TransformsPressure "
                "or TransformsContraction"
            )

        object.__setattr__(self, "simplest", self.simplest or self.forms[0].name)

    def __repr__(self) -> str:
        first, *others = self.forms
        lists = {"other forms": [form.name for form in others], "needs in the record": self.needs}
        more = [f"  {words}: {', '.join(names)}" for words, names in lists.items() if names]
        return "\n".join([f"{self.name}: {self.title}", f"  {first.formula}", *more, f"  source: {self.source}"])

    @property
    def exclusion_group(self) -> str:
        """What it is `alike`, a special case of, or itself: of one such group a model takes one."""
        return self.alike or self.special_case_of or self.name

    @property
    def written(self) -> tuple[Form, ...]:
        """The forms that are not free."""
        return tuple(form for form in self.forms if not form.free)

    def shown_by(self, inputs: Inputs) -> "Effect":
        """The effect in the forms that a record holds enough for: a table has too few rows for those that are free."""
        known = self.written if inputs.time is None and self.written else self.forms
        forms = tuple(form for form in known if all(inputs.has(need) for need in form.needs))
        return self if forms == self.forms else replace(self, forms=forms)

    @property
    def static(self) -> bool:
        """Whether it follows pressure and contraction alone."""
        return self.follows == ("map",)

    def missing(self, inputs: Inputs) -> list[str]:
        """What the record lacks for this effect to be computed at all."""
        return [need for need in self.needs if not inputs.has(need)]


def free_form(
    text: str,
    states: Columns,
    count: int = 1,
    pressure: int = 1,
    contraction: int = 3,
    nonlinear: tuple[Param, ...] = (),
    role: type[Form] = AddsForce,
    unit: tuple[str, float] = ("N", 10.0),
    remembers: bool = False,
    name: str = "free",
    uses_force: bool = False,
    lower: float = -math.inf,
    upper: float = math.inf,
    resisting: int = 0,
    needs: tuple[str, ...] = (),
) -> Form:
    """What the force follows, `states` (n, count), times a smooth surface whose coefficients are free: a name rests on
    this where no written form has the right dependence on pressure and contraction.

    `pressure` and `contraction` are the surface's orders; `text` says the states in the formula, `unit` that of the
    coefficients with their usual size, `lower` and `upper` what nature holds them to. The first `resisting` states
    resist everywhere: their surfaces are of Bernstein polynomials, with coefficients above 0.
    """
    orders = [(i, j) for i in range(pressure + 1) for j in range(contraction + 1)]
    linear = tuple(
        Param(
            f"f_{k}{i}{j}",
            unit[0],
            f"of state {k + 1}, " + (f"B_{i}(p) B_{j}(ε)" if k < resisting else f"(p/0.3 MPa)^{i} (ε/0.1)^{j}"),
            0.0 if k < resisting else max(lower, -MOST * unit[1]),
            min(upper, MOST * unit[1]),
            scale=unit[1],
        )
        for k in range(count)
        for i, j in orders
    )

    def surface(inputs: Inputs, resists: bool) -> Array:
        if resists:
            xp = inputs.xp
            p = xp.clip(inputs.pressure / MOST_MPA, 0.0, 1.0)
            e = xp.clip(inputs.contraction / MOST_CONTRACTION, 0.0, 1.0)
            return xp.stack([bernstein(p, i, pressure) * bernstein(e, j, contraction) for i, j in orders]).T
        p, e = inputs.pressure / 0.3, inputs.contraction / 0.1
        return inputs.xp.stack([p**i * e**j for i, j in orders]).T

    def columns(inputs: Inputs, values: Values, force: Array) -> Array:
        found = states(inputs, values, force)
        kinds = [k < resisting for k in range(count)]
        surfaces = {kind: surface(inputs, kind) for kind in set(kinds)}
        return inputs.xp.concat([found[:, k, None] * surfaces[kind] for k, kind in enumerate(kinds)], axis=1)

    formula = f"{text} · Σ f_ij " + ("B_i(p) B_j(ε)" if resisting else "(p/0.3 MPa)^i (ε/0.1)^j")
    return role(name, formula, linear, columns, nonlinear, uses_force, remembers, needs)


def keeping_no_more(columns: Columns) -> Columns:
    """From columns of motion and then as many of holds: what holds keep, in motion too, and what motion has beyond it.

    With coefficients above 0 friction keeps no more in a hold than it had.
    """

    def found(inputs: Inputs, values: Values, force: Array) -> Array:
        both = columns(inputs, values, force)
        moving, held = both[:, : both.shape[1] // 2], both[:, both.shape[1] // 2 :]
        return inputs.xp.concat([moving + held, moving], axis=1)

    return found


def bernstein(t: Array, k: int, order: int) -> Array:
    """Bernstein polynomial k of an order, at t (n,), which is above 0 from 0 to 1."""
    return math.comb(order, k) * t**k * (1.0 - t) ** (order - k)


def one(values: Array) -> Array:
    """A single column, shape (n, 1)."""
    return values.__array_namespace__().asarray(values, dtype=float)[:, None]


def with_pressure(column: Array, inputs: Inputs) -> Array:
    """A column (n, 1) by itself and in proportion to pressure, shape (n, 2)."""
    return column * inputs.xp.stack([inputs.xp.ones_like(inputs.pressure), inputs.pressure]).T


def slip(inputs: Inputs) -> tuple[Array, Array]:
    """Sign of sliding where the muscle moves (0 in holds), and the one kept through holds (0 in motion), shape (n,)."""
    if inputs.moving is None:
        return inputs.direction, inputs.xp.zeros(len(inputs))
    return inputs.direction * inputs.moving, inputs.direction * ~inputs.moving


def bladder_area(inputs: Inputs) -> Array:
    """Area of the bladder's cylinder over its area at rest, shape (n,)."""
    return inputs.specimen.radius_ratio(inputs.contraction) * (1.0 - inputs.contraction)


def speed(inputs: Inputs) -> Array:
    """|dx/dt| in mm/s, shape (n,)."""
    assert inputs.velocity is not None
    return inputs.xp.abs(inputs.velocity)
