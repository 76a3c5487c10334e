"""Hidden physics that the catalogue lacks: what is left out of it for a case, so that no file foresees the answer."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..core import UsageError
from ..effects import catalogue
from ..fitting import fit
from ..model import Model, Term
from ..records import read_record
from ..rig.challenge import FAMILY
from ..rig.record import RigRecord

SAME = 0.05
"""Share of what is hidden that a form may leave and still count as the very form that is hidden."""


def related(name: str) -> tuple[str, ...]:
    """An effect with all that are of its family, or that follow what it follows: the statics apart, as all of them do.

    Example:
        >>> related("viscous_damping")
        ('pressure_lag', 'stribeck_friction', 'viscous_damping')
    """
    known = catalogue()
    own = set(known[name].follows) - {"map"}
    kin = {other for other in known if FAMILY.get(other, other) == FAMILY.get(name, name)}
    return tuple(sorted(kin.union(e.name for e in known.values() if not own.isdisjoint(e.follows))))


def effects_left_out(case: Path, hidden: RigRecord) -> tuple[str, ...]:
    """The hidden effects with their related."""
    return tuple(sorted({other for one in hidden.hidden for other in related(one.name)}))


def forms_left_out(case: Path, hidden: RigRecord) -> tuple[str, ...]:
    """All written forms, `name:form`, that can follow what is hidden without noise, to the share SAME of it."""
    record = read_record(case / "record.csv")
    model = Model.build(hidden.plan.law)
    course, time = hidden.course, record.inputs.time
    assert time is not None  # the rig logs it
    added = np.interp(time, course.time[course.rows], hidden.added)  # of the rows that were read
    clean = model.force(record.inputs, fit(model, record, detail=False).values) + added
    clean_record = replace(record, force=clean)
    alone = fit(model, clean_record, detail=False).rmse
    effects = [catalogue()[one.name] for one in hidden.hidden]
    written = [Term(effect, form) for effect in effects for form in effect.forms if not form.free]
    same = [t for t in written if fit(model.adding(t), clean_record, detail=False).rmse < SAME * alone]
    return tuple(f"{t.effect.name}:{t.form.name}" for t in same)


LEFT_OUT: dict[str, Callable[[Path, RigRecord], tuple[str, ...]]] = {
    "effects": effects_left_out,
    "forms": forms_left_out,
}


def left_out(what: str) -> Callable[[Path, RigRecord], tuple[str, ...]]:
    """What says what is left out for a case. Raises UsageError for an unknown word."""
    if what not in LEFT_OUT:
        raise UsageError(f"--holdout {what}: expected one of {', '.join(LEFT_OUT)}")
    return LEFT_OUT[what]
