"""From names and objects to what a task is asked."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..core import UsageError
from ..effects import Effect, load_effect_files
from ..laws import Law, get_law
from ..model import Model, Term, as_term
from ..records import Record
from ..tasks.gate import check_codes
from ..tasks.law_choice import LawChoice, settle
from ..tasks.setup import AUTO, Setup, check_heldout


@dataclass(frozen=True)
class ObjectSetup(Setup):
    """A setup that holds objects beside names: effects of the user's own, and a law that no catalogue has."""

    objects: tuple[Effect, ...] = ()
    own_law: Law | None = None

    @cached_property
    def extra(self) -> tuple[Effect, ...]:
        """The effects that are given as objects or in files."""
        return (*load_effect_files(self.effect_files), *self.objects)

    @cached_property
    def model(self) -> Model:
        """The law with its effects. Raises UsageError for an unknown name."""
        return Model(self._law, [as_term(name, self.extra) for name in self.effects], self.free_geometry)

    @cached_property
    def law_alone(self) -> Model:
        """The law without effects."""
        return Model(self._law, (), self.free_geometry)

    @property
    def _law(self) -> Law | str:
        return self.own_law if self.own_law is not None and self.own_law.name == self.law else self.law


def setup_of(
    law: "str | Law | Model" = AUTO,
    effects: "str | Effect | Term | Iterable[str | Effect | Term]" = (),
    *,
    free_geometry: bool = False,
    without: Any = (),
    only: Any = (),
    also: Any = (),
    extra: Iterable[Effect] = (),
    assume: "str | Iterable[str]" = (),
    prior: str | None = None,
    heldout: str = "",
) -> ObjectSetup:
    """What is asked, checked at once; `extra` are effects that may be named, `assume` codes of grave doubts
    that are meant so, `heldout` what is held out whole while everything is chosen anew.

    Raises UsageError for a name, a code or a word that nobody knows, or something else than a name.
    """
    if effects is not None and not isinstance(effects, str | Effect | Term | Iterable):
        raise UsageError(f"effects {effects!r}: expected names, such as 'creep', or Effects")
    given = [effects] if isinstance(effects, str | Effect | Term) else list(effects or ())
    own = None
    if isinstance(law, Model):
        given = [*law.terms, *given]
        free_geometry = free_geometry or law.free_geometry
        law = law.law
    if isinstance(law, Law):
        own, law = law, law.name
    elif not isinstance(law, str):
        shown = " ".join(repr(law).split())[:60]
        raise UsageError(
            f"law {shown}: expected a name, such as 'exponential_law', a Law or a Model, behind the record: "
            "pam.fit(record, law)"
        )
    elif law != AUTO:
        get_law(law)
    more = (extra,) if isinstance(extra, Effect) else tuple(extra)
    terms = [as_term(one, more) if not isinstance(one, str) or more else one for one in given]
    labels = tuple(one if isinstance(one, str) else one.label for one in terms)
    own_effects = [*more, *(one.effect for one in terms if isinstance(one, Term))]
    objects = tuple({one.name: one for one in own_effects}.values())
    found = ObjectSetup(
        law,
        labels,
        free_geometry=free_geometry,
        without=_names(without),
        only=_names(only),
        also=_names(also),
        prior=prior,
        assume=codes(assume),
        heldout=heldout,
        objects=objects,
        own_law=own,
    )
    if heldout:
        check_heldout(heldout)
    found.check()
    return found


def _names(given: Any) -> tuple[str, ...]:
    every = [given] if isinstance(given, str | Effect) else given or ()
    return tuple(one.name if isinstance(one, Effect) else str(one) for one in every)


def codes(assume: str | Iterable[str]) -> tuple[str, ...]:
    """Codes of doubts, one or several. Raises UsageError for one that no doubt has."""
    found = _names(assume)
    check_codes(found)
    return found


def settled(record: Record, setup: ObjectSetup, naming: bool = False) -> tuple[ObjectSetup, LawChoice | None]:
    """With a law in place of `auto`, and how it was chosen. Raises as `settle` does."""
    found, choice = settle(record, setup, naming)
    assert isinstance(found, ObjectSetup)
    return found, choice
