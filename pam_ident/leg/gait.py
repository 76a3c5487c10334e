"""Gait as smooth periodic functions: a few harmonics through a table of joint angles."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from ..core import DataError
from ..records.datasets import dataset_path
from .four_bar import Array, as_array

JOINTS = ("knee", "hip", "ankle")
PHASE = {"gait_percent": 100.0, "gait_percent_from_right_heel_contact": 100.0, "gait_fraction": 1.0}
"""Columns of phase by what they read at the end of a stride."""
ENOUGH_DEG = 0.5
"""A joint's rms deviation from its table at which no further harmonic is taken."""
MOST_HARMONICS = 10


class Swing(NamedTuple):
    """Angle, rate and acceleration of a joint, in rad, rad/s, rad/s²; any shape."""

    angle: Array
    rate: Array
    acceleration: Array


class LegAngles(NamedTuple):
    """Knee flexion φ, hip flexion ψ (thigh from the vertical, forward) and ankle angle α (dorsiflexion)."""

    knee: Swing
    hip: Swing
    ankle: Swing


@dataclass(frozen=True)
class Gait:
    """Angles over a stride as Fourier series in rad, `cadence_Hz` strides a second.

    `cosines` and `sines` hold a row per joint, in the order knee, hip, ankle, and a column per harmonic from the zeroth
    on; shape (3, harmonics + 1). `rms_deg` is each joint's deviation from the table it was fitted to.
    """

    name: str
    cadence_Hz: float
    cosines: np.ndarray = field(repr=False)
    sines: np.ndarray = field(repr=False)
    rms_deg: tuple[float, float, float]

    @property
    def harmonics(self) -> int:
        """How many harmonics the series have beside their means."""
        return self.cosines.shape[1] - 1

    def at(self, time_s: Array) -> LegAngles:
        """The motion at times of any shape, NumPy or JAX; derivatives are those of the series."""
        time = as_array(time_s)
        xp = time.__array_namespace__()
        rate = 2.0 * np.pi * self.cadence_Hz * np.arange(self.harmonics + 1.0)
        phase = time[..., None] * rate
        cos, sin = xp.cos(phase), xp.sin(phase)
        swings = []
        for c, s in zip(self.cosines, self.sines, strict=True):
            angle = xp.sum(c * cos + s * sin, axis=-1)
            first = xp.sum(rate * (s * cos - c * sin), axis=-1)
            swings.append(Swing(angle, first, -xp.sum(rate**2 * (c * cos + s * sin), axis=-1)))
        return LegAngles(*swings)


@dataclass(frozen=True)
class Window:
    """A stretch of time to be followed, s; the paper's is 0.2 s long."""

    start_s: float = 0.0
    duration_s: float = 0.2


def winter(cadence_Hz: float = 1.0) -> Gait:
    """The bundled stride of one adult (Winter, Table A.4)."""
    return read_gait(dataset_path("gait") / "winter_stride.csv", cadence_Hz)


def read_gait(path: str | Path, cadence_Hz: float | None = None) -> Gait:
    """A gait from a CSV file: a column of phase, `knee_deg` (or `knee_mean_deg`), perhaps `hip_deg` and `ankle_deg`.

    The phase is `gait_percent`, `gait_fraction` or `time_s`. Times are taken to cover exactly one stride, the last
    sample one step before the next stride begins; they give the cadence where none is given, else it is 1 Hz. A joint
    without a column rests at zero. Raises DataError for a file that does not hold that.
    """
    path = Path(path)
    try:
        table = pd.read_csv(path, skipinitialspace=True)
    except (OSError, UnicodeDecodeError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise DataError(f"{path}: cannot be read as a CSV table of a gait ({error}); check the file") from None
    table = table.rename(columns={"knee_mean_deg": "knee_deg"})
    phase, stride_Hz = _phase(path, table)
    if "knee_deg" not in table.columns:
        raise DataError(f"{path}: has no column knee_deg, only {', '.join(map(str, table.columns))}; name it so")
    angles = {j: np.radians(_numbers(path, table, f"{j}_deg")) for j in JOINTS if f"{j}_deg" in table.columns}
    cosines, sines, rms = _series(phase, angles)
    chosen = cadence_Hz if cadence_Hz is not None else stride_Hz
    if not (np.isfinite(chosen) and chosen > 0.0):
        raise DataError(f"{path}: a cadence of {chosen} Hz; expected a positive number of strides a second")
    return Gait(path.stem, float(chosen), cosines, sines, rms)


def _phase(path: Path, table: pd.DataFrame) -> tuple[np.ndarray, float]:
    """Phase (n,) of a stride from 0 to 1, and the cadence in Hz that goes with it."""
    found = [name for name in (*PHASE, "time_s") if name in table.columns]
    if len(found) != 1:
        raise DataError(
            f"{path}: holds {len(found)} columns of phase ({', '.join(found) or 'none'}); "
            "expected one of gait_percent, gait_fraction, time_s"
        )
    values = _numbers(path, table, found[0])
    if len(values) < 8:
        raise DataError(f"{path}: {len(values)} rows; expected at least 8 over a stride")
    steps = np.diff(values)
    if not np.all(steps > 0.0):
        row = int(np.argmin(steps > 0.0)) + 3
        raise DataError(f"{path}, row {row}: {found[0]} does not rise; sort the rows and leave out repeated ones")
    if found[0] == "time_s":
        stride = values[-1] - values[0] + float(np.mean(steps))
        return (values - values[0]) / stride, 1.0 / stride
    phase = values / PHASE[found[0]]
    if phase[0] < 0.0 or phase[-1] > 1.0 + 1e-9 or phase[-1] - phase[0] + steps.max() / PHASE[found[0]] < 0.95:
        raise DataError(
            f"{path}: {found[0]} runs from {values[0]:g} to {values[-1]:g}; expected one whole stride, "
            f"0 to {PHASE[found[0]]:g}"
        )
    return phase, 1.0


def _numbers(path: Path, table: pd.DataFrame, column: str) -> np.ndarray:
    values = np.asarray(pd.to_numeric(table[column], errors="coerce"), dtype=float)
    bad = ~np.isfinite(values)
    if bad.any():
        row = int(np.argmax(bad))
        raise DataError(f"{path}, row {row + 2}, column {column}: {table[column].iloc[row]!r}; expected a number")
    return values


def _series(
    phase: np.ndarray, angles: dict[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, tuple[float, float, float]]:
    """Least-squares series with the fewest harmonics that bring every joint within ENOUGH_DEG rms, if any do."""
    wanted = np.stack([angles.get(joint, np.zeros(len(phase))) for joint in JOINTS], axis=1)
    harmonics, found, rms = 0, wanted, np.full(3, np.inf)
    while rms.max() > ENOUGH_DEG and harmonics < min(MOST_HARMONICS, (len(phase) - 2) // 2):
        harmonics += 1
        turn = 2.0 * np.pi * phase[:, None] * np.arange(harmonics + 1)
        design = np.hstack([np.cos(turn), np.sin(turn[:, 1:])])
        found = np.linalg.lstsq(design, wanted, rcond=None)[0]
        rms = np.degrees(np.sqrt(np.mean((design @ found - wanted) ** 2, axis=0)))
    cosines, sines = found[: harmonics + 1], np.vstack([np.zeros((1, 3)), found[harmonics + 1 :]])
    return cosines.T, sines.T, (float(rms[0]), float(rms[1]), float(rms[2]))
