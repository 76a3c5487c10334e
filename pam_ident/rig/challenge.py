"""Sealed challenge sets: many records with the answers kept apart in truth.json."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..core.progress import steps
from . import friction, memory
from .drives import DRIVES, PROTOCOLS
from .hidden import EFFECTS, UNKNOWNS, TooSmall
from .protocol import TooShort
from .record import Plan, RigRecord, Secret, make_record, write_case
from .sensors import FAULTS, GAUGES

EXPONENTIAL = (*friction.FORMS, *memory.FORMS)
# What each law leaves visible: the exponential law with free coefficients takes up most static effects.
VISIBLE = {
    "exponential_law": EXPONENTIAL,
    "modified_chou_hannaford": (*EXPONENTIAL, "bladder_elasticity", "threshold_pressure", "series_compliance"),
}
_FAMILIES = {
    "friction": ("coulomb_friction", "stribeck_friction", "pressure_friction", "presliding_hysteresis"),
    "rate": ("viscous_damping", "pressure_lag"),
    "ends": ("end_taper", "length_offset"),
}
FAMILY = {name: family for family, names in _FAMILIES.items() for name in names}
"""Effects of the same kind, between which a wrong name counts as right kind; others are a family of their own."""
SHARES = {"tier1": 0.25, "tier2": 0.25, "tier3": 0.10, "pair": 0.15, "null": 0.10, "unknown": 0.08, "blunt": 0.07}
SINGLE = {"tier1": 0.5, "tier2": 0.5}
"""What is asked where the catalogue lacks the hidden effect, or its form: one effect in white noise."""
WIDE_SHARES = {"tier1": 0.15, "tier2": 0.25, "tier3": 0.10, "pair": 0.10, "null": 0.20, "unknown": 0.20}
"""Of a set of all protocols, sensors and faults."""
COLOURED = ("ar1", "ou", "slow")
HARD = ("ar1", "ou", "slow", "pink", "heavy", "growing")
SHARP = (
    *("standard",) * 4,
    "other_speeds",
    "four_speeds",
    "slow_to_fast",
    "six_pressures",
    "four_pressures",
    "long_holds",
)
WIDE = tuple(name for name in PROTOCOLS if name != "blunt")
SETS = {
    "plain": SHARP,
    "all": WIDE,
    **{drive.kind: tuple(d for d in DRIVES if DRIVES[d].kind == drive.kind) for drive in DRIVES.values()},
}
"""Protocols that a set is drawn from; those but the plain ones have all sensors and faults."""
DRY = ("coulomb_friction", "pressure_friction")
STICKING = {f"{name}/sticking" for name in DRY}
HIDES = {
    "isometric": {
        *STICKING,
        *("stribeck_friction", "coulomb_friction/tanh", "dynamics"),
        *(f"screw_ripple/{form}" for form in ("textbook", "loaded", "harmonics")),
        *(f"rub/{form}" for form in UNKNOWNS["rub"] if form != "leaned_on"),
    },
    "isotonic": {
        *(f"{name}/{form}" for name in DRY for form in EFFECTS[name]),
        *("stribeck_friction", "dynamics", "rub/fold"),
    }.difference(STICKING),
}
"""What a kind of test does not show, or the rig cannot make there: a locked braid slides too little for a fall with
speed, and where friction is dry a weight sticks, and nothing else does."""
RATIO = (0.7, 6.0)


def _rounds(items: list[tuple[str, str]], rng: np.random.Generator) -> Iterator[tuple[str, str]]:
    """Endless rounds through all items, shuffled anew each round, so that small sets stay even."""
    while True:
        yield from (items[i] for i in rng.permutation(len(items)))


def _ratio(rng: np.random.Generator, low: float = RATIO[0]) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(RATIO[1]))))


def _forms(name: str, driven: str) -> list[str]:
    """Forms of an effect that a kind of test shows."""
    hidden = HIDES.get(driven, STICKING)
    forms = {**EFFECTS, **UNKNOWNS}.get(name, {})
    return [form for form in forms if name not in hidden and f"{name}/{form}" not in hidden]


def _secret(name: str, driven: str, textbook: bool, rng: np.random.Generator) -> Secret:
    forms = _forms(name, driven)
    others = [f for f in forms if f != "textbook"]
    if textbook or not others:
        return Secret(name, "textbook" if "textbook" in forms else others[0], _ratio(rng))
    return Secret(name, str(rng.choice(others)), _ratio(rng))


class _Drawer:
    """Draws plans of each kind from one stream."""

    def __init__(self, seed: int, protocols: str = "plain") -> None:
        self.protocols, self.wide = SETS[protocols], protocols != "plain"
        known = [unknown for unknown in UNKNOWNS if self.wide or unknown != "dynamics"]
        self.seed, self.rng, self.made, self.nulls = seed, np.random.default_rng([seed, 77]), 0, 0
        subjects = [(law, name) for law, names in VISIBLE.items() for name in names]
        self.subjects = {kind: _rounds(subjects, self.rng) for kind in ("tier1", "tier2", "tier3", "pair")}
        self.subjects["unknown"] = _rounds([(law, u) for law in VISIBLE for u in known], self.rng)
        rubs = ("coulomb_friction", "viscous_damping")
        self.subjects["blunt"] = _rounds([(law, e) for law in VISIBLE for e in rubs], self.rng)
        self.subjects["null"] = _rounds([(law, "") for law in VISIBLE], self.rng)
        self.kinds: dict[str, Callable[[Plan, str], Plan]] = {
            "tier1": lambda p, e: replace(p, secrets=(_secret(e, p.driven.kind, True, self.rng),)),
            "tier2": lambda p, e: replace(p, secrets=(_secret(e, p.driven.kind, False, self.rng),), tier=2),
            "tier3": self._coloured,
            "pair": self._pair,
            "null": self._null,
            "unknown": self._unknown,
            "blunt": lambda p, e: replace(p, secrets=(_secret(e, "isobaric", True, self.rng),), protocol="blunt"),
        }

    def plan(self, kind: str) -> Plan:
        """The next plan of a kind."""
        law, effect = next(self.subjects[kind])
        self.made += 1
        rng = self.rng
        showing = [name for name in self.protocols if not effect or _forms(effect, PROTOCOLS[name].kind)]
        if not showing:
            return self.plan(kind)
        plan = Plan(
            seed=self.seed * 100_000 + self.made,
            law=law,
            protocol=str(rng.choice(showing)),
            sigma_N=float(rng.choice([1.0, 2.0, 4.0])),
            warming=bool(rng.random() < 0.5),
            other_specimen=bool(rng.random() < 0.4),
        )
        if self.wide:
            gauges = str(rng.choice(list(GAUGES), p=(0.6, 0.2, 0.2)))
            fault = str(rng.choice(list(FAULTS))) if rng.random() < 0.4 else None
            plan = replace(plan, gauges=gauges, fault=fault)
        if plan.fault == "clipped" and plan.driven.kind == "isotonic":
            plan = replace(plan, fault=None)  # a weight beyond the load cell is not known
        plan = self.kinds[kind](plan, effect)
        if any(s.name == "thermal_softening" for s in plan.secrets):
            plan = replace(plan, warming=True)
        return plan

    def _coloured(self, plan: Plan, effect: str) -> Plan:
        textbook = bool(self.rng.random() < 0.5)
        secrets = (_secret(effect, plan.driven.kind, textbook, self.rng),)
        return replace(plan, secrets=secrets, tier=3, noise=str(self.rng.choice(COLOURED)))

    def _pair(self, plan: Plan, effect: str) -> Plan:
        shown = [e for e in VISIBLE[plan.law] if _forms(e, plan.driven.kind)]
        others = [e for e in shown if FAMILY.get(e, e) != FAMILY.get(effect, effect)]
        textbook = bool(self.rng.random() < 0.5)
        names = (effect, str(self.rng.choice(others)))
        secrets = tuple(_secret(n, plan.driven.kind, textbook, self.rng) for n in names)
        return replace(plan, secrets=secrets, tier=1 if textbook else 2)

    def _null(self, plan: Plan, effect: str) -> Plan:
        self.nulls += 1
        coloured = self.wide or self.nulls % 2 == 0
        noise = str(self.rng.choice(HARD if self.wide else COLOURED)) if coloured else "white"
        return replace(plan, noise=noise, tier=3 if coloured else 1)

    def _unknown(self, plan: Plan, effect: str) -> Plan:
        form = str(self.rng.choice(_forms(effect, plan.driven.kind)))
        return replace(plan, unknown=Secret(effect, form, _ratio(self.rng, 1.0)), tier=1 if form == "textbook" else 2)


def quotas(n: int, only: str | None = None, shares: Mapping[str, float] = SHARES) -> list[str]:
    """Kinds of n cases by the largest remainders of `shares`, or all of one kind."""
    if n < 1:
        raise ValueError(f"n = {n}: a set needs a case")
    if only is not None:
        if only not in SHARES:
            raise ValueError(f"only {only!r}: one of {', '.join(SHARES)}")
        return [only] * n
    counts = {k: int(n * s) for k, s in shares.items()}
    for kind in sorted(shares, key=lambda k: counts[k] - n * shares[k])[: n - sum(counts.values())]:
        counts[kind] += 1
    return [k for k, c in counts.items() for _ in range(c)]


def make_challenge(
    folder: str | Path,
    n: int = 60,
    seed: int = 1,
    only: str | None = None,
    left_out: Callable[[Path, RigRecord], Sequence[str]] | None = None,
    protocols: str = "plain",
) -> list[dict[str, object]]:
    """Writes n cases cNNN into a folder, questions.json (case and law of each) and truth.json; returns the truth.

    A draw whose effect cannot be as large as asked, or whose muscle is too short for the test, is drawn anew.
    `left_out` says, by a case's folder and record, which effects or forms its question forbids; there each case hides
    one effect. `protocols` is one of SETS.
    """
    if protocols not in SETS:
        raise ValueError(f"protocols {protocols!r}: one of {', '.join(SETS)}")
    folder = Path(folder)
    drawer = _Drawer(seed, protocols)
    kinds = quotas(n, only, SINGLE if left_out is not None else WIDE_SHARES if drawer.wide else SHARES)
    truth: list[dict[str, object]] = []
    for i, at in enumerate(steps(drawer.rng.permutation(n), "writing cases")):
        kind = kinds[at]
        while True:
            plan = drawer.plan(kind)
            with suppress(TooSmall, TooShort):
                record = make_record(plan)
                break
        case = folder / f"c{i:03d}"
        truth.append(write_case(case, record))
        if left_out is not None:
            truth[-1]["without"] = list(left_out(case, record))
    questions = [{key: one[key] for key in ("case", "law", "without") if key in one} for one in truth]
    (folder / "questions.json").write_text(json.dumps(questions, indent=1) + "\n", encoding="utf-8")
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    return truth
