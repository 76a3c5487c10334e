"""Answers as the dictionaries that other programs read; NaN is blanked when they are written."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..diagnosis.nouns import Bin, Comparison, Diagnosis, Experiment, Ladder, Pattern, Region
    from ..fitting import Fit
    from ..fitting.fit import Estimate
    from .add_effects import Addition
    from .fit_record import Checks, FitAnswer

Json = dict[str, Any]


def parameters(estimates: "tuple[Estimate, ...]") -> Json:
    """Parameters by name, in full."""
    return {
        e.name: {
            "value": e.value,
            "stderr": e.stderr,
            "unit": e.unit,
            "at_bound": e.at_bound,
            "identified": e.identified,
            "interval": [e.low, e.high],
            "freedom": e.dof,
            "verdict": e.verdict.kind,
            "partners": list(e.verdict.partners),
        }
        for e in estimates
    }


def fit_json(record: str, law: str, answer: "FitAnswer") -> Json:
    """Schema pam-ident/fit/1."""
    fits = answer.fits
    found: Json = {
        "schema": "pam-ident/fit/1",
        "record": record,
        "law": law,
        "effects": next(iter(fits.values())).model.labels,
        **_muscle(next(iter(fits.values()))),
        "branches": {branch: _branch(one) | _checks(answer.checks[branch]) for branch, one in fits.items()},
    }
    if answer.isobars is not None:
        found["per_pressure"] = [
            {
                "pressure_MPa": row.pressure_MPa,
                "branch": row.branch,
                "parameters": {e.name: {"value": e.value, "stderr": e.stderr} for e in row.estimates},
                "rmse_N": row.rmse,
            }
            for row in answer.isobars.rows
        ]
        found["correlation"] = answer.isobars.correlation
    if answer.methods:
        found["methods"] = [
            {
                "method": row.method,
                "mu_held": row.mu,
                "branch": row.branch,
                "parameters": dict(row.values),
                "rmse_N": row.rmse,
                "heldout_pressure_rmse_N": row.heldout,
            }
            for row in answer.methods
        ]
    found["loops"] = [
        {"pressure_MPa": p, "measured_J": energy, "modelled_J": answer.loops.get(p)}
        for p, energy in sorted(answer.measured_loops.items())
    ]
    found["passive"] = answer.passive
    return found


def _muscle(one: "Fit") -> Json:
    """What a fitted model needs besides its parameters to be used elsewhere; `range` is what the record covered."""
    specimen = {key: value for key, value in asdict(one.record.specimen).items() if key != "sensors"}
    covered = {"pressure_MPa": one.record.inputs.pressure, "contraction": one.record.inputs.contraction}
    return {
        "specimen": specimen,
        "free_geometry": one.model.free_geometry,
        "range": {key: [float(values.min()), float(values.max())] for key, values in covered.items()},
    }


def _checks(checks: "Checks") -> Json:
    floor, lack = checks.floor, checks.lack
    return {
        "noise_floor_N": None if floor is None else floor.sigma,
        "noise_memory_samples": None if floor is None else floor.memory,
        "lack_of_fit": None
        if lack is None
        else {"F": lack.statistic, "freedom": list(lack.freedom), "p_value": lack.p_value},
        "stand_ins": [{"calibration": s.calibration, "parameters": list(s.parameters)} for s in checks.stand_ins],
    }


def _covariance(one: "Fit") -> Json:
    """Of the parameters that were fitted and do not stand at a bound; null where no errors were asked for."""
    if one.covariance is None:
        return {"covariance": None}
    return {"covariance": {"names": list(one.free), "matrix": one.covariance.matrix.tolist()}}


def _branch(one: "Fit") -> Json:
    return {
        "parameters": parameters(one.estimates),
        **_covariance(one),
        "rmse_N": one.rmse,
        "max_error_N": one.max_error,
        "r2": one.r2,
        "n": one.n,
    }


def comparison_json(record: str, comparison: "Comparison") -> Json:
    """Schema pam-ident/comparison/1."""
    fit = comparison.fit
    return {
        "schema": "pam-ident/comparison/1",
        "record": record,
        "law": fit.model.law.name,
        "effects": fit.model.labels,
        "n": int(fit.rows.sum()),
        "rmse_N": fit.rmse,
        "max_error_N": fit.max_error,
        "odd_share": comparison.odd,
        "even_share": comparison.even,
        "rest_share": comparison.rest,
        "by": {key: [_bin(one) for one in bins] for key, bins in comparison.by.items()},
        "worst": [_region(one) for one in comparison.worst],
        "map": {
            "branches": list(comparison.branches),
            "pressures_MPa": comparison.pressures,
            "contraction_edges": comparison.edges,
            "mean_N": comparison.mean,
            "rms_N": comparison.rms,
            "share": comparison.share,
        },
        "sentence": comparison.sentence,
    }


def _bin(one: "Bin") -> Json:
    return {
        "label": one.label,
        "low": one.low,
        "high": one.high,
        "n": one.n,
        "mean_N": one.mean,
        "rms_N": one.rms,
        "share": one.share,
    }


def _region(one: "Region") -> Json:
    return {
        "pressure_MPa": one.pressure_MPa,
        "contraction": list(one.contraction),
        "branch": one.branch,
        "n": one.n,
        "mean_N": one.mean,
        "rms_N": one.rms,
        "share": one.share,
    }


def diagnosis_json(record: str, diagnosis: "Diagnosis") -> Json:
    """Schema pam-ident/diagnosis/1."""
    return {
        "schema": "pam-ident/diagnosis/1",
        "record": record,
        "law": diagnosis.base.model.law.name,
        "n": len(diagnosis.base.record),
        "rmse_N": diagnosis.base.rmse,
        "noise_floor_N": diagnosis.noise_floor,
        "verdict": diagnosis.verdict,
        "selected": list(diagnosis.selected),
        "groups": [list(group) for group in diagnosis.groups],
        "ranking": [
            {
                "effect": s.effect,
                "status": s.status,
                "probability": s.probability,
                "rmse_after_N": s.rmse_after,
                "heldout_rmse_after_N": s.heldout_rmse_after,
            }
            for s in diagnosis.ranking
        ],
        "rmse_after_N": diagnosis.best.rmse,
        "heldout_rmse_N": diagnosis.heldout_rmse,
        "heldout_rmse_after_N": diagnosis.heldout_rmse_after,
        "pattern": _pattern(diagnosis.pattern),
        "next_experiment": _experiment(diagnosis.next_experiment),
    }


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
    keys = ("kind", "coordinate", "value", "unit", "share")
    return None if pattern is None else {key: getattr(pattern, key) for key in keys}


def addition_json(record: str, addition: "Addition") -> Json:
    """Schema pam-ident/add/1; `parameters` are those of the law with the effects."""
    return {
        "schema": "pam-ident/add/1",
        "record": record,
        "law": addition.after.model.law.name,
        "effects": addition.after.model.labels,
        "n": len(addition.after.record),
        "before": _errors(addition.before, addition.heldout_before),
        "after": _errors(addition.after, addition.heldout_after),
        "parameters": parameters(addition.after.estimates),
    }


def _errors(one: "Fit", heldout: float) -> Json:
    return {"rmse_N": one.rmse, "heldout_rmse_N": heldout, "max_error_N": one.max_error}


def ladder_json(record: str, ladder: "Ladder") -> Json:
    """Schema pam-ident/ladder/1."""
    return {
        "schema": "pam-ident/ladder/1",
        "record": record,
        "law": ladder.rungs[0].fit.model.law.name,
        **_muscle(ladder.rungs[0].fit),
        "rungs": [
            {
                "effects": list(rung.effects),
                "rmse_N": rung.fit.rmse,
                "heldout_rmse_N": rung.heldout_rmse,
                "parameters": parameters(rung.fit.estimates),
                **_covariance(rung.fit),
            }
            for rung in ladder.rungs
        ],
        "noise_floor_N": ladder.noise_floor,
        "verdict": ladder.verdict,
    }
