"""Two records beside each other as the dictionary that other programs read."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from .fit import Json
from .versions import schema, warnings_json

if TYPE_CHECKING:
    from ..diagnosis.against import Against
    from ..diagnosis.nouns import Diagnosis
    from ..records.doubt import Doubt


def against_json(a: str, b: str, found: "Against", doubts: "Sequence[Doubt]" = ()) -> Json:
    """Schema pam-ident/against/1."""
    force = found.force
    return {
        "schema": schema("against"),
        "a": _one(a, found.a),
        "b": _one(b, found.b),
        "law": found.a.base.model.law.name,
        "effects": found.fits[0].model.labels,
        "parameters": [asdict(one) | {"differs": one.differs} for one in found.parameters],
        "named": [asdict(one) for one in found.effects],
        "force": None
        if force is None
        else {
            "n": force.n,
            "mean_N": force.mean,
            "mean_low_N": force.low,
            "mean_high_N": force.high,
            "rms_N": force.rms,
            "largest_N": force.largest,
            "pressure_MPa": force.pressure_MPa,
            "contraction": force.contraction,
            "share": force.share,
            "explained": force.explained,
        },
        "sentence": found.sentence,
        "warnings": warnings_json(doubts),
    }


def _one(record: str, found: "Diagnosis") -> Json:
    return {
        "record": record,
        "n": len(found.base.record),
        "verdict": found.verdict,
        "selected": list(found.selected),
        "rmse_N": found.base.rmse,
        "rmse_after_N": found.best.rmse,
        "noise_floor_N": found.noise_floor,
        "follows": [asdict(one) for one in found.follows],
    }
