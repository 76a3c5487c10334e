"""Runs worth thinking of after a record: each varies one thing or two, and can be judged by itself."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..core import Inputs
from ..model import Model
from ..records import Record
from .schedule import one_speed
from .strokes import Strokes

HOLDS_S = (1.0, 10.0, 100.0)
LOOPS_MM = (1.0, 3.0, 10.0)
USUAL_MM_S = 10.0
"""Speed that a record without time is taken to have been made at."""
USUAL_MPA = 0.6
"""Pressure that muscles of this kind are usually rated for."""
WARMING_K, WARMING_MIN = 15.0, 10.0
SET_UP_MIN = 2.0
SHORTEST = 0.15
"""Share of the longest stroke below which a pressure is not worth running."""


@dataclass(frozen=True)
class PossibleRun:
    """A run on the rig: what it varies, in the words of the contract, its strokes, and its minutes, set-up included.

    `beyond` is the record's highest pressure in MPa where the run goes higher, else None.
    """

    vary: tuple[str, ...]
    strokes: Strokes
    beyond: float | None = None

    @property
    def cost(self) -> tuple[bool, float]:
        """What runs are put in order by: nobody knows whether the muscle bears more than it was given; and minutes."""
        return self.beyond is not None, self.minutes

    @property
    def minutes(self) -> float:
        """Rig time."""
        return SET_UP_MIN + self.strokes.seconds / 60.0 + (WARMING_MIN if self.strokes.warming_K else 0.0)


def possible_runs(record: Record, model: Model, values: dict[str, float]) -> list[PossibleRun]:
    """Runs built from a record's own pressures, stroke and speeds; `model` (a law alone) tells where a stroke ends.

    All have two speeds at least, so that what depends on speed stays apart from what does not in each by itself. There
    are none where noise alone moves the length.
    """
    plain = _plain(record)
    if plain is None:
        return []
    fast = plain.speeds_mm_s[-1]
    top = float(np.max(record.steady.pressure) if record.drives_pressure else record.levels[-1])
    few, spread = _over_5_to_1(top, 3), _over_5_to_1(top, 5)
    speed, pressure, hold, loops = ("speed",), ("pressure",), ("hold",), ("reversal",)
    decades = tuple(round_number(v) for v in np.geomspace(fast / 100.0, fast, 4))
    slow = tuple(round_number(v) for v in (fast / 40.0, fast / 10.0))
    found = [
        PossibleRun(speed, plain),
        PossibleRun(speed, replace(plain, speeds_mm_s=decades)),
        PossibleRun(pressure, replace(plain, pressures_MPa=few)),
        PossibleRun(pressure, replace(plain, pressures_MPa=spread)),
        PossibleRun(hold, replace(plain, hold_s=HOLDS_S)),
        PossibleRun(loops, replace(plain, speeds_mm_s=slow, minor_loops_mm=LOOPS_MM)),
        PossibleRun(("cycles",), replace(plain, speeds_mm_s=(round_number(fast / 4.0), fast), cycles_per_speed=10)),
        PossibleRun((*speed, *hold), replace(plain, speeds_mm_s=decades, hold_s=HOLDS_S)),
        PossibleRun((*pressure, *hold), replace(plain, pressures_MPa=spread, hold_s=HOLDS_S)),
    ]
    if (higher := min(2.0 * top, USUAL_MPA)) > top:
        runs = [replace(plain, pressures_MPa=_over_5_to_1(higher, count)) for count in (3, 5)]
        found += [PossibleRun(pressure, run, top) for run in runs]
    if record.inputs.temperature is not None:
        found.append(PossibleRun(("temperature",), replace(plain, warming_K=WARMING_K)))
    new = speed if one_speed(record) or record.inputs.velocity is None else ()
    found = [replace(c, vary=tuple(dict.fromkeys((*new, *c.vary)))) for c in found]
    return [replace(c, strokes=s) for c in found if (s := _within_reach(c.strokes, record, model, values)).tops_mm]


def _plain(record: Record) -> Strokes | None:
    """The least run that stands by itself: at most three of the record's pressures, two speeds a factor of 20 apart;
    None where no pressure has a stroke."""
    inputs = record.inputs
    x = record.as_measured.inputs.displacement_mm
    bottom = round(float(np.quantile(x, 0.01)), 1) + 0.0
    levels = [float(p) for p in record.levels]
    if not record.carried:
        levels = [p for p in levels if x[record.level == p].max() - bottom > SHORTEST * (x.max() - bottom)]
    if not levels:
        return None
    speeds = np.array([USUAL_MM_S])
    if inputs.stroke_speed is not None and inputs.moving is not None and inputs.moving.any():
        speeds = inputs.stroke_speed[inputs.moving]
    fast = round_number(max(4.0 * float(np.median(speeds)), float(np.quantile(speeds, 0.95))))
    pressures = tuple(float(f"{p:.2g}") for p in np.unique([levels[0], levels[len(levels) // 2], levels[-1]]))
    return Strokes(pressures, (), (round_number(fast / 20.0), fast), bottom_mm=bottom)


def _over_5_to_1(top: float, count: int) -> tuple[float, ...]:
    """Pressures from a fifth of the highest to it."""
    return tuple(float(f"{p:.2g}") for p in np.geomspace(top / 5.0, top, count))


def _within_reach(strokes: Strokes, record: Record, model: Model, values: dict[str, float]) -> Strokes:
    """The same with the end of the stroke at each pressure, less the pressures at which there is none to speak of.

    The order of the pressures is changed, lest they rise with time.
    """
    longest = float(np.max(record.as_measured.inputs.displacement_mm))
    order = strokes.pressures_MPa[1::2] + strokes.pressures_MPa[::2]
    ends = {p: _end(p, longest, record, model, values) for p in order}
    kept = tuple(p for p in order if ends[p] - strokes.bottom_mm > SHORTEST * (longest - strokes.bottom_mm))
    return replace(strokes, pressures_MPa=kept, tops_mm=tuple(ends[p] for p in kept))


def _end(pressure: float, longest: float, record: Record, model: Model, values: dict[str, float]) -> float:
    """Where a stroke ends at a pressure, in mm: where it did in the record, or where the law's force does."""
    measured = np.isclose(record.level, pressure, rtol=0.03)
    if measured.any() and not record.carried:
        end = float(np.max(record.inputs.displacement_mm[measured]))
    else:
        x = np.linspace(0.0, longest, 200)
        still = Inputs(np.full(200, pressure), x / record.specimen.initial_length_mm, record.specimen, np.ones(200))
        pulls = np.minimum.accumulate(model.force(still, values)) > 0.0
        end = float(x[pulls][-1]) if pulls.any() else 0.0
    return math.floor(10.0 * end + 1e-6) / 10.0


def round_number(value: float) -> float:
    """One significant digit: a speed one can set."""
    return float(f"{value:.1g}")
