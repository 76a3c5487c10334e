"""Records with nothing hidden, under thirteen kinds of noise. The muscle and its run are the virtual rig's, which
shares no formula with the laws that are fitted."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from pam_ident.rig import Plan, make_record, write_case
from pam_ident.rig.protocol import Protocol
from pam_ident.rig.record import RigRecord
from pam_ident.rig.sensors import ornstein_uhlenbeck

Array = np.ndarray
LAWS = ("exponential_law", "modified_chou_hannaford")


@dataclass(frozen=True)
class Run:
    """What noise may hang on: time in s, pressure in MPa and the force's slope in N over contraction, all (n,)."""

    time: Array
    pressure: Array
    slope: Array


def _white(run: Run, rng: np.random.Generator) -> Array:
    return rng.standard_normal(len(run.time))


def _first_order(memory: float) -> Callable[[Run, np.random.Generator], Array]:
    def noise(run: Run, rng: np.random.Generator) -> Array:
        kicks = _white(run, rng)
        kicks[0] /= np.sqrt(1.0 - memory**2)
        return np.sqrt(1.0 - memory**2) * np.asarray(lfilter([1.0], [1.0, -memory], kicks))

    return noise


def _pink(run: Run, rng: np.random.Generator) -> Array:
    spectrum = np.fft.rfft(_white(run, rng))
    made = np.fft.irfft(spectrum / np.sqrt(np.maximum(np.arange(len(spectrum)), 1.0)), len(run.time))
    return made / made.std()


def _growing(with_what: str) -> Callable[[Run, np.random.Generator], Array]:
    def noise(run: Run, rng: np.random.Generator) -> Array:
        size = np.abs(getattr(run, with_what))
        return _white(run, rng) * (0.3 + 1.7 * size / size.max())

    return noise


def _heavy(run: Run, rng: np.random.Generator) -> Array:
    return rng.standard_t(3, len(run.time)) / np.sqrt(3.0)


def _wander(run: Run, rng: np.random.Generator) -> Array:
    share = rng.uniform(0.1, 0.3)
    slow = ornstein_uhlenbeck(run.time, rng.uniform(20.0, 100.0), rng)
    return np.sqrt(1.0 - share) * _white(run, rng) + np.sqrt(share) * slow


NOISES: dict[str, Callable[[Run, np.random.Generator], Array]] = {
    "white": _white,
    "quantised": _white,
    "static table": _white,
    "first order, 0.9": _first_order(0.9),
    "first order, 0.98": _first_order(0.98),
    "1/f": _pink,
    "growing with pressure": _growing("pressure"),
    "growing with slope": _growing("slope"),
    "noisy length sensor": _white,
    "noisy pressure sensor": _white,
    "short record": _white,
    "heavy tails": _heavy,
    "slow wander": _wander,
}


def protocol(kind: str, rng: np.random.Generator) -> Protocol:
    """A run of some 300 to 1500 rows, of a short record some 60 to 200."""
    speeds = tuple(np.round(np.geomspace(2.0, rng.uniform(10.0, 50.0), int(rng.integers(2, 4))), 1).tolist())
    pressures = tuple(np.round(np.linspace(0.1, rng.uniform(0.4, 0.6), int(rng.integers(3, 5))), 2).tolist())
    if kind == "short record":
        return Protocol(pressures[:3], speeds[:2], 1, hold_s=2.0, move_rows=int(rng.integers(5, 15)), hold_rows=2)
    rows = int(rng.integers(16, 32))
    return Protocol(pressures, speeds, int(rng.integers(2, 4)), hold_s=4.0, move_rows=rows, hold_rows=rows // 4)


def write_null(kind: str, folder: Path, rng: np.random.Generator) -> str:
    """Write a record of a kind and its specimen.toml into `folder`; the law that is true of it."""
    law = str(rng.choice(LAWS))
    plan = Plan(int(rng.integers(1 << 31)), law, protocol=protocol(kind, rng), sigma_N=float(rng.uniform(1.0, 4.0)))
    made = make_record(plan)
    write_case(folder, made)
    columns = _columns(kind, made, rng)
    header = "time_s,cycle,pressure_MPa,displacement_mm,force_N,temperature_C"
    if kind == "static table":
        header = "pressure_MPa,displacement_mm,force_N"
    np.savetxt(folder / "record.csv", columns, delimiter=",", header=header, comments="", fmt="%.7g")
    return law


def _columns(kind: str, made: RigRecord, rng: np.random.Generator) -> Array:
    """The table."""
    course, muscle, sigma = made.course, made.muscle, made.plan.sigma_N
    p, e, time = course.pressure[course.rows], course.eps[course.rows], course.time[course.rows]
    if kind == "static table":
        levels, lengths = np.unique(np.round(p, 2)), np.linspace(0.0, 0.2, int(rng.integers(8, 16)))
        p, e = (grid.ravel() for grid in np.meshgrid(levels, lengths, indexing="ij"))
        force = np.round(muscle.force(p, e) + sigma * rng.standard_normal(len(p)), 3)
        return np.column_stack([p, e * course.length_mm, force])
    slope = (muscle.force(p, e + 1e-4) - muscle.force(p, e - 1e-4)) / 2e-4
    noise = NOISES[kind](Run(time, p, slope), rng)
    force = muscle.force(p, e) + sigma * noise
    if kind == "quantised":
        step_N = sigma * rng.uniform(0.5, 3.0)
        force = np.round(force / step_N) * step_N
    off_mm = rng.uniform(0.05, 0.2) if kind == "noisy length sensor" else 0.01
    off_MPa = rng.uniform(0.001, 0.004) if kind == "noisy pressure sensor" else 0.0002
    seen_p, seen_x = p + off_MPa * _like(p, rng), e * course.length_mm + off_mm * _like(p, rng)
    warm = made.column("temperature_C")
    return np.column_stack([time, course.cycle[course.rows], seen_p, seen_x, force, warm])


def _like(x: Array, rng: np.random.Generator) -> Array:
    return rng.standard_normal(len(x))
