"""A record as one meets it at the prompt: it reads from anything, draws itself and comes back as a table."""

import os
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core import Array, Specimen, UsageError
from ..core.nearest import unknown
from ..records import Record, read_record, record_from_frame
from ..records.kind import check_kind
from ..records.record import rebuilt
from ..records.specimen_file import read_kind
from ..records.where import rows_where
from .hints import Hinting
from .working import worked

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GEOMETRY = tuple(f.name for f in fields(Specimen) if f.name != "sensors")


def axes_of(draw: "Callable[..., Figure]", *what: Any) -> "Axes":
    """The first Axes of a figure, whose `figure` has the others. Pyplot holds it, so that a notebook shows it."""
    from matplotlib import pyplot

    from ..plot.style import figures_by

    with figures_by(pyplot.figure):
        return draw(*what).axes[0]


class ShownRecord(Hinting, Record):
    """A measured record, as `pam.read` gives it.

    It is a `pam_ident.records.Record` (force, inputs, levels, specimen, `take`, `branch_rows`) that shows itself.

    Example:
        >>> import pam_ident as pam
        >>> record = pam.read("hidden_effect")
        >>> print(isinstance(record, pam.Record), len(record), "samples at", record.levels, "MPa")
        True 4680 samples at [0.1 0.2 0.3 0.4 0.5] MPa
    """

    @classmethod
    def of(cls, record: Record) -> "ShownRecord":
        """The same record, that shows itself."""
        return record if isinstance(record, cls) else cls(**{f.name: getattr(record, f.name) for f in fields(record)})

    @property
    def pressure(self) -> Array:
        """Gauge pressure in MPa, shape (n,)."""
        return self.inputs.pressure

    @property
    def contraction(self) -> Array:
        """Contraction ratio, shape (n,)."""
        return self.inputs.contraction

    @property
    def time(self) -> Array | None:
        """Time in s, shape (n,), None of a table without."""
        return self.inputs.time

    def __repr__(self) -> str:
        from ..notebook.lines import line

        return line(self)

    def summary(self) -> str:
        """What was read: samples, pressures, motion, and advice on the rig, a line each."""
        from ..notebook.lines import line
        from ..records.inspection import inspect_record

        found = inspect_record(self)
        lines = [line(self), f"columns: {', '.join(self.columns.values()) or 'from memory'}", line(self.specimen)]
        grave = {doubt.text: str(doubt) for doubt in found.doubts if doubt.grave}
        said = [*grave, *(one for one in found.advice if one not in grave)] or ["nothing amiss"]
        return "\n".join([*lines, *(f"- {grave.get(one, one)}" for one in said)])

    def to_frame(self) -> "pd.DataFrame":
        """A DataFrame (`df`), a row a sample; `pam.read(frame, specimen=record.specimen)` reads it back."""
        from ..export.frames import samples

        return samples(self)

    def to_xarray(self) -> Any:
        """The samples as a Dataset over `sample`, units and the muscle as attributes; `pam.read` reads it back.

        Raises UsageError where xarray is missing.
        """
        from .labelled import dataset

        muscle = {key: getattr(self.specimen, key) for key in GEOMETRY}
        return dataset(self.to_frame(), muscle | {"source": self.source})

    def plot(self) -> "Axes":
        """Force over contraction, isobar by isobar."""
        from ..plot import isobars

        return axes_of(isobars.draw, self)


@worked
def read(
    source: "str | os.PathLike[str] | pd.DataFrame | Mapping[str, Any] | Record",
    specimen: "str | os.PathLike[str] | Mapping[str, Any] | Specimen | None" = None,
    *,
    columns: "str | os.PathLike[str] | None" = None,
    name: str = "",
    kind: str = "",
    where: str = "",
) -> ShownRecord:
    """A record from a file, a folder, a pattern, a data set's name, a table of pandas, a Dataset of xarray or a
    dictionary of arrays.

    Args:
        source: a path, or the name of a bundled data set, or a table or dictionary whose columns are found by
            name and unit, as those of a file are (`pressure_MPa`, `Force (kN)`).
        specimen: the muscle: a `specimen.toml`, a dictionary of its keys, or a Specimen. A file without it takes the
            `specimen.toml` beside it, a Dataset without it the muscle among its attributes.
        columns: a `columns.toml` that says which column of a file is what.
        name: of a record that is no file.
        kind: of the test (isobaric, isometric, isotonic, dynamic); by default as the specimen's file or the data say.
        where: a condition on the rows that are taken, such as `pressure_MPa > 0.1`.

    Raises:
        DataError: for what cannot be read, naming file, row and column.
        UsageError: for a table without a specimen, an unknown key of one, or a condition that is none.

    Example:
        >>> import pam_ident as pam
        >>> pam.read("nothing_hidden")
        Record nothing_hidden: 4680 samples at 0.1, 0.2, 0.3, 0.4, 0.5 MPa
    """
    said = check_kind(kind or None, "pam.read")
    if not said and isinstance(specimen, str | os.PathLike):
        said = read_kind(Path(specimen))
    found = _read(source, specimen, columns, name)
    found = rebuilt(found, found.specimen, said) if said else found
    return ShownRecord.of(rows_where(found, where) if where else found)


def _read(source: Any, specimen: Any, columns: Any, name: str) -> Record:
    if isinstance(source, Record):
        return source if specimen is None else _on(source, as_specimen(specimen))
    if columns is not None and not isinstance(columns, str | os.PathLike):
        raise UsageError(f"columns of a {type(columns).__name__}: expected the path of a columns.toml")
    if isinstance(source, str | os.PathLike):
        muscle = as_specimen(specimen) if specimen is not None else None
        path = Path(source) if isinstance(source, os.PathLike) else source
        return read_record(path, muscle, None if columns is None else Path(columns))
    import pandas as pd

    if type(source).__name__ == "Dataset" and hasattr(source, "to_dataframe"):
        from .labelled import table

        source, muscle = table(source), {key: source.attrs[key] for key in GEOMETRY if key in source.attrs}
        specimen = specimen or muscle or None
    elif isinstance(source, Mapping):
        try:
            source = pd.DataFrame(dict(source))
        except ValueError as error:
            raise UsageError(f"the arrays do not make a table: {error}") from None
    if not isinstance(source, pd.DataFrame):
        raise UsageError(
            f"{type(source).__name__}: expected a path, a data set's name, a table of pandas, a Dataset of xarray or a "
            "dictionary of arrays"
        )
    if specimen is None:
        raise UsageError(
            f"a table needs its muscle; give specimen={{{', '.join(repr(one) for one in GEOMETRY[1:4])}: …}}"
        )
    return record_from_frame(source, as_specimen(specimen), name)


def as_specimen(given: Any) -> Specimen:
    """A Specimen from its file, a dictionary, or itself. Raises UsageError, DataError."""
    from ..records import read_specimen

    if isinstance(given, Specimen):
        return given
    if isinstance(given, str | os.PathLike):
        return read_specimen(Path(given))
    if not isinstance(given, Mapping):
        raise UsageError(f"specimen {given!r}: expected a file, a dictionary or a Specimen")
    for key in given:
        if key not in (*GEOMETRY, "sensors"):
            raise UsageError(unknown("key of a specimen", key, GEOMETRY))
    lacking = [key for key in GEOMETRY[1:4] if key not in given]
    if lacking:
        raise UsageError(f"the specimen lacks {', '.join(lacking)}")
    try:
        return Specimen(**given)
    except TypeError:
        raise UsageError(f"specimen {dict(given)}: expected numbers, in mm and degrees") from None


def _on(record: Record, specimen: Specimen) -> Record:
    """The same readings on another muscle; contraction is of the length, which must stay. Raises UsageError."""
    length = record.specimen.initial_length_mm
    if specimen.initial_length_mm != length:
        raise UsageError(
            f"initial_length_mm {specimen.initial_length_mm:g}: the record was read with {length:g}; read it anew"
        )
    return replace(
        record, inputs=replace(record.inputs, specimen=specimen), steady=replace(record.steady, specimen=specimen)
    )
