"""Results as tables of pandas. Columns carry their unit in their name."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..core import UsageError
from ..records import Record
from ..schema.diagnosis import in_order

if TYPE_CHECKING:
    from ..diagnosis.nouns import Comparison, Diagnosis, Ladder
    from ..fitting import Fit
    from ..leg.track import Track

BRANCHES = {1.0: "contraction", -1.0: "extension"}


def to_frame(result: Any) -> pd.DataFrame:
    """A result as a table of pandas.

    Args:
        result: of a Record its samples, of a Fit its parameters, of a Comparison the cells of its map, of a Diagnosis
            its ranking, of a Ladder and a Track their rungs.

    Raises:
        UsageError: for anything else.

    Example:
        >>> from pam_ident.export.frames import to_frame
        >>> from pam_ident.fitting import fit
        >>> from pam_ident.model import Model
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> found = fit(Model.build("martens_boblan"), read_record(dataset_record("dmsp20_300")))
        >>> print(to_frame(found)[["parameter", "value", "stderr"]].round(1).head(2))
          parameter   value  stderr
        0         A   562.3    15.6
        1         H  1148.8    ...
    """
    table = next((TABLES[one.__name__] for one in type(result).__mro__ if one.__name__ in TABLES), None)
    if table is None:
        raise UsageError(f"no table of a {type(result).__name__}; expected one of {', '.join(TABLES)}")
    return table(result)


def samples(record: Record) -> pd.DataFrame:
    """A row a sample; `record_from_frame` reads it back."""
    inputs = record.inputs
    columns = {
        "time_s": inputs.time,
        "pressure_MPa": inputs.pressure,
        "pressure_set_MPa": record.level,
        "contraction": inputs.contraction,
        "velocity_mm_s": inputs.velocity,
        "moving": inputs.moving,
        "cycle": record.groups.get("cycle", inputs.cycle),
        "temperature_C": inputs.temperature,
        "force_N": record.force,
    }
    frame = pd.DataFrame({name: column for name, column in columns.items() if column is not None})
    if np.all(inputs.direction != 0.0):
        frame.insert(list(frame).index("contraction") + 1, "branch", [BRANCHES[d] for d in inputs.direction])
    return frame


def residuals(fit: "Fit") -> pd.DataFrame:
    """The samples of a fit's record with the model's force, what is left, and whether the sample was fitted."""
    return samples(fit.record).assign(model_N=fit.force, residual_N=fit.residual, fitted=fit.rows)


def parameters(fit: "Fit") -> pd.DataFrame:
    """A row a parameter, in the model's order; NaN where the record does not determine an error."""
    names = ("value", "stderr", "low", "high", "unit", "at_bound", "identified", "doc")
    return pd.DataFrame(
        [{"parameter": e.name} | {name: getattr(e, name) for name in names} for e in fit.estimates],
        columns=["parameter", *names],
    )


def cells(comparison: "Comparison") -> pd.DataFrame:
    """A row for each cell of the failure map that holds samples."""
    rows = []
    for b, p, c in np.argwhere(np.isfinite(comparison.mean)):
        rows.append(
            {
                "branch": comparison.branches[b],
                "pressure_MPa": comparison.pressures[p],
                "contraction_low": comparison.edges[c],
                "contraction_high": comparison.edges[c + 1],
                "mean_N": comparison.mean[b, p, c],
                "rms_N": comparison.rms[b, p, c],
                "share": comparison.share[b, p, c],
            }
        )
    return pd.DataFrame(rows)


def ranking(diagnosis: "Diagnosis") -> pd.DataFrame:
    """A row a candidate, in the order of the ranking; NaN where an error was not computed."""
    rows = [
        {
            "effect": s.effect,
            "label": s.label,
            "selected": s.effect in diagnosis.selected,
            "status": s.status,
            "probability": s.probability,
            "rmse_after_N": np.nan if s.rmse_after is None else s.rmse_after,
            "heldout_rmse_after_N": np.nan if s.heldout_rmse_after is None else s.heldout_rmse_after,
            "why": s.why,
        }
        for s in in_order(diagnosis)
    ]
    return pd.DataFrame(rows)


def rungs(ladder: "Ladder") -> pd.DataFrame:
    """A row a rung, the law alone first; `effects` are labels joined by commas."""
    rows = [
        {
            "law": rung.fit.model.law.name,
            "effects": ", ".join(rung.effects),
            "parameters": len(rung.fit.model.params),
            "rmse_N": rung.fit.rmse,
            "heldout_rmse_N": rung.heldout_rmse,
            "refit_rmse_N": np.nan if rung.refit_rmse is None else rung.refit_rmse,
            "max_error_N": rung.fit.max_error,
            "why": rung.why,
        }
        for rung in ladder.rungs
    ]
    return pd.DataFrame(rows)


def controllers(track: "Track") -> pd.DataFrame:
    """A row a controller: PID tuned by hand and automatically, PID with each rung's model ahead, with the plant's."""
    runs: list[tuple[str, Any, str, float, tuple[float, float] | None]] = [
        ("PID, by hand", track.pid_by_hand, "", np.nan, None),
        ("PID", track.pid, "", np.nan, None),
    ]
    for rung in track.rungs:
        model = rung.muscle.model
        left = rung.muscle.rmse
        runs.append((f"PID + {model.law.name}", rung.tracking, ", ".join(model.labels), left, rung.band))
    runs.append(("PID + the plant's own model", track.ideal, "", np.nan, None))
    rows = [
        {
            "controller": name,
            "effects": effects,
            "fit_rmse_N": left,
            "rms_deg": run.rms_deg,
            "peak_deg": run.peak_deg,
            "rms_low_deg": np.nan if band is None else band[0],
            "rms_high_deg": np.nan if band is None else band[1],
        }
        for name, run, effects, left, band in runs
    ]
    return pd.DataFrame(rows)


TABLES: dict[str, Callable[[Any], pd.DataFrame]] = {
    "Record": samples,
    "Fit": parameters,
    "Comparison": cells,
    "Diagnosis": ranking,
    "Ladder": rungs,
    "Track": controllers,
}
"""By the name of the result's type, so that none of them must be imported."""
