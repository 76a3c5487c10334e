"""Every law, and every form of every effect in a law, asked at 10,000 samples."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pam_ident.core import Inputs, Specimen
from pam_ident.core.recursion import Live
from pam_ident.effects import catalogue as effects
from pam_ident.export.fitted import Fitted, Parameter, Span
from pam_ident.laws import catalogue as laws
from pam_ident.model import Model
from pam_ident.validation.effect_contract import LAW_VALUES, model_of, plausible

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)
RICH = (
    "coulomb_friction:stribeck",
    "presliding_hysteresis",
    "creep:prony_3",
    "pressure_lag:lagging",
    "end_taper",
    "thermal_softening",
    "series_compliance",
)
TRACKS, LENGTH = 5, 2000
"""Muscles side by side, and samples of each."""


@dataclass(frozen=True)
class Case:
    """A model with parameter values by branch."""

    name: str
    model: Model
    branches: dict[str, dict[str, float]]

    @property
    def fitted(self) -> Fitted:
        branches = {
            branch: tuple(Parameter(p.name, values[p.name], math.nan, p.unit, p.doc) for p in self.model.params)
            for branch, values in self.branches.items()
        }
        span = Span((0.0, 0.7), (-0.02, 0.3))
        return Fitted(self.model, MUSCLE, branches, "made", dict.fromkeys(branches, 1.0), span)

    @property
    def remembers(self) -> bool:
        live = Live(None)
        one = replace(samples().take(slice(1)), live=live)
        self.model.design(one, next(iter(self.branches.values())), np.zeros(1))
        return bool(live.slots)


def samples() -> Inputs:
    """Muscles that go to and fro and are held now and then, while pressure and temperature wander, one track after the
    other."""
    rng = np.random.default_rng(7)
    rows = []
    for _ in range(TRACKS):
        time = 100.0 * rng.uniform() + np.cumsum(rng.uniform(0.002, 0.08, LENGTH))
        ends = []
        for turn in range(LENGTH // 40 + 1):
            end = rng.uniform(20.0, 55.0) if turn % 2 else rng.uniform(-3.0, 15.0)
            ends += [end, end] if rng.uniform() < 0.3 else [end]
        k = np.arange(LENGTH)
        x = np.interp(k, 40 * np.arange(len(ends)), ends)
        v = np.r_[0.0, np.diff(x) / np.diff(time)]
        held = (v == 0.0) & (k > 0)
        direction = np.sign(v[np.maximum.accumulate(np.where(held, 0, k))])
        p = 0.36 + 0.34 * np.sin(k * rng.uniform(0.01, 0.1))
        temperature = 22.0 + 6.0 * np.sin(time / 20.0) + rng.uniform(-3.0, 3.0)
        pace = pace_of_strokes(time, v, held, direction)
        rows.append((p, x / 200.0, v, direction, time, 1.0 + k // 80, temperature, held, pace))
    p, e, v, direction, time, cycle, temperature, held, pace = np.concatenate(rows, axis=1)
    return Inputs(p, e, MUSCLE, direction, time, v, pace, held == 0.0, cycle, temperature, np.zeros(len(p), int))


def pace_of_strokes(time, v, held, direction) -> np.ndarray:
    """|v| in motion, in a hold the mean speed of the stroke before it, (n,)."""
    pace, way, lasted = np.abs(v), 0.0, 0.0
    for k in range(1, len(v)):
        if direction[k] * direction[k - 1] < 0.0:
            way, lasted = 0.0, 0.0
        if held[k]:
            pace[k] = way / lasted if lasted else 0.0
        else:
            way, lasted = way + pace[k] * (time[k] - time[k - 1]), lasted + time[k] - time[k - 1]
    return pace


def columns(inputs: Inputs) -> np.ndarray:
    """The arguments of an export in their order, (n, 8)."""
    names = ("pressure", "contraction", "velocity", "direction", "time", "cycle", "temperature")
    return np.stack([*(getattr(inputs, name) for name in names), ~inputs.moving], axis=1)


def instant(inputs: Inputs, k: int) -> Inputs:
    """All tracks side by side at their sample k."""
    return inputs.take(np.arange(TRACKS) * LENGTH + k)


def expected(case: Case, inputs: Inputs) -> np.ndarray:
    """Force in N along all tracks as NumPy has it: Model.force, or Model.step sample by sample, (n,)."""
    parts = []
    for values in case.branches.values():
        if not case.remembers:
            parts.append(case.model.force(replace(inputs, live=Live(None)), values))
            continue
        memory, found = None, []
        for k in range(LENGTH):
            force, memory = case.model.step(instant(inputs, k), values, memory)
            found.append(force)
        parts.append(np.array(found).T.ravel())
    if len(parts) == 1:
        return parts[0]
    share = 0.5 * (1.0 + inputs.direction)
    return share * parts[0] + (1.0 - share) * parts[1]


def law_values(law, seed: int) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    values = {q.name: q.scale * rng.uniform(0.3, 1.5) for q in law.linear}
    return values | {q.name: rng.uniform(min(q.grid), max(q.grid)) for q in law.nonlinear}


def cases() -> list[Case]:
    found = [Case(f"law_{name}", Model(law), {"together": law_values(law, 3)}) for name, law in laws().items()]
    for effect in effects().values():
        for form in effect.forms:
            model = model_of(effect, form, "exponential_law")
            found.append(Case(f"{effect.name}_{form.name}", model, {"together": LAW_VALUES | plausible(effect, form)}))
    rich = Model.build("exponential_law", RICH)
    sizes = {k: v for term in rich.terms for k, v in plausible(term.effect, term.form).items()}
    other = {k: 1.1 * v for k, v in (LAW_VALUES | sizes).items()}
    found.append(Case("rich", rich, {"together": LAW_VALUES | sizes}))
    found.append(Case("branches", rich, {"contraction": LAW_VALUES | sizes, "extension": other}))
    geometry = Model.build("modified_chou_hannaford", (), free_geometry=True)
    found.append(
        Case("geometry", geometry, {"together": {"k0": 0.9, "k2": 30.0, "k1": 1.3, "r0": 9.1, "theta0": 24.0}})
    )
    return found


CASES = cases()
BY_NAME = {case.name: case for case in CASES}
SHORT = {f"{effect.name}_{effect.forms[0].name}" for effect in effects().values()} | {"geometry"}
EACH_CASE = pytest.mark.parametrize(
    "case",
    [
        pytest.param(c, id=c.name, marks=() if c.name in SHORT or c.name.startswith("law_") else pytest.mark.long)
        for c in CASES
    ],
)
"""The laws and the first form of each effect; all forms and rich models in the long tier."""


class Expected(dict[str, np.ndarray]):
    """Forces of the cases along all tracks by name, computed where they are asked for."""

    def __init__(self, inputs: Inputs) -> None:
        super().__init__()
        self.inputs = inputs

    def __missing__(self, name: str) -> np.ndarray:
        self[name] = expected(BY_NAME[name], self.inputs)
        return self[name]


def assert_agrees(found: np.ndarray, numpy_force: np.ndarray) -> None:
    """To 1e-12 of the largest force."""
    np.testing.assert_allclose(found, numpy_force, rtol=0.0, atol=1e-12 * np.abs(numpy_force).max())
