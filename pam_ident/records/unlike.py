"""Whether the runs of a record are measured alike: a unit, a zero or a length that is wrong in one file of several."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from operator import itemgetter
from typing import NamedTuple, Self

import numpy as np

from ..core import Array
from ..core.digits import newtons, percent
from ..core.units import ATMOSPHERE_MPA
from .doubt import Doubt
from .plausible import BURST_MPA
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
LENGTHS = np.exp(np.linspace(-0.7, 0.7, 29))
"""Initial lengths beside the specimen's that a run is tried with; what is between is found afterwards."""
ZEROS = np.linspace(-0.3, 0.3, 31)
"""Contractions that may have been added to those of a run, likewise."""
FORCES = np.linspace(-1.0, 1.0, 41)
"""Forces that may have been added to those of a run, in standard deviations of its force, likewise."""
SAME_LENGTH, SAME_ZERO, SAME_FORCE = 0.09, 0.03, 0.04
"""Logarithm of such a length, such a contraction, and such a force, from which two runs differ."""
CLEARED, STEP = 1.0 / 3.0, 0.75
"""What a smooth surface leaves of all runs (rms) beside what it left before: at most, once the slips are put right, and
after each of them. The first holds of what the other runs foretell of one that was put right, too."""
AS_ALIKE = 3.0
"""Error of what the other runs foretell of one that was put right, beside what they leave of each other, at most."""
FORETOLD = 0.3
"""The same beside the standard deviation of the run's force: a surface that says nothing of it puts nothing right."""
ALSO = 1.5
"""Beside what the best correction leaves, what another may that is told with it."""
MOST = 3
"""Corrections of one run that are told."""
USUAL = (("length", 1.0), ("zero", 0.0))
LEFT = "What a smooth surface leaves of all runs would fall to"
ROWS, ROWS_A_RUN = 3000, 60
"""Rows that are looked at, in all and of a run."""
VARIED = 0.3
"""Range of a run's pressure beside its largest from which a zero of the force is no zero of the length."""
LEAST_MPA, FARTHEST = -0.02, 1.0
"""Pressure and contraction beyond which a correction is none."""


class Run(NamedTuple):
    """Pressure in MPa, contraction, force in N and direction of some samples of a run, each (n,); `weight` undoes what
    a correction makes of the size of the force."""

    pressure: Array
    contraction: Array
    force: Array
    direction: Array
    weight: float = 1.0

    def columns(self) -> Array:
        """The columns of a smooth surface, and the force as the last of them, (n, 10)."""
        p, e = self.pressure, self.contraction
        one = np.ones_like(p)
        surface = [p, p * e, p * e * e, one, e, e * e, e**3, self.direction, self.direction * p]
        return np.column_stack([*surface, self.force])

    def gram(self) -> Array:
        """Their products, weighted, (10, 10)."""
        columns = self.weight * self.columns()
        return columns.T @ columns

    def scaled(self, column: str, by: float) -> Self:
        """With other numbers in one column; a residual of the force counts as before."""
        if column == "force":
            return self._replace(force=by * self.force, weight=self.weight / abs(by))
        if column == "pressure":
            return self._replace(pressure=by * self.pressure)
        return self._replace(contraction=by * self.contraction, direction=np.sign(by) * self.direction)

    def with_length(self, length: float) -> Self:
        """With another initial length of the muscle, beside the specimen's."""
        return self.scaled("displacement", 1.0 / length)

    def with_zero(self, zero: float) -> Self:
        """Without a contraction that was added to its own."""
        return self._replace(contraction=self.contraction - zero)

    def with_force(self, newtons: float) -> Self:
        """Without a force in N that was added to its own."""
        return self._replace(force=self.force - newtons)

    @property
    def possible(self) -> bool:
        """Whether a muscle can be in these states."""
        p, e = self.pressure, self.contraction
        return bool(p.min() > LEAST_MPA and p.max() < BURST_MPA and np.abs(e).max() < FARTHEST)


class Slip(NamedTuple):
    """A correction of a run: `code` and `column` of its doubt, what it changes in `words` and `why` that may be so; or
    the `length` of its muscle beside the specimen's, or the `zero` of its contraction, or of its force in N."""

    code: str
    column: str
    words: str = ""
    why: str = ""
    length: float = 1.0
    zero: float = 0.0
    newtons: float = 0.0

    @property
    def free(self) -> bool:
        """Whether it is one of many that differ by a number alone."""
        return self.length != 1.0 or self.zero != 0.0 or self.newtons != 0.0

    def nearer(self, run: Run, rest: "Surface") -> tuple[Self, Run]:
        """Of a free one the number by which others foretell a run best, and that run put right."""
        if self.length != 1.0:
            length = _least(lambda log: rest.error(run.with_length(np.exp(log))), np.log(LENGTHS))
            return self._replace(length=float(np.exp(length))), run.with_length(np.exp(length))
        if self.newtons != 0.0:
            by = _least(lambda by: rest.error(run.with_force(by)), FORCES * float(np.std(run.force)))
            return self._replace(newtons=by), run.with_force(by)
        zero = _least(lambda zero: rest.error(run.with_zero(zero)), ZEROS)
        return self._replace(zero=zero), run.with_zero(zero)


def _least(error: Callable[[float], float], grid: Array) -> float:
    """Where an error is least, begun at the best of a grid (n,), and looked for between its neighbours."""
    for _ in range(3):
        best, step = grid[int(np.argmin([error(one) for one in grid]))], grid[1] - grid[0]
        grid = best + step * np.linspace(-1.0, 1.0, 11)
    return float(grid[5])


class Made(NamedTuple):
    """The corrections that a run may need, the likeliest first, and the runs of which one would do as well."""

    slips: list[Slip]
    rivals: list[int]


def doubt_runs(record: Record) -> Iterator[Doubt]:
    """A grave doubt for each run that is at odds with the others, and would not be with another unit, zero or length.

    One smooth surface of pressure and contraction, with a friction, is fitted to all runs by least squares. The
    correction of a run after which it leaves least is made, then the next, as long as each clears up a part. It counts
    where the surface of the runs that stay as they are foretells those that were put right.
    """
    runs = _runs(record)
    if len(runs) < 2 or record.kind == "isotonic":  # there the force is a run's own, and says nothing of it
        return
    made, put_right = _put_right(runs)
    if not made:
        return
    rest = Surface([run for k, run in runs.items() if k not in made])
    for k, (slips, rivals) in made.items():
        if slips[0].free:
            slip, put_right[k] = slips[0].nearer(runs[k], rest)
            made[k] = Made([slip], rivals)
    left = _left([*(run for k, run in runs.items() if k not in made), *put_right.values()]) / _left(runs.values())
    if left < CLEARED and all(rest.confirms(runs[k], run) for k, run in put_right.items()):
        yield from _told(record, made, left)


def _put_right(runs: Mapping[int, Run]) -> tuple[dict[int, Made], dict[int, Run]]:
    """The corrections of each run at odds with the others, and those runs put right."""
    runs, made = dict(runs), {}
    gram = {k: run.gram() for k, run in runs.items()}
    left = _left(runs.values())
    while len(made) < len(runs) - 1:
        total = np.sum(list(gram.values()), axis=0)
        found = [
            (_leaves(total - gram[k] + tried.gram()), k, slip, tried)
            for k, run in runs.items()
            if k not in made
            for slip, tried in _corrections(run)
            if tried.possible
        ]
        best = min(found, key=itemgetter(0), default=None)
        if best is None or not best[0] < STEP * left:
            break
        least, k, slip, tried = best
        near = [(run, other) for rest, run, other, _ in found if rest < ALSO * least]
        also = [other for run, other in near if run == k and not other.free and other is not slip]
        made[k] = Made([slip, *also[: MOST - 1]], sorted({run for run, _ in near} - {k}))
        left, runs[k], gram[k] = least, tried, tried.gram()
    return made, {k: runs[k] for k in made}


class Surface:
    """A smooth surface by some runs, and what they leave of each other (rms, N)."""

    def __init__(self, runs: list[Run]) -> None:
        columns = np.vstack([run.columns() for run in runs])
        self.scale = np.maximum(np.linalg.norm(columns[:, :-1], axis=0), 1e-300)
        self.solution = np.linalg.lstsq(columns[:, :-1] / self.scale, columns[:, -1], rcond=1e-6)[0]
        self.left = self._off(columns)

    def error(self, run: Run) -> float:
        """Error of what it foretells of a run (rms, N)."""
        return self._off(run.columns())

    def _off(self, columns: Array) -> float:
        return float(np.sqrt(np.mean((columns[:, -1] - columns[:, :-1] / self.scale @ self.solution) ** 2)))

    def confirms(self, recorded: Run, put_right: Run) -> bool:
        """Whether it foretells a run that was put right, about as well as its own, and not the run as recorded."""
        most = min(CLEARED * self.error(recorded), AS_ALIKE * self.left, FORETOLD * float(np.std(put_right.force)))
        return self.error(put_right) < most


def _runs(record: Record) -> dict[int, Run]:
    """The runs of a record of several, by number, each thinned."""
    number = record.run
    different = np.unique(number)
    most = max(min(ROWS_A_RUN, ROWS // len(different)), 8)
    found = {}
    for k in different:
        rows = np.flatnonzero(number == k)
        rows = rows[np.unique(np.linspace(0, len(rows) - 1, most).astype(int))]
        inputs = record.inputs.take(rows)
        found[int(k)] = Run(inputs.pressure, inputs.contraction, record.force[rows], inputs.direction)
    return found


def _left(runs: Iterable[Run]) -> float:
    """What the surface leaves of the force of some runs: the root of its sum of squares, N."""
    return max(_leaves(np.sum([run.gram() for run in runs], axis=0)), 1e-300)


def _leaves(gram: Array) -> float:
    """The same by the products (10, 10) of the columns of all."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    scaled = gram / np.outer(scale, scale)
    solution = np.linalg.lstsq(scaled[:-1, :-1], scaled[:-1, -1], rcond=1e-10)[0]
    return float(scale[-1] * np.sqrt(max(1.0 - scaled[:-1, -1] @ solution, 0.0)))


def _corrections(run: Run) -> Iterator[tuple[Slip, Run]]:
    """The corrections of a run, and the run with each."""
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
    for length in LENGTHS[np.abs(np.log(LENGTHS)) > SAME_LENGTH]:
        yield Slip("displacement_scale", "displacement", length=float(length)), run.with_length(length)
    for zero in ZEROS[np.abs(ZEROS) > SAME_ZERO]:
        yield Slip("displacement_scale", "displacement", zero=float(zero)), run.with_zero(zero)
    driven = np.ptp(run.pressure) > VARIED * run.pressure.max()  # at one pressure it may be the length's
    for by in FORCES[np.abs(FORCES) > SAME_FORCE] * float(np.std(run.force)) if driven else ():
        yield Slip("force_zero", "force", newtons=float(by)), run.with_force(by)


def _told(record: Record, made: dict[int, Made], share: float) -> Iterator[Doubt]:
    """The doubts of runs whose corrections leave a `share` of what there was."""
    runs, own = np.unique(record.run), record.specimen.initial_length_mm
    # Only beside each other: of all runs alike a smooth surface tells no length, and no zero.
    slips = [made[k].slips[0] if k in made else None for k in runs]
    length, zero = (float(np.median([getattr(one, name) if one else of for one in slips])) for name, of in USUAL)
    for k, (found, rivals) in made.items():
        first, *others = map(record.run_name, (k, *rivals))
        text, itself = f"{' or '.join((first, *others))} is at odds with the other runs", f"{first} " * bool(others)
        slip = found[0]
        if not slip.free:
            words = ", or with ".join(f"{one.words} ({one.why})" for one in found)
            text = f"{text}, and {itself}would agree with {words}"
        elif slip.newtons != 0.0:
            by = f"{newtons(abs(slip.newtons))} {'less' if slip.newtons > 0.0 else 'more'}"
            text = f"{text} over the zero of its force, and {itself}would agree with {by}: was the cell zeroed anew?"
        elif slip.length != 1.0 and abs(np.log(slip.length / length)) > SAME_LENGTH:
            mm = f"about {own * slip.length / length:.0f} mm, not {own:g}"
            text = f"{text} over the length of its muscle, and {itself}would agree with {mm} ([runs] in columns.toml)"
        elif slip.length == 1.0 and abs(slip.zero - zero) > SAME_ZERO:
            mm = f"about {own * abs(slip.zero - zero):.0f} mm {'less' if slip.zero > zero else 'more'}"
            text = f"{text} over the zero of its displacement, and {itself}would agree with {mm}"
        else:
            continue
        end = "" if text.endswith("?") else "."
        yield Doubt(slip.code, f"{text}{end} {LEFT} {percent(share)}.", slip.column, True)
