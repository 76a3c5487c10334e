"""Answers to a sealed set against its truth: what counts as right, as exact, and what was taken for what.

An answer is the JSON of `diagnose`; a line of the truth is as `rig.write_case` returns it.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from ..rig.challenge import FAMILY

Json = Mapping[str, Any]
NOTHING, UNKNOWN, REFUSED = "nothing", "unknown", "refused"
KINDS = {
    "tier1": "textbook form",
    "tier2": "another form",
    "tier3": "coloured noise",
    "pair": "two effects",
    "null": "nothing hidden",
    "unknown": "outside the catalogue",
    "blunt": "one speed only",
    "held out": "left out of the catalogue",
}
PATTERN = {"screw_ripple": "periodic", "rub": "local", "mount_slip": "step", "wandering_sensor": "trend"}
CROWD = 4
"""A group of more names than this is no answer."""


@dataclass(frozen=True)
class Score:
    """How one case was answered.

    `right`: the first name, or one it is grouped with, is hidden there; both names of two; the verdict where nothing
    or something unknown is hidden, or an effect that the question left out; the group of friction and damping in a
    record of one speed; a refusal is no answer. `exact`: no other family is named besides; no other effect besides two;
    the unknown's kind; no name beside what was left out; the test that splits the group. `grouped`: right, if each
    name stands for its whole group. `removed` is the share of the removable squared error that was removed, None where
    nothing known is hidden.
    `statements` are probabilities with whether they were true.
    """

    case: str
    kind: str
    right: bool
    exact: bool
    grouped: bool
    removed: float | None
    hidden: tuple[str, ...]
    named: tuple[str, ...]
    confused: tuple[tuple[str, str], ...]
    statements: tuple[tuple[float, bool], ...]


@dataclass(frozen=True)
class Tally:
    """Cases of one kind: how many, how many of them right, exact, right by groups, and the error removed."""

    kind: str
    n: int
    right: int
    exact: int
    grouped: int
    removed_median: float | None
    removed_worst: float | None


def family(name: str) -> str:
    """The family of an effect."""
    return FAMILY.get(name, name)


def kind_of(truth: Json) -> str:
    """The kind of a case, by what is hidden in it."""
    if truth["unknown"]:
        return "unknown"
    if any(name in truth["truth"] for name in truth.get("without", ())):
        return "held out"
    if not truth["truth"]:
        return "null"
    if truth["blunt"]:
        return "blunt"
    return "pair" if len(truth["truth"]) > 1 else f"tier{truth['tier']}"


def score(truth: Json, answer: Json) -> Score:
    """One answer against the truth."""
    kind, hidden, named = kind_of(truth), set(truth["truth"]), list(answer.get("selected") or [])
    refused = "rmse_N" in answer and answer["rmse_N"] is None
    groups = [set(group) for group in answer.get("groups") or []]
    covered = [_group(name, groups) for name in named]
    each = all(any(name in group for group in covered) for name in hidden)
    if kind == "null":
        right = exact = answer["verdict"] == "adequate"
    elif kind == "unknown":
        right = answer["verdict"] == "unknown_effect"
        expected = PATTERN.get(truth["unknown"])
        exact = right and expected in (None, (answer.get("pattern") or {}).get("kind"))
    elif kind == "held out":
        right = answer["verdict"] == "unknown_effect"
        exact = right and not named
    elif kind == "blunt":
        both = {"coulomb_friction", "viscous_damping"}
        right = answer["verdict"] == "missing_effect" and any(both <= group for group in groups)
        exact = right and "speed" in ((answer.get("next_experiment") or {}).get("vary") or [])
    elif kind == "pair":
        right, exact = hidden <= set(named), hidden == set(named)
    else:
        first = covered[0] if covered else set()
        right = bool(first & hidden) and len(first) <= CROWD
        exact = right and {family(n) for n in named} == {family(n) for n in hidden}
    if refused:
        right = exact = False
    return Score(
        str(truth["case"]),
        kind,
        right,
        exact,
        right or (kind == "pair" and each),
        _removed(truth, answer),
        (*sorted(hidden), *([truth["unknown"]] if truth["unknown"] else [])),
        (*named, *([REFUSED] if refused else [UNKNOWN] if answer["verdict"] == "unknown_effect" else [])),
        _confused(truth, answer, covered),
        _statements(hidden, answer, groups),
    )


def _group(name: str, groups: Iterable[set[str]]) -> set[str]:
    """A name with all that an answer groups it with."""
    return {name}.union(*(group for group in groups if name in group))


def _removed(truth: Json, answer: Json) -> float | None:
    noise = float(truth["noise_rms"]) ** 2
    removable, after = float(truth["rmse_base"]) ** 2 - noise, answer.get("rmse_after_N")
    if not truth["truth"] or removable <= 0 or after is None:
        return None
    return 1.0 - max(0.0, float(after) ** 2 - noise) / removable


def _confused(truth: Json, answer: Json, covered: Sequence[set[str]]) -> tuple[tuple[str, str], ...]:
    """Pairs of hidden and named family: each with itself where it was found, else with what was named in its place."""
    hidden = {family(name) for name in truth["truth"]} | ({UNKNOWN} if truth["unknown"] else set())
    named = {UNKNOWN} if answer["verdict"] == "unknown_effect" else set()
    for group in covered:
        meant = group & set(truth["truth"])
        named |= {family(name) for name in meant or [next(n for n in answer["selected"] if n in group)]}
    pairs = [(one, one) for one in sorted(hidden & named)]
    missed, extra = sorted(hidden - named), sorted(named - hidden)
    pairs += [(one, other) for one in missed for other in extra or [NOTHING]]
    pairs += [(NOTHING, other) for other in extra if not missed]
    return tuple(pairs or [(NOTHING, NOTHING)])


def _statements(hidden: set[str], answer: Json, groups: Sequence[set[str]]) -> tuple[tuple[float, bool], ...]:
    """A statement for each candidate; those of a group are one, with the largest of their probabilities."""
    stated: dict[frozenset[str], float] = {}
    for one in answer.get("ranking") or []:
        if one.get("status") == "candidate" and one.get("probability") is not None:
            members = frozenset(_group(one["effect"], groups))
            stated[members] = max(stated.get(members, 0.0), float(one["probability"]))
    return tuple((p, bool(members & hidden)) for members, p in stated.items())


def tally(scores: Sequence[Score]) -> tuple[Tally, ...]:
    """A line for each kind that occurs, in the order of KINDS, and one for all."""
    lines = []
    for kind in [*KINDS, "all"]:
        own = [s for s in scores if kind in (s.kind, "all")]
        removed = [s.removed for s in own if s.removed is not None]
        if own:
            right, exact, grouped = (sum(getattr(s, how) for s in own) for how in ("right", "exact", "grouped"))
            middle = median(removed) if removed else None
            lines.append(Tally(kind, len(own), right, exact, grouped, middle, min(removed, default=None)))
    return tuple(lines)


def confusion(scores: Iterable[Score]) -> dict[tuple[str, str], int]:
    """How often a hidden family (or nothing, or an unknown) was answered with a named one."""
    return dict(Counter(pair for s in scores for pair in s.confused))
