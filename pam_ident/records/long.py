"""A record of any length: read once block by block, kept as columns on disk, and handed on a chunk at a time.

Strokes, holds, cycles and isobars are those of `build_record`: what depends on the whole record (range and noise of the
motion, the clock's usual step, the isobars) is found exactly before the motion is followed piece by piece.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..core import Array, Inputs, Specimen
from .columns import pause_between, read_pieces, same_quantities
from .columns_on_disk import STRETCH, Columns
from .files import Files, find_files
from .isobars import nominal
from .load import files_sha256, headers, nothing_left, record_name, said_kind, specimen_of, tables_of
from .motion import follow, long_pause
from .notes import Note, Notes
from .ranges import Values, contraction_of
from .record import Record, turns
from .roughness import NORMAL_MEDIAN, roughness
from .run_constants import on_length

CHUNK = 1 << 16
"""Rows that are handed on at a time."""
KINDS = {"branch": np.int8, "moving": np.bool_, "segment": np.int32, "stroke": np.int32, "turn": np.int32}
"""How columns are kept that are no floating-point numbers."""


@dataclass(frozen=True, eq=False)
class LongRecord:
    """A record of `n` rows on disk. `pressures` (m,) occur in it, commanded or measured, rounded to 1 Pa, and `nominal`
    (m,) are their isobars' in MPa. The other fields are those of a Record."""

    name: str
    specimen: Specimen
    source: str
    sha256: str
    columns: dict[str, str]
    masked: int
    n: int
    pressures: Array
    nominal: Array
    on_disk: Columns
    notes: tuple[Note, ...] = ()
    said_kind: str = ""

    def __len__(self) -> int:
        return self.n

    @property
    def levels(self) -> Array:
        """The isobars' nominal pressures in MPa, ascending."""
        return np.unique(self.nominal)

    @property
    def timed(self) -> bool:
        """Whether the rows have a time, and so strokes and turns."""
        return self.on_disk.has("turn")

    @property
    def last_run(self) -> int:
        """The number of the last turn or stroke of a record with time."""
        return max(int(self.on_disk.read(k, self.n - 1, self.n, KINDS[k])[0]) for k in ("turn", "stroke"))

    def level(self, begin: int, end: int) -> Array:
        """Nominal pressure in MPa of rows begin … end."""
        return self._nominal(self.on_disk.read(self._by, begin, end))

    @property
    def _by(self) -> str:
        return "pressure_set" if self.on_disk.has("pressure_set") else "pressure"

    def _nominal(self, pressure: Array) -> Array:
        return self.nominal[np.searchsorted(self.pressures, np.round(pressure, 6))]

    def chunks(self, rows: int | None = None, full: bool = True) -> Iterator[tuple[Record, Array]]:
        """The record in order, `rows` at a time (default CHUNK), and the turn of each sample (as `Record.turn`).

        The first sample of a chunk is the record's first and not the chunk's own, for models that count from it. `full`
        chunks have speed, cycle and temperature, others only what a law needs and the direction. Blocks and steady
        inputs are not found.
        """
        rows = rows or CHUNK
        for begin in range(0, self.n, rows):
            end = min(begin + rows, self.n)

            def read(name: str, kind: type, begin: int = begin, end: int = end) -> Array:
                return np.concatenate([self.on_disk.read(name, *ab, kind) for ab in ((0, 1), (begin, end))])

            yield self._take(read, full)

    def sample(self, most: int) -> Record:
        """About `most` rows, evenly spaced by an odd stride, the first among them."""
        stride = (self.n - 1) // most | 1

        def read(name: str, kind: type) -> Array:
            ends = ((begin, min(begin + STRETCH, self.n)) for begin in range(0, self.n, STRETCH))
            # A copy each, lest the slice keep its whole stretch.
            return np.concatenate([self.on_disk.read(name, *ab, kind)[-ab[0] % stride :: stride].copy() for ab in ends])

        return self._take(read, True)[0]

    def _take(self, read: Callable[[str, type], Array], full: bool) -> tuple[Record, Array]:
        def column(name: str, wanted: bool = True) -> Array | None:
            return read(name, KINDS.get(name, np.float64)) if wanted and self.on_disk.has(name) else None

        pressure, force = read("pressure", np.float64), read("force", np.float64)
        none = np.zeros(len(force), int)
        direction, stroke, turn = (
            none if (found := column(name)) is None else found for name in ("branch", "stroke", "turn")
        )
        given = Inputs(pressure, read("contraction", np.float64), self.specimen, direction.astype(float))
        logged = {name: column(name, full) for name in ("time", "velocity", "stroke_speed", "cycle", "temperature")}
        inputs = replace(given, moving=column("moving"), segment=column("segment"), **logged)
        level = self._nominal(read(self._by, np.float64))
        origin = (self.source, self.sha256, self.columns)
        facts = {"masked": self.masked, "notes": self.notes, "said_kind": self.said_kind}
        return Record(self.name, inputs, force, level, stroke, none, inputs, *origin, **facts), turn


@contextmanager
def open_long(path: str | Path, specimen: str | Path | Specimen | None = None) -> Iterator[LongRecord]:
    """A record as `read_record` takes it, text of any size; its columns stay on disk (under TMPDIR) until it is closed.

    Raises what `read_record` does, UsageError where the disk is full.
    """
    files = find_files(path)
    geometry = specimen_of(files, specimen)
    with TemporaryDirectory(prefix="pam-ident-") as folder:
        spill = _Spill(files, geometry, Columns(Path(folder)))
        where: dict[str, str] = {}
        notes = Notes()
        for table, sources, length_mm in tables_of(files, None, geometry, notes):
            for begins, values in read_pieces(table, sources, length_mm, notes):
                spill.put(begins, on_length(values, length_mm, geometry.initial_length_mm))
            where = where or headers(sources)
        yield replace(spill.record(where), notes=notes.told(), said_kind=said_kind(files, specimen, None))


@dataclass
class _Spill:
    """What is learned of the rows on their way to disk: the runs, the pressures that occur, the range of the motion."""

    files: Files
    specimen: Specimen
    on_disk: Columns
    n: int = 0
    masked: int = 0
    runs: list[tuple[int, float, float]] = field(default_factory=list)
    quantities: tuple[str, ...] = ()
    pressures: dict[float, int] = field(default_factory=dict)
    low: float = np.inf
    high: float = -np.inf

    def put(self, begins: bool, values: Values) -> None:
        """Rows of a run, the first of one where it `begins`."""
        time = values.get("time", np.zeros(1))
        if begins:
            same_quantities(self.quantities or values, values, self.files.given)
            self.quantities = tuple(values)
            self.runs.append((self.n, float(time[0]), float(time[-1])))
        else:
            self.runs[-1] = (*self.runs[-1][:2], float(time[-1]))
        contraction = contraction_of(values, self.specimen.initial_length_mm)
        kept = {k: v for k, v in values.items() if k not in ("displacement", "length", "slack")}
        kept["contraction"] = contraction
        if "slack" in values:
            keep = values["slack"] == 0.0
            self.masked += int((~keep).sum())
            kept = {key: column[keep] for key, column in kept.items()}
        for key, column in kept.items():
            self.on_disk.append(key, column.astype(KINDS.get(key, np.float64)))
        if len(kept["force"]):
            self.n += len(kept["force"])
            x = kept["contraction"] * self.specimen.initial_length_mm
            self.low, self.high = min(self.low, float(x.min())), max(self.high, float(x.max()))
            found = np.unique(np.round(kept.get("pressure_set", kept["pressure"]), 6), return_counts=True)
            for pressure, count in zip(*(part.tolist() for part in found), strict=True):
                self.pressures[pressure] = self.pressures.get(pressure, 0) + count

    def join(self) -> None:
        """Put a run whose clock began anew a pause after the one before."""
        if "time" not in self.quantities or len(self.runs) < 2:
            return
        edges = [*(begin for begin, _, _ in self.runs), self.n]
        ends = [(b, e) for b, e in pairwise(edges) if e > b + 1]
        pause = pause_between(self.on_disk.quantile("time", *ab, 1, 0.95) for ab in ends)
        before = self.runs[0][2]
        for k, (begin, first, last) in enumerate(self.runs[1:], 1):
            by = before + pause - first if first <= before else 0.0
            if by:
                self.on_disk.shift("time", begin, edges[k + 1], by)
            before = last + by

    def record(self, where: dict[str, str]) -> LongRecord:
        """All rows as a record, its motion followed where there is a time. Raises DataError where none is left."""
        if not self.n:
            raise nothing_left(self.files.given)
        self.join()
        pressures = np.array(sorted(self.pressures))
        counts = np.array([self.pressures[p] for p in pressures.tolist()])
        origin = self.files.given, files_sha256(self.files), where, self.masked
        isobars = pressures, nominal(pressures, counts)
        name = record_name(self.files, self.specimen)
        found = LongRecord(name, self.specimen, *origin, self.n, *isobars, self.on_disk)
        if "time" in self.quantities:
            given = tuple(name for name in ("branch", "cycle") if name in self.quantities)
            length = self.specimen.initial_length_mm
            keep_motion(self.on_disk, self.n, length, self.high - self.low, found.level, given)
        return found


def keep_motion(
    on_disk: Columns, n: int, length_mm: float, span: float, level: Callable[[int, int], Array], given: tuple[str, ...]
) -> None:
    """Find strokes, holds, cycles, segments and turns of `n` rows as `build_record` does, and keep each as a column
    (n,).

    `span` is the range of the motion in mm, `level` gives the nominal pressures of some rows, begin … end; `given`
    columns stand already.
    """

    def read(begin: int, end: int) -> tuple[Array, Array, Array, Array]:
        x = on_disk.read("contraction", begin, end) * length_mm
        return on_disk.read("time", begin, end), x, level(begin, end), on_disk.read("force", begin, end)

    begin, turn, noise = 0, 0, noise_on_disk(on_disk, n, length_mm)
    pause = long_pause(on_disk.quantile("time", 0, n, 1, 0.95))
    for fresh, found in follow(n, read, noise, span, pause):
        end = begin + len(found.stroke)
        track = read(begin, end)[1]
        begins = turns(track, found.stroke, found.segment)
        begins[0] |= fresh and begin > 0
        count = turn + np.cumsum(begins)
        columns = {name: getattr(found, name) for name in ("velocity", "stroke_speed", "moving", "stroke", "segment")}
        columns |= {"turn": count, "branch": found.direction, "cycle": found.cycle}
        for name in columns.keys() - set(given):
            on_disk.append(name, columns[name].astype(KINDS.get(name, np.float64)))
        begin, turn = end, int(count[-1])


def noise_on_disk(on_disk: Columns, n: int, length_mm: float) -> float:
    """`position_noise` of the whole record in mm."""
    count = _keep_roughness(on_disk, n, length_mm, timed=True) or _keep_roughness(on_disk, n, length_mm, timed=False)
    middle = on_disk.quantile("roughness", 0, count, 0, 0.5)
    on_disk.drop("roughness")
    return middle / NORMAL_MEDIAN


def _keep_roughness(on_disk: Columns, n: int, length_mm: float, timed: bool) -> int:
    """Keep the roughness of the track, by the clock or as of even rows, as a column; how many numbers it has."""
    count = 0
    for begin in range(0, n, STRETCH):
        end = min(begin + STRETCH + 4, n)
        x = on_disk.read("contraction", begin, end) * length_mm
        rough = roughness(x, on_disk.read("time", begin, end) if timed else None)
        on_disk.append("roughness", rough)
        count += len(rough)
    return count
