"""Comparisons, diagnoses and ladders as the dictionaries that other programs read."""

import math
from dataclasses import asdict
from typing import TYPE_CHECKING

from .fit import Json, covariance, elsewhere, length_json, muscle, parameters
from .versions import picked, schema, warnings_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..diagnosis.nouns import (
        Bin,
        Candidate,
        Comparison,
        Diagnosis,
        Experiment,
        Follows,
        Ladder,
        Nested,
        Pattern,
        Region,
    )
    from ..fitting import Fit
    from ..records.doubt import Doubt
    from ..tasks.add import Addition


STATUS = {
    "candidate": "candidate",
    "absorbed_by_law": "absorbed by the law",
    "not_excited": "not shown by this record",
}
"""What the status of an effect means, in words."""


def comparison_json(record: str, comparison: "Comparison", doubts: "Sequence[Doubt]" = ()) -> Json:
    """Schema pam-ident/comparison/1. Where the length answered, the map and its parts are of its errors, and those in N
    are null."""
    fit, length = comparison.fit, comparison.fit.length_errors
    mean, rms = (None, None) if length else (comparison.mean, comparison.rms)
    return {
        "schema": schema("comparison"),
        "record": record,
        "law": fit.model.law.name,
        "effects": fit.model.labels,
        "n": int(fit.rows.sum()),
        "rmse_N": fit.rmse,
        "max_error_N": fit.max_error,
        **length_json(fit),
        "odd_share": comparison.odd,
        "even_share": comparison.even,
        "rest_share": comparison.rest,
        "by": {key: [_part(one, length is not None) for one in bins] for key, bins in comparison.by.items()},
        "worst": [_part(one, length is not None) for one in comparison.worst],
        "map": {
            "branches": list(comparison.branches),
            "pressures_MPa": comparison.pressures,
            "contraction_edges": comparison.edges,
            "mean_N": mean,
            "rms_N": rms,
            **({"mean_mm": comparison.mean, "rms_mm": comparison.rms} if length else {}),
            "share": comparison.share,
        },
        "follows": _follows(comparison.follows),
        "sentence": comparison.sentence,
        "warnings": warnings_json(doubts),
    }


def _follows(found: "tuple[Follows, ...]") -> list[Json]:
    return [asdict(one) for one in found]


def _part(one: "Bin | Region", in_mm: bool) -> Json:
    """Part of the map, its errors by name and unit."""
    unit = "mm" if in_mm else "N"
    empty = {"mean_N": None, "rms_N": None} if in_mm else {}
    named = {"mean": f"mean_{unit}", "rms": f"rms_{unit}"}
    return {named.get(key, key): value for key, value in asdict(one).items()} | empty


def candidates(diagnosis: "Diagnosis") -> "list[Candidate]":
    """The effects that may be missing, in order. None where nothing is missing."""
    missing = diagnosis.verdict != "adequate"
    return [s for s in in_order(diagnosis) if missing and s.status == "candidate"]


def in_order(diagnosis: "Diagnosis") -> "list[Candidate]":
    """The ranking by probability in whole per cent, of those that are alike first what was selected, then by the error
    that they leave; then the effects that were not judged."""

    def shown(one: "Candidate") -> tuple[bool, int, bool, float, str]:
        """Errors that read alike are alike: what lies behind the third digit differs by machine."""
        left = math.inf if one.rmse_after is None else float(f"{one.rmse_after:.3g}")
        judged = one.status == "candidate"
        return not judged, -round(100 * one.probability), one.effect not in diagnosis.selected, left, one.effect

    return sorted(diagnosis.ranking, key=shown)


def stopped_json(record: str, law: str, n: int, doubts: "Sequence[Doubt]") -> Json:
    """Schema pam-ident/diagnosis/1 of `n` samples of which nothing is named, because of `doubts`."""
    numbers = ("rmse_N", "noise_floor_N", "rmse_after_N", "heldout_rmse_N", "heldout_rmse_after_N")
    return {
        "schema": schema("diagnosis"),
        "record": record,
        "law": law,
        "n": n,
        "verdict": "unknown_effect",
        **{key: [] for key in ("selected", "groups", "ranking", "follows")},
        "heldout": "refit",
        **dict.fromkeys((*numbers, "pattern", "next_experiment", "fit_command")),
        "warnings": warnings_json(doubts),
    }


def refusal_json(record: str | None, law: str | None, exit_code: int, doubts: "Sequence[Doubt]") -> Json:
    """Schema pam-ident/refusal/1 of what a command could not read or fit, because of `doubts`."""
    found = {"schema": schema("refusal"), "record": record, "law": law, "exit_code": exit_code}
    return found | {"warnings": warnings_json(doubts)}


def diagnosis_json(
    record: str, diagnosis: "Diagnosis", doubts: "Sequence[Doubt]" = (), command: str | None = None
) -> Json:
    """Schema pam-ident/diagnosis/1; `command` is what fits the model with what was missing."""
    return {
        "schema": schema("diagnosis"),
        "record": record,
        "law": diagnosis.base.model.law.name,
        "n": len(diagnosis.base.record),
        "rmse_N": diagnosis.base.rmse,
        "noise_floor_N": diagnosis.noise_floor,
        "verdict": diagnosis.verdict,
        "selected": list(diagnosis.selected),
        "groups": [list(group) for group in diagnosis.groups],
        "ranking": [
            picked(s, "effect", "status", "probability")
            | {"rmse_after_N": s.rmse_after, "heldout_rmse_after_N": s.heldout_rmse_after}
            for s in in_order(diagnosis)
        ],
        "rmse_after_N": diagnosis.best.rmse,
        **_in_length(rmse_mm=diagnosis.rmse_mm, rmse_after_mm=diagnosis.rmse_after_mm),
        "heldout_rmse_N": diagnosis.heldout_rmse,
        "heldout_rmse_after_N": diagnosis.heldout_rmse_after,
        "heldout": diagnosis.heldout,
        "follows": _follows(diagnosis.follows),
        "pattern": _pattern(diagnosis.pattern),
        "next_experiment": _experiment(diagnosis.next_experiment),
        "fit_command": command,
        "warnings": warnings_json(doubts),
    }


def _in_length(**errors: float | None) -> Json:
    """Errors of the length, where a load was held."""
    return {key: error for key, error in errors.items() if error is not None}


def _experiment(experiment: "Experiment | None") -> Json | None:
    if experiment is None:
        return None
    return {
        "vary": list(experiment.vary),
        "text": experiment.text,
        "predicted": [asdict(one) for one in experiment.predicted],
        "minutes": experiment.minutes,
        "protocol": None if experiment.protocol is None else experiment.protocol.table(),
    }


def _pattern(pattern: "Pattern | None") -> Json | None:
    return None if pattern is None else picked(pattern, "kind", "coordinate", "value", "unit", "share")


def addition_json(record: str, addition: "Addition") -> Json:
    """Schema pam-ident/add/1; `parameters` are those of the law with the effects."""
    return {
        "schema": schema("add"),
        "record": record,
        "law": addition.after.model.law.name,
        "effects": addition.after.model.labels,
        **muscle(addition.after),
        "n": len(addition.after.record),
        "before": _errors(addition.before, addition.heldout_before),
        "after": _errors(addition.after, addition.heldout_after),
        "parameters": parameters(addition.after.estimates),
        **covariance(addition.after),
        **elsewhere(addition.elsewhere),
        "warnings": warnings_json(addition.warnings),
    }


def _errors(one: "Fit", heldout: float) -> Json:
    return {"rmse_N": one.rmse, "heldout_rmse_N": heldout, "max_error_N": one.max_error}


def ladder_json(record: str, ladder: "Ladder", doubts: "Sequence[Doubt]" = ()) -> Json:
    """Schema pam-ident/ladder/1."""
    last = len(ladder.rungs) - 1
    return {
        "schema": schema("ladder"),
        "record": record,
        "law": ladder.rungs[0].fit.model.law.name,
        **muscle(ladder.rungs[0].fit),
        "rungs": [
            {
                "effects": list(rung.effects),
                "rmse_N": rung.fit.rmse,
                "heldout_rmse_N": rung.heldout_rmse,
                "refit_rmse_N": rung.refit_rmse,
                **_in_length(rmse_mm=rung.rmse_mm),
                "shares_N": list(rung.fit.shares.values()),
                "parameters": parameters(rung.fit.estimates),
                **covariance(rung.fit),
                **(elsewhere(ladder.elsewhere) if k == last else {}),
            }
            for k, rung in enumerate(ladder.rungs)
        ],
        "noise_floor_N": ladder.noise_floor,
        "verdict": ladder.verdict,
        "groups": [list(group) for group in ladder.groups],
        "heldout": "nested" if ladder.nested else "refit",
        "nested": _nested(ladder.nested),
        "warnings": warnings_json(doubts),
    }


def _nested(nested: "Nested | None") -> Json | None:
    if nested is None:
        return None
    beside = [{"law": law, "parameters": k, "heldout_rmse_N": error} for law, (k, error) in nested.beside.items()]
    return {"by": nested.by, "parts": nested.parts, "beside": beside, "text": nested.text}
