"""Laws, effects and records as the dictionaries that other programs read: what is known before anything is fitted."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from ..core import Param
from .fit import Json
from .versions import picked, schema, warnings_json

if TYPE_CHECKING:
    from ..effects import Effect
    from ..laws import Law
    from ..records.inspection import Inspection
    from ..validation.check_effects import BrokenPromise


def _param(p: Param) -> Json:
    return picked(p, "name", "unit", "lower", "upper") | {"meaning": p.doc}


def laws_json(laws: Sequence["Law"]) -> Json:
    """Schema pam-ident/laws/1."""
    return {
        "schema": schema("laws"),
        "laws": [
            picked(law, "name", "title", "formula")
            | {"parameters": [_param(p) for p in law.params], "source": law.source}
            for law in laws
        ],
    }


def effects_json(effects: Sequence["Effect"], problems: Sequence["BrokenPromise"] | None = None) -> Json:
    """Schema pam-ident/effects/1; with `problems` also what effects do not keep of what an effect promises."""
    found: Json = {"schema": schema("effects"), "effects": [_effect(one) for one in effects]}
    if problems is not None:
        found["problems"] = [asdict(one) for one in problems]
    return found


def _effect(effect: "Effect") -> Json:
    return {
        "name": effect.name,
        "title": effect.title,
        "needs": list(effect.needs),
        "vary": list(effect.levers),
        "test": effect.test,
        "source": effect.source,
        "warning": effect.warning or None,
        "forms": [
            {"name": form.name, "formula": form.formula, "parameters": [_param(p) for p in form.params]}
            for form in effect.forms
        ],
    }


def inspection_json(path: str, found: "Inspection") -> Json:
    """Schema pam-ident/inspection/1."""
    record = found.record
    return {
        "schema": schema("inspection"),
        "record": path,
        "n": len(record),
        "masked": record.masked,
        "specimen": asdict(record.specimen),
        "columns": dict(record.columns),
        "passed_over": list(record.passed),
        "metadata": dict(record.metadata),
        "branches": dict(found.branches),
        "isobars": [asdict(one) for one in found.isobars],
        "duration_s": found.duration_s,
        "strokes": found.strokes,
        "speeds_mm_per_s": list(found.speeds),
        "cycles": found.cycles,
        "holds": found.holds,
        "temperature_C": None if found.temperature_C is None else list(found.temperature_C),
        "advice": list(found.advice),
        "kind": found.kind,
        "warnings": warnings_json(found.doubts),
    }
