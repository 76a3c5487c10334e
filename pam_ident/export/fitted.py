"""What is exported: a model with the values of its parameters, and where they are from."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ..core import DataError, Specimen
from ..effects import Effect
from ..fitting import Fit
from ..leg.fit_file import Answer, read_answer, read_specimen_of
from ..model import Model
from ..schema.fit import covered

BRANCHES = ({"together"}, {"contraction"}, {"extension"}, {"contraction", "extension"})


class Parameter(NamedTuple):
    """A fitted parameter; `stderr` is NaN where there is none."""

    name: str
    value: float
    stderr: float
    unit: str
    doc: str


class Span(NamedTuple):
    """What a record covered: gauge pressure in MPa and contraction ratio, least and largest."""

    pressure_MPa: tuple[float, float]
    contraction: tuple[float, float]


@dataclass(frozen=True)
class Fitted:
    """A model on its specimen, with parameters by branch: `together`, `contraction`, `extension`, or the latter two.

    `record` names the data, `rmse_N` is what was left of it by branch, `span` what it covered, where that is known.
    `problems` say which parameters the record does not determine.
    """

    model: Model
    specimen: Specimen
    branches: Mapping[str, tuple[Parameter, ...]]
    record: str
    rmse_N: Mapping[str, float]
    span: Span | None = None
    problems: tuple[str, ...] = ()

    @property
    def caution(self) -> str:
        """What its error holds for where an effect follows the motion; empty where none does."""
        if not any(term.form.remembers or "motion" in term.effect.needs for term in self.model.terms):
            return ""
        return (
            "That error is for a position without noise within a stroke. Given readings as they come, what follows the "
            "motion follows each small turn of the sensor's noise: smooth them first, or it errs by more"
        )

    @classmethod
    def of(cls, fits: Mapping[str, Fit] | Fit) -> "Fitted":
        """From a fit, which stands for both branches, or from fits by branch."""
        given = {"together": fits} if isinstance(fits, Fit) else dict(fits)
        one = next(iter(given.values()))
        return cls(
            one.model,
            one.record.specimen,
            {
                name: tuple(Parameter(e.name, e.value, e.stderr, e.unit, e.doc) for e in fit.estimates)
                for name, fit in given.items()
            },
            one.record.source or one.record.name,
            {name: fit.rmse for name, fit in given.items()},
            _span(covered(one.record.inputs)),
            tuple(f"{name}: {problem}" for name, fit in given.items() for problem in fit.problems),
        )

    @classmethod
    def read(cls, path: str | Path, specimen: Specimen | None = None, extra: tuple[Effect, ...] = ()) -> "Fitted":
        """From a file of `pam-ident fit --json` or `add --json`, or the last rung of one of `ladder --json`.

        `specimen` stands in for the file's. Raises DataError for another file, UsageError for an unknown effect.
        """
        found = read_answer(path)
        labels, holders = found.stages[-1]
        if set(holders) not in BRANCHES:
            raise DataError(f"{path}: holds the branches {', '.join(holders) or 'none'}; fit again with --json")
        model = found.model(labels, extra)
        return cls(
            model,
            specimen or read_specimen_of(found),
            {name: _parameters(found, one, model, name) for name, one in holders.items()},
            str(found.content.get("record", "")),
            {name: one["rmse_N"] for name, one in holders.items() if isinstance(one.get("rmse_N"), int | float)},
            _span(found.content.get("range")),
            tuple(
                f"{name}: the record does not determine {key}"
                for name, one in holders.items()
                for key, about in found.get("parameters", dict, one).items()
                if about.get("identified") is False
            ),
        )

    def values(self, branch: str) -> dict[str, float]:
        """Parameter values of a branch by name."""
        return {p.name: p.value for p in self.branches[branch]}


def _parameters(found: Answer, holder: Mapping[str, Any], model: Model, branch: str) -> tuple[Parameter, ...]:
    values, about = found.values(holder), found.get("parameters", dict, holder)
    missing = [name for name in model.names if not math.isfinite(values.get(name, math.nan))]
    if missing:
        raise DataError(f"{found.path}: {branch} lacks {', '.join(missing)}; fit again with --json")
    parameters = []
    for p in model.params:
        stderr = about.get(p.name, {}).get("stderr")
        error = float(stderr) if isinstance(stderr, int | float) else math.nan
        parameters.append(Parameter(p.name, values[p.name], error, p.unit, p.doc))
    return tuple(parameters)


def _span(table: Any) -> Span | None:
    try:
        (p_low, p_high), (e_low, e_high) = table["pressure_MPa"], table["contraction"]
        return Span((float(p_low), float(p_high)), (float(e_low), float(e_high)))
    except (TypeError, KeyError, ValueError):
        return None
