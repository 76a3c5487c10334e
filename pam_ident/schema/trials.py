"""The program's trials of itself as the dictionaries that other programs read."""

from typing import TYPE_CHECKING

from .fit import Json
from .versions import picked, schema

if TYPE_CHECKING:
    from ..batch.run import Batch
    from ..tasks.demo import Demo
    from ..validation.challenge import Challenge
    from ..validation.selftest import SelfTest


def batch_json(found: "Batch") -> Json:
    """Schema pam-ident/batch-summary/1: how many records, what went wrong, and where the results are."""
    return {
        "schema": schema("batch-summary"),
        **picked(found, "records", "kept", "errors"),
        "table": str(found.table),
        "page": str(found.page),
    }


def demo_json(found: "Demo") -> Json:
    """Schema pam-ident/demo/1: how each data set's ladder begins and ends, and where the report is."""
    return {
        "schema": schema("demo"),
        "stages": [
            {
                "data_set": stage.data_set,
                "law": stage.ladder.rungs[0].fit.model.law.name,
                "effects": list(stage.ladder.rungs[-1].effects),
                "rmse_N": stage.ladder.rungs[0].fit.rmse,
                "rmse_after_N": stage.ladder.rungs[-1].fit.rmse,
                "noise_floor_N": stage.ladder.noise_floor,
                "verdict": stage.ladder.verdict,
            }
            for stage in found.stages
        ],
        "report": str(found.path),
    }


def selftest_json(found: "SelfTest") -> Json:
    """Schema pam-ident/selftest/1."""
    recovery = found.recovery
    return {
        "schema": schema("selftest"),
        "problems": [picked(one, "name", "start", "digits", "digits_stderr") for one in found.problems],
        "recovery": {
            "furthest_stderr": recovery.furthest,
            "verdict": recovery.clean_verdict,
            "hidden": recovery.hidden,
            "named": list(recovery.named),
        },
        "passed": found.passed,
    }


def challenge_json(found: "Challenge") -> Json:
    """Schema pam-ident/challenge/1; counts by kind, `all` among them."""
    reliability = found.reliability
    return {
        "schema": schema("challenge"),
        "seconds": found.seconds,
        "kinds": {
            t.kind: picked(t, "n", "right", "exact")
            | {"right_by_group": t.grouped}
            | {"error_removed_median": t.removed_median, "error_removed_worst": t.removed_worst}
            for t in found.tallies
        },
        "confusion": [{"hidden": h, "named": n, "count": c} for (h, n), c in sorted(found.confusion.items())],
        "calibration": {
            "brier": reliability.brier,
            "bins": [picked(one, "low", "high", "n", "stated", "true") for one in reliability.bins],
        },
        "cases": [
            picked(s, "case", "kind")
            | {"hidden": list(s.hidden), "named": list(s.named)}
            | {"right": s.right, "exact": s.exact, "error_removed": s.removed}
            for s in found.scores
        ],
    }
