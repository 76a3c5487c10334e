"""A measured record, ready to be fitted."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..core import Array, DataError, Inputs, Specimen
from .isobars import as_driven, between, between_lengths, lengths_of, levels_of
from .kind import find_kind
from .motion import BAND, Motion, find_motion, moving_on
from .notes import Note
from .roughness import noise_in_steps
from .smoothing import calmed

KPA = 1e3
"""kPa a MPa: a pressure whose course is followed has numbers of the size of a length in mm."""
SLIGHT = 0.05
"""Least pull of the pressure at a length, of that at the length where it pulls most: never none, nor backwards."""
GIVE_MM_KN = 1.5
"""What threads and ends of a locked muscle give, so that its braid slides: of the size that series compliance has."""


@dataclass(frozen=True, eq=False)
class Record:
    """A measured record: force with the inputs of a force law at n samples, cut into isobars, strokes and blocks.

    Args:
        name: what it is called.
        inputs: pressure, contraction, direction, and time, speed, cycle and temperature where they were logged.
        force: measured force, N, shape (n,), positive in pull.
        level: nominal pressure of a sample's isobar, MPa, shape (n,).
        stroke: number of a sample's stroke, shape (n,), 0 in a table.
        block: what is held out whole, shape (n,): a cycle of a record in time, a length or an isobar of a table.
        steady: the inputs without the white noise of the pressure and displacement sensors, where a constant pressure
            and a smooth motion describe them to the noise. The diagnosis uses them: noise that goes through a force law
            is taken for physics.
        source, sha256, columns: where the record came from, its hash, and what was read as what.
        block_kind: `cycle`, `length` or `isobar`.
        passed: headers of the columns that were passed over.
        runs: what the runs of a record of several files are called, by number.
        masked: how many slack rows were left out.
        notes: what else was left out, or assumed, while it was read.
        said_kind: which kind of test it is said to be, empty where the data must show it (`kind`).
        metadata: what else is known of it (rig, calibration, operator, date, licence), as `metadata.toml` says.
        groups: of a record of several files the number of a sample's `run` and the length in mm of its `muscle`, (n,);
            its `cycle` as the file counts it.
        measured: the record as it was measured, where a load was held, the contraction is what a model predicts of it,
            and the force what the muscle would have there.

    Example:
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> record = read_record(dataset_record("hidden_effect"))
        >>> print(len(record), "samples at", record.levels, "MPa; a block is a", record.block_kind)
        4680 samples at [0.1 0.2 0.3 0.4 0.5] MPa; a block is a cycle
    """

    name: str
    inputs: Inputs
    force: Array
    level: Array
    stroke: Array
    block: Array
    steady: Inputs
    source: str = ""
    sha256: str = ""
    columns: dict[str, str] = field(default_factory=dict)
    block_kind: str = "cycle"
    masked: int = 0
    notes: tuple[Note, ...] = ()
    said_kind: str = ""
    metadata: Mapping[str, Any] = field(default_factory=dict)
    groups: Mapping[str, Array] = field(default_factory=dict)
    measured: "Record | None" = None
    passed: tuple[str, ...] = ()
    runs: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.force)

    @property
    def specimen(self) -> Specimen:
        """Geometry of the muscle."""
        return self.inputs.specimen

    @property
    def carried(self) -> bool:
        """Whether the contraction is what a model predicts under a held load."""
        return self.measured is not None

    @property
    def as_measured(self) -> "Record":
        """The record as it was measured: itself unless it is `carried`."""
        return self.measured or self

    @property
    def drives_pressure(self) -> bool:
        """Whether the pressure was driven, and the length or the load held."""
        return self.as_measured.kind in ("isometric", "isotonic")

    @property
    def run(self) -> Array:
        """Number of the run, one of several files, that a sample belongs to, shape (n,); 0 where there is one."""
        return self.groups.get("run", np.zeros(len(self), int))

    def run_name(self, run: int) -> str:
        """What a run of a record of several files is called."""
        return self.runs[run] if self.runs else f"run {run + 1}"

    @cached_property
    def levels(self) -> Array:
        """The isobars' nominal pressures in MPa, ascending."""
        return np.unique(self.level)

    @cached_property
    def kind(self) -> str:
        """`isobaric`, `isometric`, `isotonic` or `dynamic`: as was said (`kind` in specimen.toml or columns.toml), or
        as the data show it."""
        inputs = self.inputs
        columns = (inputs.pressure, inputs.contraction, self.force, self.level)
        return self.said_kind or find_kind(self.specimen, *columns, inputs.time is not None)

    @cached_property
    def turn(self) -> Array:
        """Number of the turn a sample belongs to, from the middle of a stroke to the middle of the next, shape (n,).

        All 0 in a static table.
        """
        if self.inputs.segment is None:
            return np.zeros(len(self), int)
        return np.cumsum(turns(self.inputs.displacement_mm, self.stroke, self.inputs.segment))

    def take(self, rows: Array) -> "Record":
        """Some of the samples, by index, in order."""
        inputs = self.inputs.take(rows)
        steady = inputs if self.steady is self.inputs else self.steady.take(rows)
        parts = {name: getattr(self, name)[rows] for name in ("force", "level", "stroke", "block")}
        groups = {name: group[rows] for name, group in self.groups.items()}
        return replace(self, inputs=inputs, steady=steady, groups=groups, **parts)

    def in_tenths(self) -> "Record":
        """With tenths of the pressure for levels where that was driven; itself where it was held."""
        if self.as_measured.kind == "isobaric":
            return self
        p = self.inputs.pressure
        edges = np.linspace(p.min(), p.max(), 11)
        part = np.clip(np.searchsorted(edges, p, side="right") - 1, 0, 9)
        return replace(self, level=(0.5 * (edges[1:] + edges[:-1]))[part].round(4))

    def branch_rows(self, branch: str) -> Array:
        """Mask of the samples of `contraction`, `extension` or `together` (all).

        Raises DataError when the record does not hold that branch.
        """
        rows = self.on_branch(branch)
        if not rows.any():
            raise DataError(
                f"{self.source or self.name}: no {branch} branch in the record; give a `branch` or `time_s` column, "
                "or fit with --branch together"
            )
        return rows

    def on_branch(self, branch: str) -> Array:
        """The same mask, which may be of no samples."""
        if branch == "together":
            return np.ones(len(self), bool)
        return self.inputs.direction == {"contraction": 1.0, "extension": -1.0}[branch]


def build_record(
    name: str,
    specimen: Specimen,
    pressure: Array,
    contraction: Array,
    force: Array,
    *,
    time: Array | None = None,
    level: Array | None = None,
    cycle: Array | None = None,
    direction: Array | None = None,
    temperature: Array | None = None,
    said_kind: str = "",
    **origin: object,
) -> Record:
    """Find strokes, holds, cycles and isobars in measured columns (all of shape (n,), internal units).

    `direction` overrides the branch found from the motion, `said_kind` the kind of test found from the columns. Raises
    DataError when time runs backwards.
    """
    given, level = level, levels_of(pressure if level is None else level)
    origin["said_kind"] = said_kind
    if time is None:
        unknown = np.zeros(len(force)) if direction is None else direction
        states = Inputs(pressure, contraction, specimen, unknown, temperature=temperature)
        return _table(name, states, force, level, origin)
    kind = said_kind or find_kind(specimen, pressure, contraction, force, level, timed=True)
    if given is None and kind in ("isobaric", "dynamic"):
        way = between(pressure, contraction)
        joined = as_driven(level, pressure, contraction, way)
        held = (values[~way] for values in (pressure, contraction, force, joined))
        if joined is not level and (said_kind or find_kind(specimen, *held, timed=True)) == "isobaric":
            kind, level = "isobaric", joined
    slide, driven, locked = None, None, kind == "isometric"
    if locked:
        way = between_lengths(pressure, contraction)
        held = lengths_of(contraction, pressure, way)
        driven = find_motion(time, KPA * pressure, held, force)
        per_kpa = _per_kpa(specimen, held)
        parts = {name: per_kpa * getattr(driven, name) for name in ("velocity", "stroke_speed", "position")}
        motion = replace(driven, **parts)
        slide = held + per_kpa * KPA * pressure / specimen.initial_length_mm
    else:
        loaded = kind in ("isotonic", "dynamic")
        held = np.zeros(len(level)) if loaded else level
        driven = find_motion(time, KPA * pressure, held) if loaded else None
        x = contraction * specimen.initial_length_mm
        motion = find_motion(time, x, held, None if kind == "isotonic" else force)
        if kind == "dynamic":
            assert driven is not None
            noise = noise_in_steps(x, time)
            motion = moving_on(motion, time, x, noise)
            motion = _of_the_braid(motion, driven, _per_kpa(specimen, contraction), BAND * noise)
    segment, cycle = motion.segment, motion.cycle if cycle is None else counted_anew(cycle, held)
    inputs = Inputs(
        pressure=pressure,
        contraction=contraction,
        specimen=specimen,
        direction=motion.direction if direction is None else direction,
        time=time,
        velocity=motion.velocity,
        stroke_speed=motion.stroke_speed,
        moving=motion.moving,
        cycle=cycle.astype(float),
        temperature=temperature,
        segment=segment,
        slide=slide,
        locked=locked,
        pressure_rate=None if driven is None else driven.velocity / KPA,
    )
    _, number = np.unique(cycle.astype(int), return_inverse=True)
    _, block = np.unique(segment * (number.max() + 1) + number, return_inverse=True)
    run = np.cumsum((np.diff(motion.stroke, prepend=0) != 0) | np.diff(motion.moving, prepend=False))
    smooth = motion.position / specimen.initial_length_mm + (held if locked else 0.0)
    steady = calmed(pressure, segment, time, run) if driven is None else driven.position / KPA
    if locked:
        calm = replace(inputs, pressure=steady, contraction=held, slide=smooth)
    else:
        calm = replace(inputs, pressure=steady, contraction=smooth)
    return Record(name, inputs, force, level, motion.stroke, block, calm, **origin)  # type: ignore[arg-type]


def counted_anew(cycle: Array, held: Array) -> Array:
    """Cycles (n,) from 1 on; those that were counted to the end of a test anew wherever what is `held` (n,) changes,
    unless nothing comes back.

    Who counts on does not say that the rubber did not rest: `cycles_of_test` counts on in any case.
    """
    if cycle.min() < 1:
        cycle = cycle - cycle.min() + 1
    begins = np.r_[True, np.diff(held) != 0.0]
    if np.any(np.diff(cycle) < 0):
        return cycle
    anew = cycle - cycle[np.maximum.accumulate(np.where(begins, np.arange(len(cycle)), 0))] + 1
    return anew if anew.max() > 1 else cycle


def _per_kpa(specimen: Specimen, contraction: Array) -> Array:
    """How far the braid slides by the pressure in mm/kPa at contractions, each (n,)."""
    pull = specimen.ideal_force(np.ones(len(contraction)), contraction)  # N/MPa; of the specimen: states have no force
    return 1e-3 * GIVE_MM_KN / KPA * np.maximum(pull, SLIGHT * pull.max())


def _of_the_braid(motion: Motion, driven: Motion, per_kpa: Array, unseen: float) -> Motion:
    """The motion of a braid that slides with the length or, where that rests, with the pressure, by mm/kPa (n,), if
    that is farther than the length may move `unseen`, in mm.

    How far it slides there is too unsure to be added to the way, or to win where both drive it; strokes are the
    length's."""
    rows = np.arange(len(per_kpa))
    begins = np.flatnonzero((np.diff(motion.moving, prepend=2) != 0) | (np.diff(driven.stroke, prepend=-1) != 0))
    slid = per_kpa * driven.position
    way = np.maximum.reduceat(slid, begins) - np.minimum.reduceat(slid, begins)
    far = np.repeat(way, np.diff(np.r_[begins, len(rows)])) >= unseen
    only = driven.moving & ~motion.moving & far
    moving = motion.moving | only
    last = np.maximum.accumulate(np.where(moving, rows, 0))  # a rest keeps the direction before it
    last = np.where(moving[last] & (motion.segment[last] == motion.segment), last, rows)
    direction = np.where(only, driven.direction, motion.direction)[last]
    velocity = np.where(only, per_kpa * driven.velocity, motion.velocity)
    speed = np.where(only, per_kpa * driven.stroke_speed, motion.stroke_speed)
    return replace(motion, moving=moving, direction=direction, velocity=velocity, stroke_speed=speed)


def rebuilt(record: Record, specimen: Specimen, said_kind: str = "") -> Record:
    """The record as measured on another specimen, with the same displacement and so another contraction, or as another
    kind of test."""
    inputs = record.inputs
    made = build_record(
        record.name,
        specimen,
        inputs.pressure,
        inputs.displacement_mm / specimen.initial_length_mm,
        record.force,
        time=inputs.time,
        level=record.level,
        cycle=inputs.cycle,
        direction=inputs.direction if inputs.direction.any() else None,
        temperature=inputs.temperature,
        said_kind=said_kind or record.said_kind,
    )
    kept = ("source", "sha256", "columns", "masked", "notes", "metadata", "groups", "passed", "runs")
    return replace(made, **{key: getattr(record, key) for key in kept})


def turns(x: Array, stroke: Array, segment: Array) -> Array:
    """Mask (n,) of the samples that begin a turn: first half across a stroke, x (n,) in mm, or first in a segment."""
    run = np.r_[0, np.cumsum(np.diff(stroke) != 0)]
    begins = np.flatnonzero(np.diff(run, prepend=-1))
    gone = np.abs(x - x[begins[run]])
    across = np.flatnonzero(gone >= 0.5 * np.maximum.reduceat(gone, begins)[run])
    found = np.r_[False, np.diff(segment) != 0]
    found[across[np.searchsorted(run[across], np.arange(len(begins)))]] = True
    return found


def _table(name: str, inputs: Inputs, force: Array, level: Array, origin: dict[str, object]) -> Record:
    """A static table: no time, so no speed; blocks are its lengths, or its isobars where each length is its own."""
    rounded = np.round(inputs.contraction, 4)
    by_length = len(np.unique(rounded)) <= max(12, len(force) // 6)
    _, block = np.unique(rounded if by_length else level, return_inverse=True)
    kind = "length" if by_length else "isobar"
    return Record(name, inputs, force, level, np.zeros(len(force), int), block, inputs, block_kind=kind, **origin)  # type: ignore[arg-type]
