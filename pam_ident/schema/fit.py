"""Fits as the dictionaries that other programs read; NaN is blanked when they are written."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any, TypeVar

from .versions import picked, schema, warnings_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..core import Inputs, Param
    from ..fitting import Fit
    from ..fitting.fit import Estimate
    from ..fitting.prediction import Elsewhere
    from ..tasks.fit import Checks, FitAnswer

Json = dict[str, Any]
T = TypeVar("T", "Estimate", "Param")


def in_order(parameters: "Sequence[T]") -> list[T]:
    """The law's parameters by name, as its formula is read, then the effects' as they come."""
    return sorted(parameters, key=lambda e: (1, "") if "." in e.name else (0, e.name))


def parameters(estimates: "tuple[Estimate, ...]") -> Json:
    """Parameters by name, in full."""
    return {
        e.name: {
            **picked(e, "value", "stderr", "unit", "at_bound", "identified"),
            "interval": [e.low, e.high],
            "freedom": e.dof,
            "verdict": e.verdict.kind,
            "partners": list(e.verdict.partners),
            "possible": e.possible,
        }
        for e in estimates
    }


def fit_json(record: str, law: str, answer: "FitAnswer") -> Json:
    """Schema pam-ident/fit/1."""
    fits = answer.fits
    found: Json = {
        "schema": schema("fit"),
        "record": record,
        "law": law,
        "effects": next(iter(fits.values())).model.labels,
        **muscle(next(iter(fits.values()))),
        "branches": {
            branch: _branch(one) | _checks(answer.checks[branch], one) | elsewhere(answer.elsewhere[branch])
            for branch, one in fits.items()
        },
    }
    if answer.isobars is not None:
        found["per_pressure"] = [
            {
                "pressure_MPa": row.pressure_MPa,
                "branch": row.branch,
                "parameters": {e.name: picked(e, "value", "stderr") for e in row.estimates},
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
    found["warnings"] = warnings_json(answer.warnings)
    return found


def shared_json(records: "Sequence[str]", answer: "FitAnswer") -> Json:
    """What stands beside a fit that was made to several `records` at once."""
    names = next(iter(answer.fits.values())).shared
    return {"shared": {"parameters": list(names), "records": list(records)}}


def muscle(one: "Fit") -> Json:
    """What a fitted model needs besides its parameters to be used elsewhere; `range` is what the record covered."""
    specimen = {key: value for key, value in asdict(one.record.specimen).items() if key != "sensors"}
    return {"specimen": specimen, "free_geometry": one.model.free_geometry, "range": covered(one.record.inputs)}


def covered(inputs: "Inputs") -> dict[str, list[float]]:
    """Smallest and largest pressure, contraction and speed of strokes; without motion the speed is zero."""
    speed = inputs.contraction * 0.0 if inputs.stroke_speed is None else inputs.stroke_speed
    given = {"pressure_MPa": inputs.pressure, "contraction": inputs.contraction, "speed_mm_s": speed}
    return {key: [float(values.min()), float(values.max())] for key, values in given.items()}


def length_json(one: "Fit") -> Json:
    """Errors of the length, what was left out of it and the weights, where the length answered; nothing elsewhere."""
    if one.lengths is None or one.length_errors is None:
        return {}
    weights = sorted({round(float(w), 3) for w in one.lengths.weight[one.rows]})
    return {
        "rmse_mm": one.length_errors.rmse,
        "max_error_mm": one.length_errors.largest,
        "left_out": int(one.lengths.limit.sum()),
        "weights_N": weights,
    }


def _checks(checks: "Checks", one: "Fit") -> Json:
    repeats, lack = checks.repeats, checks.lack
    return {
        "repeats_N" if one.lengths is None else "repeats_mm": None if repeats is None else repeats.sigma,
        "repeats_memory_samples": None if repeats is None else repeats.memory,
        "lack_of_fit": None
        if lack is None
        else {"F": lack.statistic, "freedom": list(lack.freedom), "p_value": lack.p_value},
        "stand_ins": [{"calibration": s.calibration, "parameters": list(s.parameters)} for s in checks.stand_ins],
    }


def elsewhere(one: "Elsewhere") -> Json:
    """What is needed to predict readings, and what must be beaten there."""
    spread, plain = one.spread, one.simpler
    return {
        "reading": {
            "same_N": spread.same,
            "between_N": spread.between,
            "beyond_N": spread.beyond,
            "speed_N": spread.speed,
            "noise_N": spread.noise,
            "pressures_MPa": list(spread.pressures),
            "speeds_mm_s": list(spread.speeds),
            "contraction": list(spread.contraction),
        },
        "simpler": {
            "mean_over_pressure": None if plain.line is None else list(plain.line),
            **({} if plain.contraction_line is None else {"contraction_over_pressure": list(plain.contraction_line)}),
            "polynomial": None if plain.polynomial is None else dict(plain.polynomial),
        },
    }


def covariance(one: "Fit") -> Json:
    """Of the parameters that were fitted and do not stand at a bound; null where no errors were asked for."""
    if one.covariance is None:
        return {"covariance": None}
    return {"covariance": {"names": list(one.free), "matrix": one.covariance.matrix.tolist()}}


def _branch(one: "Fit") -> Json:
    return {
        "parameters": parameters(one.estimates),
        **covariance(one),
        "shares_N": list(one.shares.values()),
        "rmse_N": one.rmse,
        "max_error_N": one.max_error,
        **length_json(one),
        "r2": one.r2,
        "n": one.n,
    }
