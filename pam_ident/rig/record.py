"""From a plan to a record: one muscle, one run, what is hidden in it, what the sensors make of it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .drives import PROTOCOLS, Drive
from .hidden import Hidden, TooSmall, carry_over, draw_hidden, law_residual, rms
from .muscle import Array, RigMuscle, draw_muscle, draw_specimen
from .protocol import Protocol, RigRun
from .sensors import FAULTS, GAUGES, RigSensors, temperature_course

COLUMNS = ("time_s", "cycle", "pressure_set_MPa", "pressure_MPa", "displacement_mm", "force_N", "temperature_C")
DECIMALS = (4, 0, 3, 5, 4, 3, 2)
ATTEMPTS = 8
PIECE = 10_000
"""Rows that are written at a time."""


@dataclass(frozen=True)
class Secret:
    """What to hide: catalogue name, form of it, and what it shall leave, in multiples of the force noise."""

    name: str
    form: str = "textbook"
    ratio: float = 3.0


@dataclass(frozen=True)
class Plan:
    """Everything a record follows from; the same plan gives the same record.

    `protocol` is one of PROTOCOLS by name, on which effects are then sized, or a Protocol of one's own. There they have
    the size that they need in the standard protocol, so that a seed is the same muscle whatever is done with it.
    """

    seed: int
    law: str = "exponential_law"
    secrets: tuple[Secret, ...] = ()
    unknown: Secret | None = None
    protocol: str | Protocol | Drive = "standard"
    sigma_N: float = 2.0
    noise: str = "white"
    gauges: str = "good"
    fault: str | None = None
    warming: bool = False
    other_specimen: bool = False
    tier: int = 1

    def __post_init__(self) -> None:
        if isinstance(self.protocol, str) and self.protocol not in PROTOCOLS:
            raise ValueError(f"protocol {self.protocol!r}: the rig has {', '.join(PROTOCOLS)}")
        if not self.sigma_N > 0:
            raise ValueError(f"sigma_N = {self.sigma_N}: sizes are multiples of the noise, so there must be some")
        if self.gauges not in GAUGES or self.fault not in (None, *FAULTS):
            raise ValueError(f"gauges {self.gauges!r}, fault {self.fault!r}: of {list(GAUGES)} and {list(FAULTS)}")

    @property
    def driven(self) -> Protocol | Drive:
        """The protocol itself."""
        return PROTOCOLS[self.protocol] if isinstance(self.protocol, str) else self.protocol


@dataclass(frozen=True)
class RigRecord:
    """A finished record: table (n, 7) in the order of COLUMNS, muscle, what was hidden, key figures (N) without faults.

    noise_rms is what the true model leaves at the measured pressure and length, rmse_base what the law
    alone leaves at its best fit; `course` is the run, `added` (n,) what is hidden in its rows.
    """

    plan: Plan
    table: Array
    muscle: RigMuscle
    hidden: tuple[Hidden, ...]
    noise_rms: float
    rmse_base: float
    course: RigRun
    added: Array

    def column(self, name: str) -> Array:
        """One column by its name."""
        return self.table[:, COLUMNS.index(name)]


def _stream(seed: int, *path: int) -> np.random.Generator:
    """Streams that do not disturb each other: with or without an effect, the noise stays the same."""
    return np.random.default_rng([seed, *path])


def _hide(secret: Secret, place: int, plan: Plan, sized_on: RigRun, course: RigRun, muscle: RigMuscle) -> Hidden:
    for attempt in range(ATTEMPTS):
        path = (3, place, attempt)
        try:
            found = draw_hidden(
                secret.name, secret.form, sized_on, muscle, _stream(plan.seed, *path), secret.ratio * plan.sigma_N
            )
        except TooSmall:
            if attempt == ATTEMPTS // 2 - 1:
                secret = replace(secret, ratio=max(secret.ratio / 2, 0.7))
        else:
            return found if course is sized_on else carry_over(found, course, muscle, _stream(plan.seed, *path))
    raise TooSmall(f"{secret.name} ({secret.form}) cannot leave {secret.ratio:.2g} times the noise in this record")


def _run(plan: Plan, protocol: Protocol | Drive, muscle: RigMuscle, warming: bool) -> RigRun:
    course = protocol.run(muscle, _stream(plan.seed, 2))
    room = temperature_course(course.time, _stream(plan.seed, 4), warming)
    return replace(course, temperature=room + protocol.heating(course.time))


def make_record(plan: Plan) -> RigRecord:
    """Runs the rig; effects that act together are added up (their interplay is of second order)."""
    muscle = draw_muscle(_stream(plan.seed, 0), plan.law, draw_specimen(_stream(plan.seed, 1), plan.other_specimen))
    course = sized_on = _run(plan, plan.driven, muscle, plan.warming)
    if not isinstance(plan.protocol, str):
        sized_on = _run(plan, PROTOCOLS["standard"], muscle, True)
    secrets = plan.secrets + ((plan.unknown,) if plan.unknown else ())
    hidden = tuple(_hide(s, i, plan, sized_on, course, muscle) for i, s in enumerate(secrets))
    added = sum((h.force[course.rows] for h in hidden), np.zeros(len(course.rows)))
    table = _log(plan, course, muscle, added, _stream(plan.seed, 5))
    p_seen, eps_seen, force_seen = table[:, 3], table[:, 4] / course.length_mm, table[:, 5]
    noise = rms(force_seen - muscle.force(p_seen, eps_seen) - added)
    by_law = rms(law_residual(muscle, p_seen, eps_seen, force_seen))
    if plan.fault:
        FAULTS[plan.fault](table, _stream(plan.seed, 6))
    return RigRecord(plan, table, muscle, hidden, noise, by_law, course, added)


def _log(plan: Plan, course: RigRun, muscle: RigMuscle, added: Array, rng: np.random.Generator) -> Array:
    """What the sensors make of a run in which `added` (n,) is hidden, N: the table."""
    time, p, eps = course.time[course.rows], course.pressure[course.rows], course.eps[course.rows]
    level = np.full_like(p, np.nan)
    if isinstance(plan.driven, Protocol):
        levels = np.array(plan.driven.pressures_MPa)
        level = levels[np.argmin(np.abs(p[:, None] - levels), axis=1)]
    if course.load is not None:
        eps = muscle.contraction(p, course.load[course.rows] - added)
    sensors = RigSensors(plan.sigma_N, plan.noise, *GAUGES[plan.gauges])
    force = muscle.force(p, eps) + added + sensors.force_noise(time, p, rng)
    columns = (
        time,
        course.cycle[course.rows],
        level,
        p + sensors.pressure_MPa * rng.standard_normal(len(p)),
        eps * course.length_mm + sensors.displacement_mm * rng.standard_normal(len(p)),
        force,
        course.temperature[course.rows] + 0.01 * rng.standard_normal(len(p)),
    )
    return np.column_stack([np.round(c, d) for c, d in zip(columns, DECIMALS, strict=True)])


def repeats(record: RigRecord, times: int) -> Iterator[Array]:
    """The tables (n, columns) of the same run `times` over, the record's own first: the muscle rested, the noise fresh.

    The clock goes on, with the protocol's gap between two runs.
    """
    plan, course = record.plan, record.course
    lasts = course.time[-1] - course.time[0] + plan.driven.gap_s
    yield record.table
    for k in range(1, times):
        table = _log(plan, course, record.muscle, record.added, _stream(plan.seed, 5, k))
        table[:, 0] = np.round(table[:, 0] + k * lasts, DECIMALS[0])
        yield table


def write_case(folder: str | Path, record: RigRecord, times: int = 1) -> dict[str, object]:
    """Writes FOLDER/record.csv and FOLDER/specimen.toml; returns the line for truth.json.

    The run is written `times` over, one at a time, so that a record may be larger than memory.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    logged = [k for k, name in enumerate(COLUMNS) if not np.isnan(record.column(name)).all()]
    line = ",".join(f"%.{DECIMALS[k]}f" for k in logged) + "\n"
    unfinished = folder / ".record.csv"
    try:
        with unfinished.open("w", encoding="utf-8", newline="\n") as file:
            file.write(",".join(COLUMNS[k] for k in logged) + "\n")
            for table in repeats(record, times):
                for begin in range(0, len(table), PIECE):
                    piece = table[begin : begin + PIECE]
                    piece = piece[~np.isnan(piece[:, 0])][:, logged]
                    file.write((line * len(piece) % tuple(piece.ravel().tolist())).replace("nan", ""))
        unfinished.replace(folder / "record.csv")
    finally:
        unfinished.unlink(missing_ok=True)
    s, plan = record.muscle.specimen, record.plan
    (folder / "specimen.toml").write_text(
        f'[specimen]\nname = "{folder.name}"\ninitial_length_mm = {s.initial_length_mm}\n'
        f"initial_radius_mm = {s.initial_radius_mm}\nbraid_angle_deg = {s.braid_angle_deg}\n"
        f"wall_thickness_mm = {s.wall_thickness_mm}\n",
        encoding="utf-8",
    )
    return {
        "case": folder.name,
        "law": plan.law,
        "truth": sorted(x.name for x in plan.secrets),
        "unknown": plan.unknown.name if plan.unknown else None,
        "tier": plan.tier,
        "blunt": plan.protocol == "blunt",
        "sigma": plan.sigma_N,
        "noise_rms": record.noise_rms,
        "rmse_base": record.rmse_base,
        "n": times * len(record.table),
        "repeats": times,
        "forms": {h.name: h.form for h in record.hidden},
        "noise": plan.noise,
        "gauges": plan.gauges,
        "fault": plan.fault,
        "size_ratio": {h.name: h.left_N / plan.sigma_N for h in record.hidden},
        "sizes": {h.name: h.size for h in record.hidden},
        "settings": {h.name: h.settings for h in record.hidden},
        "protocol": plan.protocol if isinstance(plan.protocol, str) else "file",
        "driven": plan.driven.kind,
        "seed": plan.seed,
    }


def demo_plans(seed: int = 20, ratio: float = 3.0) -> tuple[Plan, Plan]:
    """A record with friction that follows pressure and contact area, and its twin with nothing hidden.

    Same muscle, same run, same noise; standard protocol, exponential law.
    """
    twin = Plan(seed, noise="white", sigma_N=2.0)
    return replace(twin, secrets=(Secret("pressure_friction", "contact_area", ratio),), tier=2), twin
