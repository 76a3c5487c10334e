"""Saved fits on other data, and the choice of a law, as the dictionaries that other programs read."""

from dataclasses import asdict
from typing import TYPE_CHECKING

from .fit import Json
from .versions import schema, warnings_json

if TYPE_CHECKING:
    import pandas as pd

    from ..tasks.law_choice import LawChoice
    from ..tasks.predict import ErrorsThere, SavedFit, Validation


def law_choice_json(choice: "LawChoice | None") -> Json:
    """What is added to an answer whose law was chosen; nothing where it was named."""
    if choice is None:
        return {}
    trials = [
        {
            "law": one.law,
            "parameters": one.parameters,
            "rmse_N": one.rmse,
            "heldout_rmse_N": one.heldout_rmse,
            "problem": one.problem or None,
        }
        for one in choice.trials
    ]
    return {"law_choice": {"why": choice.why, "laws": trials}}


def validation_json(fit: str, record: str, found: "Validation") -> Json:
    """Schema pam-ident/validation/1."""
    return {
        "schema": schema("validation"),
        "fit": fit,
        "record": record,
        "law": found.saved.law,
        "effects": list(found.saved.effects),
        "n": len(found.record),
        **_trial(found.trial),
        "coverage": found.coverage,
        "outside_share": found.outside,
        "simpler": [{"name": name, **_trial(one)} for name, one in found.simpler.items()],
        "sentence": found.sentence,
        "warnings": warnings_json(found.warnings),
    }


def _trial(one: "ErrorsThere") -> Json:
    named = {"rmse": "rmse_N", "max_error": "max_error_N", "r2": "r2"}
    return {named[key]: value for key, value in asdict(one).items()}


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
