"""Whether the runs of a record are measured alike: a unit, a zero or a length that is wrong in one file of several."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple, Self

import numpy as np

from ..core import Array
from ..core.digits import percent
from ..core.units import ATMOSPHERE_MPA
from .doubt import Doubt
from .record import Record

UNITS: Mapping[str, Mapping[float, str]] = {
    "force": {4.448222: "lbf and N", 9.80665: "kgf and N", 1000.0: "kN and N"},
    "pressure": {
        6.894757: "psi and kPa",
        10.0: "bar and MPa",
        14.50377: "psi and bar",
        100.0: "kPa and bar",
        145.0377: "psi and MPa",
        1000.0: "kPa and MPa",
    },
    "displacement": {10.0: "cm and mm", 25.4: "inches and mm", 100.0: "per cent and ratio", 1000.0: "m and mm"},
}
"""Factor between two units that are taken for each other."""
LENGTHS = tuple(np.exp(np.linspace(-0.7, 0.7, 57)).tolist())
"""Initial lengths beside the specimen's that a run is tried with: any within a factor of two, by steps of 2.5 %."""
SAME_LENGTH = 0.09
"""Logarithm of such a length from which the lengths of two runs differ."""
CLEARED, STEP = 1.0 / 3.0, 0.75
"""What a smooth surface leaves of all runs (rms) beside what it left before: at most, once the slips are put right, and
after each of them. Of 680 records with effects, each isobar or length taken for a run, none falls below a third."""
ALSO = 1.5
"""Beside what the best correction leaves, what another may that is told with it."""
ROWS, ROWS_A_RUN = 3000, 60
"""Rows that are looked at, in all and of a run."""
MOVES, LEAST_STROKE = 0.3, 0.01
"""Range of the contraction of a run, beside the longest of all runs and in all, from which its course tells a unit or a
length of it: where a length is held, a smooth surface goes through any few of them."""
LEAST_MPA, MOST_MPA, FARTHEST = -0.02, 2.0, 1.0
"""Pressures and the contraction beyond which a correction is none."""


class Run(NamedTuple):
    """Pressure in MPa, contraction, force in N and direction of some samples of a run, each (n,); `weight` undoes what
    a correction makes of the size of the force."""

    pressure: Array
    contraction: Array
    force: Array
    direction: Array
    weight: float = 1.0

    def gram(self) -> Array:
        """Products (10, 10) of the columns of a smooth surface, and of the force as the last of them."""
        p, e = self.pressure, self.contraction
        one = np.ones_like(p)
        columns = [p, p * e, p * e * e, one, e, e * e, e**3, self.direction, self.direction * p, self.force]
        found = self.weight * np.column_stack(columns)
        return found.T @ found

    def scaled(self, column: str, by: float) -> Self:
        """With other numbers in one column; a residual of the force counts as before."""
        if column == "force":
            return self._replace(force=by * self.force, weight=self.weight / abs(by))
        if column == "pressure":
            return self._replace(pressure=by * self.pressure)
        return self._replace(contraction=by * self.contraction)

    @property
    def possible(self) -> bool:
        """Whether a muscle can be in these states."""
        p, e = self.pressure, self.contraction
        return bool(p.min() > LEAST_MPA and p.max() < MOST_MPA and np.abs(e).max() < FARTHEST)


class Slip(NamedTuple):
    """A correction of a run: `code` and `column` of its doubt, what it changes in `words` and `why` that may be so; or
    the length of its muscle beside the specimen's."""

    code: str
    column: str
    words: str = ""
    why: str = ""
    length: float = 1.0


class Made(NamedTuple):
    """The corrections that a run may need, the likeliest first, and the runs of which one would do as well."""

    slips: list[Slip]
    rivals: list[int]


def doubt_runs(record: Record) -> Iterator[Doubt]:
    """A grave doubt for each run that is at odds with the others, and would not be with another unit, zero or length.

    One smooth surface of pressure and contraction, with a friction, is fitted to all runs by least squares. The
    correction of a run after which it leaves least is made, then the next, as long as each clears up a part.
    """
    runs = _runs(record)
    if len(runs) < 2:
        return
    gram = {k: run.gram() for k, run in runs.items()}
    stroke = max(float(np.ptp(run.contraction)) for run in runs.values())
    first = left = _left(sum(gram.values()))
    made: dict[int, Made] = {}
    while len(made) < len(runs):
        total = sum(gram.values())
        found = [
            (_left(total - gram[k] + tried.gram()), k, slip, tried)
            for k, run in runs.items()
            if k not in made
            for slip, tried in _tried(run, stroke)
        ]
        least, k, slip, tried = min(found, key=lambda one: one[0], default=(np.inf, 0, None, None))
        if tried is None or not least < STEP * left:
            break
        near = [(run, other) for rest, run, other, _ in found if rest < ALSO * least]
        also = [other for run, other in near if run == k and other.length == 1.0 and other is not slip]
        made[k] = Made([slip, *also], sorted({run for run, _ in near} - {k}))
        left, runs[k], gram[k] = least, tried, tried.gram()
    if left < CLEARED * first:
        yield from _told(record, made, left / first)


def _runs(record: Record) -> dict[int, Run]:
    """The runs of a record of several, by number, each thinned."""
    number = record.groups.get("run", np.zeros(len(record), int))
    different = np.unique(number)
    most = max(min(ROWS_A_RUN, ROWS // len(different)), 8)
    found = {}
    for k in different:
        rows = np.flatnonzero(number == k)
        rows = rows[np.unique(np.linspace(0, len(rows) - 1, most).astype(int))]
        states = record.inputs.pressure, record.inputs.contraction, record.force, record.inputs.direction
        found[int(k)] = Run(*(one[rows].astype(float) for one in states))
    return found


def _left(gram: Array) -> float:
    """What the surface leaves of the force: the root of its sum of squares."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    scaled = gram / np.outer(scale, scale)
    solution = np.linalg.lstsq(scaled[:-1, :-1], scaled[:-1, -1], rcond=1e-10)[0]
    return float(scale[-1] * np.sqrt(max(1.0 - scaled[:-1, -1] @ solution, 0.0)))


def _tried(run: Run, stroke: float) -> Iterator[tuple[Slip, Run]]:
    """The corrections of a run that leave it possible, and the run with each; those of the contraction where it then
    moves by a good part of the longest `stroke`."""
    for slip, tried in _corrections(run):
        if slip.length != 1.0 and not np.ptp(tried.contraction) > max(MOVES * stroke, LEAST_STROKE):
            continue
        if tried.possible:
            yield slip, tried


def _corrections(run: Run) -> Iterator[tuple[Slip, Run]]:
    for column, units in UNITS.items():
        code = "displacement_scale" if column == "displacement" else "scale"
        for factor, words in units.items():
            for by in (factor, 1.0 / factor):
                slip = Slip(code, column, f"its {column} times {by:.3g}", f"{words} taken for each other")
                yield slip, run.scaled(column, by)
    for column in ("force", "displacement"):
        slip = Slip(f"{column}_sign", column, f"its {column} with the other sign", "counted the other way")
        yield slip, run.scaled(column, -1.0)
    for by, words, why in ((-ATMOSPHERE_MPA, "less", "absolute"), (ATMOSPHERE_MPA, "more", "the others' absolute")):
        slip = Slip("pressure_absolute", "pressure", f"{ATMOSPHERE_MPA:.4f} MPa {words} on its pressure", why)
        yield slip, run._replace(pressure=run.pressure + by)
    for length in LENGTHS:
        if abs(np.log(length)) > SAME_LENGTH:
            slip = Slip("displacement_scale", "displacement", length=length)
            yield slip, run.scaled("displacement", 1.0 / length)


def _told(record: Record, made: dict[int, Made], share: float) -> Iterator[Doubt]:
    """The doubts of runs whose corrections leave a `share` of what there was."""
    runs, own = np.unique(record.groups["run"]), record.specimen.initial_length_mm
    # Only beside each other: of all runs alike a smooth surface tells no length.
    usual = float(np.median([made[k].slips[0].length if k in made else 1.0 for k in runs]))
    for k, (slips, rivals) in made.items():
        first, *others = (record.runs[run] if record.runs else f"run {run + 1}" for run in (k, *rivals))
        text = f"{' or '.join((first, *others))} is at odds with the other runs"
        length = slips[0].length / usual
        if slips[0].length == 1.0:
            words = ", or with ".join(f"{one.words} ({one.why})" for one in slips)
            text = f"{text}, and {f'{first} ' if others else ''}would agree with {words}"
        elif abs(np.log(length)) < SAME_LENGTH:
            continue
        else:
            mm = f"about {own * length:.0f} mm{f' for {first}' if others else ''}, not {own:g}, would agree"
            text = (
                f"{text} over the length of the muscle: {mm}. Check initial_length_mm of each ([runs] in columns.toml)"
            )
        text = f"{text}. What a smooth surface leaves of all runs would fall to {percent(share)}."
        yield Doubt(slips[0].code, text, slips[0].column, True)
