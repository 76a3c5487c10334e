"""The length at which a model carries a load: what a fit leaves where the load is held and the length answers.

A model predicts the contraction ε at which F(p, ε; θ) = W, p the pressure and W the load. Its slopes over the
parameters are those of an implicit function, dε/dθ = −(∂F/∂θ)/(∂F/∂ε) (Dini's theorem; Dontchev & Rockafellar 2014,
Implicit Functions and Solution Mappings, theorem 1B.1). Where the force does not fall with the contraction no length is
stable, and none is predicted.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from ..core import Array, DataError, Inputs
from ..effects._history import acceleration
from ..model import Model
from ..records import Record
from ..records.roughness import position_noise
from ..records.run_constants import GRAVITY, MASSES
from ..records.smoothing import calmed
from ..records.turning import pivots
from .problem import Problem, Solution, Whiten, all_rows
from .readings import with_memory
from .solve import solve, table
from .solvers import Solver, VariableProjection

Values = Mapping[str, float]
ROOM = 0.05
"""Contraction by which a muscle may be off what its braid could reach, because its angle or length at rest are."""
PLACES, ROUNDS = 25, 60
"""Contractions among which the first equilibrium is sought, and halvings of the way between two, at most."""
EXACT_N, EXACT = 1e-9, 1e-14
"""Miss of the load in N, and width in contraction, at which an equilibrium is found."""
LEAST_SLOPE = 1e-3
"""Fall of the force over the whole length beside the load, below which no length is predicted."""
ONE_WEIGHT = 0.05
"""Distance of two loads beside the larger, up to which they are one weight."""
LEFT, CLEAR = 0.3, 4.5
"""Share of a run's squared deviations that a change of weight leaves at most, and steps between weights beside what is
left, robust standard deviations, from which they were hung on one after the other: a load that swells or swings as one
does not step so far."""
BAND, AT_END = 4.0, 0.004
"""Noises of the length, and share of its way as in a reversal, within which it stands at its end."""
BEFORE, NEAREST, STOPPED = 0.1, 10, 8.0
"""Share of its way before the end in which it is seen to move, or so many samples where it leaves that at a jump, and
bands by which it would have gone on, had nothing stopped it."""
ROUNDED = 1e-6
"""Share of the range of the pressure within which values are one pressure, but for their rounding."""
NO_PRESSURE = 0.02
"""Share of the largest pressure below which a muscle is not inflated: what then carries the load are its threads."""


@dataclass(frozen=True, eq=False)
class Lengths:
    """What a model says of the lengths of n samples, (n,) each: the `load` in N, the `contraction` at which it carries
    that, the force's `slope` there in N over the whole length, and the `residual` in mm, measured less predicted; the
    `weight` that was held in N, and whether a sample is at the mechanical `limit` of the length. The
    contraction is the end of what a braid reaches, and the slope 0, where the model has no stable length."""

    load: Array
    contraction: Array
    slope: Array
    residual: Array
    weight: Array
    limit: Array

    @classmethod
    def of(cls, model: Model, record: Record, values: Values) -> "Lengths":
        """Of a model with values at the samples of a record."""
        load = load_of(record)
        e, slope = equilibrium(model, record.inputs, values, load)
        length = record.specimen.initial_length_mm
        off = record.inputs.displacement_mm - length * e
        return cls(load, e, slope, off, weights_of(record), at_limit(record))


def by_length(record: Record) -> bool:
    """Whether the length answered, so that it is what a model must predict."""
    return not record.carried and record.kind == "isotonic"


@lru_cache(maxsize=4)
def load_of(record: Record) -> Array:
    """What the muscle carries in N, (n,): the measured force, less what of it is a load cell's white noise; of a mass
    that was given (`load_kg`) m (g + ẍ), x the shortening."""
    force, inputs = record.force, record.inputs
    if any(mass in record.columns.get("force", "").lower() for mass in MASSES) and inputs.time is not None:
        return force * (1.0 + 1e-3 * acceleration(inputs) / GRAVITY)
    spell = spells_of(record)
    return force if spell is None else calmed(force, spell)


@lru_cache(maxsize=4)
def weights_of(record: Record) -> Array:
    """The load in N that is held at each sample, (n,): of spells in time their medians, alike ones put together."""
    spell = spells_of(record)
    held = record.force.astype(float)
    if spell is not None:
        for number in np.unique(spell):
            held[spell == number] = np.median(held[spell == number])
    values, place = np.unique(held, return_inverse=True)
    apart = np.diff(values) > ONE_WEIGHT * np.maximum(np.abs(values[1:]), 1e-9)
    group = np.r_[0, np.cumsum(apart)][place]
    return np.array([np.median(held[group == g]) for g in range(group.max() + 1)])[group]


@lru_cache(maxsize=4)
def spells_of(record: Record) -> Array | None:
    """Number of the spell of each sample, (n,), under one weight: a run, or what of it lies between clear steps of the
    load; None without time."""
    segment = record.inputs.segment
    if segment is None:
        return None
    edges = [0, *(np.flatnonzero(np.diff(segment)) + 1).tolist(), len(segment)]
    steps = [k for run in pairwise(edges) for k in (run[0], *_steps(record.force, record.inputs.pressure, *run))]
    begins = np.zeros(len(segment), int)
    begins[steps[1:]] = 1
    return np.cumsum(begins)


def _steps(force: Array, pressure: Array, begin: int, end: int) -> list[int]:
    """Where the load of a run of samples steps from one held level to the next."""
    steps, _ = _parted(force, pressure, begin, end)
    spells = np.split(force[begin:end], [k - begin for k in steps])
    levels = np.array([np.median(spell) for spell in spells])
    off = np.median(np.abs(np.concatenate([spell - level for spell, level in zip(spells, levels, strict=True)])))
    return steps if np.all(np.abs(np.diff(levels)) > CLEAR * off / 0.6745) else []


def _parted(force: Array, pressure: Array, begin: int, end: int) -> tuple[list[int], float]:
    """The steps that least squares finds in a run, halved again and again, and the squared deviations they leave. On
    either side of each the pressure goes both ways, by a third of its range there at least: what friction adds on one
    way it takes on the other, and is no weight."""
    off = force[begin:end] - force[begin:end].mean()
    whole = float(off @ off)
    n, sums = np.arange(1, len(off)), np.cumsum(off)[:-1]
    if not len(sums):
        return [], whole
    k = begin + 1 + int((sums**2 * (1.0 / n + 1.0 / n[::-1])).argmax())
    parts = (begin, k), (k, end)
    if any(len(pivots(p, float(np.ptp(p)) / 3.0)) < 3 for p in (pressure[slice(*part)] for part in parts)):
        return [], whole
    (before, left), (after, right) = (_parted(force, pressure, *part) for part in parts)
    # Of several weights in any order the first step alone may tell little.
    return ([*before, k, *after], left + right) if left + right < LEFT * whole else ([], whole)


@lru_cache(maxsize=4)
def at_limit(record: Record) -> Array:
    """Mask (n,) of the samples in which no balance of forces is seen: the length stands at its end while the pressure
    goes on, as on a stop or with slack threads, or there is no pressure and the threads alone carry the weight."""
    inputs, weight = record.inputs, weights_of(record)
    x, p = inputs.displacement_mm, inputs.pressure
    rate, always = inputs.pressure_rate, np.ones(len(x), bool)
    rising, falling = (always, always) if rate is None else (rate > 0.0, rate < 0.0)
    noise = 0.0 if inputs.time is None else position_noise(x, inputs.time)
    found = p < NO_PRESSURE * p.max()
    for w in np.unique(weight):
        here = np.flatnonzero((weight == w) & ~found)
        if len(here):
            band = max(BAND * noise, AT_END * float(np.ptp(x[here])))
            for sign, going in ((1.0, falling[here]), (-1.0, rising[here])):
                found[here[_stopped(sign * x[here], p[here], going, band)]] = True
    return found


def _stopped(x: Array, p: Array, going: Array, band: float) -> Array:
    """Mask (m,) of the samples within a `band` of the least x, if pressures that `going` to that end (mask) ran through
    there would have moved it on, by its course just before."""
    low = np.sort(x)[min(len(x) // 200, len(x) - 1)]
    end, beyond = x <= low + band, np.flatnonzero(x > low + band)
    near = np.count_nonzero(x[beyond] <= low + band + BEFORE * np.ptp(x))
    before = beyond[np.argsort(x[beyond])[: max(near, NEAREST)]]
    if min(np.count_nonzero(end & going), len(before)) < 3 or np.ptp(p[before]) <= ROUNDED * np.ptp(p):
        return np.zeros(len(x), bool)
    course = abs(np.polyfit(p[before], x[before], 1)[0])
    way = np.ptp(p[end & going]) * course
    return end if way > STOPPED * band else np.zeros(len(x), bool)


def determining(record: Record, rows: Array) -> Array:
    """Those of `rows` (mask, (n,)) that tell of a law: where the length answered, not at its mechanical limit."""
    return rows & ~at_limit(record) if by_length(record) else rows


def equilibrium(model: Model, inputs: Inputs, values: Values, load: Array) -> tuple[Array, Array]:
    """The contraction at which a model carries `load` (n,) in N, and the slope of its force there, (n,) in N each.

    From the longest on, the first at which the force falls to the load, as a muscle finds it that is inflated. Where
    the force stays above the load it is the shortest, where it stays below the longest that a braid reaches, with a
    slope of 0; so it is where the force hardly falls. What was measured of the length does not enter.
    """
    low, high = _reach(inputs)

    def over(e: Array) -> Array:
        with np.errstate(over="ignore", invalid="ignore"):  # a braid at its longest may be far beyond a law
            force = model.force(replace(inputs, contraction=e), values)
        return np.nan_to_num(force - load, nan=-1e300, posinf=1e300, neginf=-1e300)

    n = len(load)
    places = np.linspace(low, high, PLACES)
    above = np.array([over(np.full(n, e)) for e in places])
    falls = (above[:-1] > 0.0) & (above[1:] <= 0.0)
    known, first, row = falls.any(axis=0), falls.argmax(axis=0), np.arange(n)
    a, b = places[first], places[first + 1]
    e = _root(over, a, b, above[first, row], above[first + 1, row])
    step = 1e-5
    slope = (over(e + step) - over(e - step)) / (2.0 * step)
    known &= slope < -LEAST_SLOPE * np.maximum(np.abs(load), 1.0)
    end = np.where(above[0] > 0.0, high, low)
    return np.where(known, e, end), np.where(known, slope, 0.0)


def _reach(inputs: Inputs) -> tuple[float, float]:
    """Contractions between which the braid ends: its threads along the axis, and at 54.7° to it (Chou & Hannaford 1996,
    IEEE Trans. Robotics and Automation 12(1), 90–102)."""
    cosine = math.cos(math.radians(inputs.specimen.braid_angle_deg))
    return max(1.0 - 1.0 / cosine - ROOM, -0.5), 1.0 - 1.0 / (math.sqrt(3.0) * cosine) + ROOM


def _root(over: Callable[[Array], Array], a: Array, b: Array, fa: Array, fb: Array) -> Array:
    """Where `over` falls through 0 between a and b, (n,) each, by the Illinois rule (Dowell & Jarratt 1971, BIT 11,
    168–174), every fourth time by halving, lest a corner make it slow."""
    e, last = b, np.zeros(len(a))
    for k in range(1, ROUNDS):
        cut = np.divide(fb * (b - a), fb - fa, out=np.zeros(len(a)), where=fb != fa)
        e = b - cut if k % 4 else 0.5 * (a + b)
        f = over(e)
        if np.all((np.abs(f) < EXACT_N) | (b - a < EXACT)):
            break
        up = f > 0.0
        side = np.where(up, 1.0, -1.0)
        again = side == last
        fa, fb = np.where(up, f, np.where(again, 0.5 * fa, fa)), np.where(up, np.where(again, 0.5 * fb, fb), f)
        a, b, last = np.where(up, e, a), np.where(up, b, e), side
    return e


def problem_of(
    model: Model, record: Record, rows: Array, whiten: Whiten = all_rows, by_weight: bool = False
) -> Problem:
    """Least squares of the length in mm that a model predicts over `rows` (mask, (n,)), all its parameters curved.

    With `by_weight` slopes are those at the weights as they were held, for errors of the parameters: what inertia and
    friction make of a measured load is no second weight, without which most laws are known but for a factor.

    Raises DataError for an effect that remembers the way, which would predict the length by the length.
    """
    inputs, load, weight = record.inputs.take(rows), load_of(record)[rows], weights_of(record)[rows]
    memory = with_memory(model, inputs, load)
    if memory:
        raise DataError(
            f"{record.source or record.name}: {memory[0].label} remembers the way, and in an isotonic test the way is "
            "what the model must predict; leave the effect out, or let `add` or `diagnose` fit it"
        )
    length, last = inputs.specimen.initial_length_mm, {}

    def solved(values: Values) -> tuple[Array, Array]:
        key = tuple(values.values())
        if key not in last:
            last.clear()
            last[key] = equilibrium(model, inputs, values, load)
        return last[key]

    def design(values: Values) -> tuple[Array, Array]:
        return np.empty((len(load), 0)), length * solved(values)[0]

    def slopes(values: Values) -> Array:
        held, there = (weight, equilibrium(model, inputs, values, weight)) if by_weight else (load, solved(values))
        return length * implicit(model, inputs, values, held, *there)

    return Problem((), model.bounded(inputs), design, inputs.displacement_mm, whiten=whiten, slopes=slopes)


def implicit(model: Model, inputs: Inputs, values: Values, load: Array, e: Array, slope: Array) -> Array:
    """dε/dθ at an equilibrium `e` with the force's `slope` there, (n,) each: shape (n, k), 0 where there is none."""
    by_force = table(model, replace(inputs, contraction=e), values, load)[:, :-1]
    falls = slope < 0.0
    return np.where(falls[:, None], -by_force / np.where(falls, slope, -1.0)[:, None], 0.0)


def solve_length(
    model: Model, record: Record, rows: Array, start: Values, held: Values, solver: Solver | None = None
) -> tuple[Solution, Whiten]:
    """Least squares of the length over `rows` (mask, (n,)), from the best of several beginnings: values that are given,
    those of a fit of the force, which is blind where there is one load, and those of an ideal braid's force. What the
    rows of a run share of the error of its load is evened out, by what is returned beside the solution.

    Raises DataError as `problem_of` does.
    """
    problem = problem_of(model, record, rows).holding(**held)
    given = start and set(start) >= set(model.names)
    beginnings = [start] if given else _beginnings(model, record, rows, held)
    solver = solver or VariableProjection(keep=1)
    best = solved_from(problem, beginnings, solver)
    even = evened(model, record, rows, {**best.values, **held})
    if even is not all_rows:
        best = solved_from(replace(problem, whiten=even), [best.values], solver)
    return replace(best, values=best.values | dict(held)), even


def solved_from(problem: Problem, beginnings: Sequence[Values], solver: Solver) -> Solution:
    """The best solution of a curved problem from the two of some beginnings that are nearest."""
    names = {p.name for p in problem.params}
    ways = [replace(problem, start={k: v for k, v in one.items() if k in names}) for one in beginnings]
    ranked = sorted(ways, key=lambda way: way.starts(1)[0].cost)
    found = [solver.solve(way) for way in ranked[:2]]
    return min(found, key=lambda one: float(np.sum(problem.residual(one.values) ** 2)))


def evened(model: Model, record: Record, rows: Array, values: Values) -> Whiten:
    """Takes out of `rows` (mask, (n,)) what those of a run share, because its load is the mean of a noisy load cell:
    the inverse root of σ²1 + s²bbᵀ, s the error of the mean and b what a newton of it makes of the length."""
    spell, force, load = spells_of(record), record.force[rows], load_of(record)[rows]
    if spell is None or np.array_equal(force, load):
        return all_rows
    inputs = record.inputs.take(rows)
    e, slope = equilibrium(model, inputs, values, load)
    length, spell = inputs.specimen.initial_length_mm, spell[rows]
    square = float(np.mean((inputs.displacement_mm - length * e) ** 2))
    shared: list[tuple[Array, Array, float]] = []
    for number in np.unique(spell):
        run = np.flatnonzero((spell == number) & (slope < 0.0))
        by_newton, off = length / slope[run], force[run] - load[run]
        size = float(np.linalg.norm(by_newton))
        if len(run) and np.ptp(load[run]) == 0.0 and off.any() and square > 0.0:
            ratio = float(np.mean(off**2)) / len(run) * size**2 / square
            shared.append((run, by_newton / size, 1.0 - 1.0 / math.sqrt(1.0 + ratio)))

    def even(m: Array) -> Array:
        found = m.copy()
        for run, along, part in shared:
            found[run] -= part * np.multiply.outer(along, along @ m[run])
        return found

    return even if shared else all_rows


def _beginnings(model: Model, record: Record, rows: Array, held: Values) -> list[dict[str, float]]:
    inputs, load = record.inputs.take(rows), load_of(record)[rows]
    neutral, found = model.neutral(inputs), []
    if len(np.unique(weights_of(record)[rows])) > 1:
        found.append(solve(model, inputs, load, all_rows, quick=True, held=held).values)
    p, e = (np.linspace(float(v.min()), float(v.max()), 12) for v in (inputs.pressure, inputs.contraction))
    p, e = (grid.ravel() for grid in np.meshgrid(p, e))
    law = replace(model, terms=())
    own = {name: value for name, value in held.items() if name in law.names}
    states = Inputs(p, e, inputs.specimen, np.zeros(len(p)))
    ideal = solve(law, states, inputs.specimen.ideal_force(p, e), all_rows, quick=True, held=own)
    return [*found, {**neutral, **ideal.values, **held}]
