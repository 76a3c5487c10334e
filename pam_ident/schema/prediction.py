"""Saved fits on other data, and the choice of a law, as the dictionaries that other programs read."""

from typing import TYPE_CHECKING

from .fit import Json
from .versions import schema, warnings_json

if TYPE_CHECKING:
    import pandas as pd

    from ..tasks.law_choice import LawChoice, LawTrial
    from ..tasks.predict import SavedFit
    from ..tasks.validate import ErrorsThere, Validation


def law_choice_json(choice: "LawChoice | None") -> Json:
    """What is added to an answer whose law was chosen; nothing where it was named."""
    if choice is None:
        return {}
    return {"law_choice": {"why": choice.why, "laws": [_law_json(one) for one in choice.trials]}}


def _law_json(one: "LawTrial") -> Json:
    force = None if one.in_mm else one
    return {
        "law": one.law,
        "parameters": one.parameters,
        "rmse_N": force and force.rmse,
        "heldout_rmse_N": force and force.heldout_rmse,
        **({"rmse_mm": one.rmse, "heldout_rmse_mm": one.heldout_rmse} if one.in_mm else {}),
        "problem": one.problem or None,
    }


def validation_json(fit: str, record: str, found: "Validation") -> Json:
    """Schema pam-ident/validation/1."""
    return {
        "schema": schema("validation"),
        "fit": fit,
        "record": record,
        "law": found.saved.law,
        "effects": list(found.saved.effects),
        "n": len(found.record),
        **_trial(found.trial, found.in_mm, found.in_force),
        **({"left_out": found.left_out, "unstable": found.unstable} if found.in_mm else {}),
        "coverage": found.coverage,
        "outside_share": found.outside,
        "simpler": [{"name": name, **_trial(one, found.in_mm)} for name, one in found.simpler.items()],
        "sentence": found.sentence,
        "warnings": warnings_json(found.warnings),
    }


def _trial(one: "ErrorsThere", in_mm: bool, in_force: "ErrorsThere | None" = None) -> Json:
    """Errors by name; of a length in mm, and those of the force at the measured length, null where nobody asks."""
    if not in_mm:
        return {"rmse_N": one.rmse, "max_error_N": one.max_error, "r2": one.r2}
    force = {"rmse_N": in_force and in_force.rmse, "max_error_N": in_force and in_force.max_error}
    return {**force, "rmse_mm": one.rmse, "max_error_mm": one.max_error, "r2": one.r2}


def prediction_json(fit: str, saved: "SavedFit", frame: "pd.DataFrame") -> Json:
    """Schema pam-ident/prediction/1."""
    return {
        "schema": schema("prediction"),
        "fit": fit,
        "law": saved.law,
        "effects": list(saved.effects),
        "n": len(frame),
        "columns": {name: column.tolist() for name, column in frame.items()},
    }
