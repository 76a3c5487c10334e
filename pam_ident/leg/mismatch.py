"""What a plant is off from what its controller knows."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..effects import Effect
from ..model import Model, Term, as_term
from .anatomy import Leg, Segment
from .muscle import Muscle
from .pair import Pair
from .pneumatics import ATMOSPHERE


@dataclass(frozen=True)
class Mismatch:
    """Shares that the plant has of what is known: `force` of flexor and extensor, `mass` of shank, foot and load,
    `supply` of the supply's gauge pressure. A muscle loses the share `ageing` of its force with each stride. The
    plant's muscles have the effect `unknown` besides, `size` times its typical one."""

    force: tuple[float, float] = (1.0, 1.0)
    mass: float = 1.0
    supply: float = 1.0
    ageing: float = 0.0
    unknown: Term | None = None
    size: float = 1.0

    @classmethod
    def of(cls, table: Mapping[str, Any], extra: tuple[Effect, ...] = ()) -> "Mismatch":
        """From the table [off] of a leg's file. Raises UsageError for an effect that nobody knows."""
        unknown = as_term(table["unknown"], extra) if table["unknown"] else None
        return cls(**{**table, "force": tuple(table["force"]), "unknown": unknown})

    def plant(self, known: Pair, cadence_Hz: float) -> Pair:
        """The pair that the plant is, where the controller knows `known`. Raises UsageError for an effect that the
        muscle has already."""
        gauge = known.supply.pressure_Pa - ATMOSPHERE
        return replace(
            known,
            muscle=_besides(known.muscle, self.unknown, self.size) if self.unknown else known.muscle,
            leg=_heavier(known.leg, self.mass),
            supply=replace(known.supply, pressure_Pa=self.supply * gauge + ATMOSPHERE),
            strength=self.force,
            ageing_per_s=-math.log1p(-self.ageing) * cadence_Hz,
        )

    def __str__(self) -> str:
        """What is off, in words; empty where nothing is."""
        flexor, extensor = self.force
        shares = {"flexor's force": flexor, "extensor's": extensor, "mass": self.mass, "supply": self.supply}
        words = [f"{name} {100.0 * (share - 1.0):+.3g} %" for name, share in shares.items() if share != 1.0]
        words += [f"force {-100.0 * self.ageing:.3g} % with each stride"] if self.ageing else []
        return ", ".join([*words, *([self.unknown.label] if self.unknown else [])])


AS_KNOWN = Mismatch()


def _besides(muscle: Muscle, term: Term, size: float) -> Muscle:
    sizes = {p.name: p.clip(p.neutral + size * p.scale) for p in term.form.linear}
    added = {f"{term.effect.name}.{p.name}": sizes.get(p.name, p.start) for p in term.form.params}
    model = Model(muscle.model.law, muscle.model.terms, muscle.model.free_geometry, terms=(term,))
    contraction, extension = ({**one, **added} for one in (muscle.contraction, muscle.extension))
    return Muscle(model, muscle.specimen, contraction, extension, seen=muscle.seen)


def _heavier(leg: Leg, share: float) -> Leg:
    def one(segment: Segment) -> Segment:
        return replace(segment, mass_kg=share * segment.mass_kg, inertia_kg_m2=share * segment.inertia_kg_m2)

    return replace(leg, shank=one(leg.shank), foot=one(leg.foot), load_mass_kg=share * leg.load_mass_kg)
