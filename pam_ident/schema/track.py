"""A run of the leg as a dictionary that other programs read."""

from typing import TYPE_CHECKING

from .fit import Json
from .versions import picked, schema, warnings_json

if TYPE_CHECKING:
    from ..leg.track import Track, Tracking
    from ..leg.tuning import Tuned


def track_json(found: "Track") -> Json:
    """Schema pam-ident/track/1."""
    budget = found.budget
    return {
        "schema": schema("track"),
        "gait": found.course.gait.name,
        "cadence_Hz": found.course.gait.cadence_Hz,
        "duration_s": float(found.pid.time[-1] - found.pid.time[0]),
        "prototype": found.prototype,
        "ground": found.ground is not None,
        "lessons": found.course.lessons,
        "off": {
            **vars(found.off),
            "force": list(found.off.force),
            "unknown": None if found.off.unknown is None else found.off.unknown.label,
        },
        "agreement_deg": found.agreement_deg,
        "tuning": {"by_hand": _tuned(found.by_hand), "automatic": _tuned(found.automatic)},
        "pid": _tracking(found.pid),
        "pid_by_hand": _tracking(found.pid_by_hand),
        "rungs": [
            {
                "law": rung.muscle.model.law.name,
                "effects": rung.muscle.model.labels,
                "fit_rmse_N": rung.muscle.rmse,
                **_tracking(rung.tracking),
                "rms_band_deg": None if rung.band is None else list(rung.band),
            }
            for rung in found.rungs
        ],
        "ideal": _tracking(found.ideal),
        "budget": picked(budget, "structure", "tuning", "muscle")
        | {"all_rms_deg": budget.by_hand, "automatic_rms_deg": budget.automatic},
        "warnings": warnings_json(found.doubts),
    }


def _tuned(tuned: "Tuned") -> Json:
    names = ("kp_MPa_per_rad", "ki_MPa_per_rad_s", "kd_MPa_s_per_rad")
    gains = dict(zip(names, tuned.gains, strict=True))
    return {**gains, "runs": tuned.runs, "rms_deg": tuned.rms_deg, "worst_rms_deg": tuned.worst_deg}


def _tracking(run: "Tracking") -> Json:
    return {
        **picked(run, "rms_deg", "peak_deg"),
        "troubles": [picked(one, "kind", "time_s", "share") for one in run.troubles],
    }
