"""The states at which a fit is asked: numbers and arrays, or a table that is read as a record is."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core import DataError, Inputs, Specimen, UsageError
from ..records import build_record, read_record, record_from_frame
from ..records.quantities import QUANTITIES, Source
from ..records.ranges import beyond_reason
from ..records.sources import find_states, passed_over
from ..records.table import Table

if TYPE_CHECKING:
    import pandas as pd

Array = np.ndarray


@dataclass(frozen=True)
class States:
    """What a fit is asked at, n samples; `load` (n,) in N where the length is asked for that carries it. `warnings` say
    which columns and rows were left out."""

    inputs: Inputs
    load: Array | None = None
    warnings: tuple[str, ...] = ()


def read_states(at: "str | Path | pd.DataFrame", specimen: Specimen) -> States:
    """The states of a file or a table, with or without a force column, or with a force and no length. Raises
    DataError."""
    strange: list[str] = []

    def find(table: Table) -> dict[str, Source]:
        found = find_states(table)
        strange.extend(table.headers[k] for k in passed_over(table, found))
        return found

    if isinstance(at, str | Path):
        record = read_record(at, specimen, find=find)
    else:
        record = record_from_frame(at, specimen, find=find)
    known = ", ".join(QUANTITIES)
    said = [f"column {one!r} is none of {known}; it is left out" for one in dict.fromkeys(strange)]
    warnings = [f"{record.source}: {one}" for one in [*said, *(note.text for note in record.notes)]]
    lacking, one, given = {name for name, header in record.columns.items() if not header}, record.inputs, record.columns
    motion = {name: values for name, values in (("branch", one.direction), ("cycle", one.cycle)) if name in given}
    if "contraction" in lacking:
        inputs = inputs_of(record.specimen, one.pressure, 0.0, temperature_C=one.temperature, **motion)
        return States(inputs, record.force, tuple(warnings))
    if "force" in lacking:  # as if it pulled: a force of 0 is a load that is held, and the length answers
        more = {"time_s": one.time, "temperature_C": one.temperature, **motion}
        one = inputs_of(record.specimen, one.pressure, one.contraction, **more)
    return States(one, None, tuple(warnings))


def inputs_of(specimen: Specimen, pressure: Any, contraction: Any, **more: Any) -> Inputs:
    """Inputs from numbers or arrays that broadcast to shape (n,).

    `pressure` is in MPa (gauge), `contraction` a ratio; `more` may be time_s, temperature_C, cycle, and branch
    ('contraction', 'extension', or their signs). With a time, motion and branches are found from it. Raises UsageError
    for another name, or shapes that do not go together, DataError for values that no muscle has.
    """
    known = ("time_s", "temperature_C", "cycle", "branch")
    wrong = [name for name in more if name not in known]
    if wrong:
        raise UsageError(f"{', '.join(wrong)}: expected {', '.join(known)} beside pressure and contraction")
    given = {"pressure": pressure, "contraction": contraction, **{k: v for k, v in more.items() if v is not None}}
    if "branch" in given:
        given["branch"] = _signs(given["branch"])
    try:
        arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, float)) for v in given.values()))
    except ValueError as error:
        raise UsageError(f"pressure, contraction and the rest do not go together: {error}") from None
    found = {name: array.ravel().copy() for name, array in zip(given, arrays, strict=True)}
    checked = {name.removesuffix("_s").removesuffix("_C"): values for name, values in found.items()}
    for name, row, wrong in beyond_reason(checked, specimen.initial_length_mm):
        raise DataError(f"{name}{f', element {row}' if len(found[name]) > 1 else ''}: {wrong}")
    states = found["pressure"], found["contraction"]
    optional = {"time": "time_s", "temperature": "temperature_C", "cycle": "cycle", "direction": "branch"}
    picked: dict[str, Any] = {key: found.get(name) for key, name in optional.items()}
    return build_record("", specimen, *states, specimen.ideal_force(*states), **picked).inputs


def _signs(branch: Any) -> Array:
    words = {"contraction": 1.0, "extension": -1.0}
    flat = np.atleast_1d(np.asarray(branch))
    if flat.dtype.kind in "fiu":
        return flat.astype(float)
    wrong = sorted({str(one) for one in flat} - set(words))
    if wrong:
        raise UsageError(f"branch {wrong[0]!r}: expected contraction or extension")
    return np.array([words[str(one)] for one in flat])
