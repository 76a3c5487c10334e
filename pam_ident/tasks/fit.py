"""Fit a law, with or without effects, to a record."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from ..core import UsageError
from ..fitting import Fit, IsobarTable, fit, fit_isobars, lack_of_fit, loop_energies, repeat_noise
from ..fitting.bootstrap import Bootstrap, Draws, bootstrap
from ..fitting.carried import InLength
from ..fitting.covariance import student
from ..fitting.energy import energy_warning, model_loops, passive
from ..fitting.fit import Estimate, branch_names, fit_long
from ..fitting.floor import LackOfFit, RepeatNoise
from ..fitting.identifiability import PINNED, StandIn
from ..fitting.length import by_length
from ..fitting.methods import MethodRow, compare_methods
from ..fitting.prediction import Elsewhere, Predictor
from ..fitting.profile import Profile, profile
from ..fitting.refit import refit_weights
from ..fitting.weigh import LOSSES, Weighing
from ..parallel.executor import Executor
from ..records import Record
from ..records.doubt import Doubt
from ..records.long import open_long
from .gate import admit, computing, warnings_of
from .setup import Setup

BRANCHES = ("together", "separate", "contraction", "extension")
METHODS = ("global", "two-stage", "both")
INTERVALS = ("linear", "profile", "bootstrap")
WEIGHTS = ("equal", "sensors")
DRAWS = 2000
"""Refits of a bootstrap."""
PLAIN = {"method": "global", "weights": "equal", "loss": "linear", "intervals": "linear"}


@dataclass(frozen=True)
class FitOptions:
    """How a fit is to be done: parameters `held` at values, what samples weigh, how its intervals are found, by whom.

    Raises UsageError for an unknown word.
    """

    branch: str = "together"
    method: str = "global"
    held: Mapping[str, float] = field(default_factory=dict)
    weights: str = "equal"
    loss: str = "linear"
    intervals: str = "linear"
    seed: int = 0
    executor: Executor = field(default_factory=Executor)

    def __post_init__(self) -> None:
        for what, given, known in (
            ("--branch", self.branch, BRANCHES),
            ("--method", self.method, METHODS),
            ("--weights", self.weights, WEIGHTS),
            ("--loss", self.loss, LOSSES),
            ("--intervals", self.intervals, INTERVALS),
        ):
            if given not in known:
                raise UsageError(f"{what} {given!r}: expected one of {', '.join(known)}")
        if self.executor != Executor() and self.intervals == "linear":
            raise UsageError("--workers and --scheduler are for --intervals profile or bootstrap; ask for one of them")

    @property
    def special(self) -> Mapping[str, str]:
        """What is asked for besides the plain fit, by the option's name: only one record in force and memory has it."""
        return {name: asked for name, plain in PLAIN.items() if (asked := getattr(self, name)) != plain}

    @property
    def weighing(self) -> Weighing:
        """What samples weigh."""
        return Weighing(self.weights == "sensors", self.loss)


@dataclass(frozen=True)
class Checks:
    """What a fit is held against: what repeated strokes differ by, the test for a lack of fit, and faults of the
    sensors that its parameters take up without trace. The first two are None in a record without repeats."""

    repeats: RepeatNoise | None
    lack: LackOfFit | None
    stand_ins: tuple[StandIn, ...]


@dataclass(frozen=True)
class FitAnswer:
    """Fits by branch; for the two-stage method also the table of the isobars.

    `two_stage` names the branches whose parameters come from straight lines through the isobars; where a law has no
    such lines, or effects are fitted too, its fit is the global one. `profiles` are there for intervals by profile,
    `methods` for both methods side by side.
    """

    record: Record
    fits: Mapping[str, Fit]
    checks: Mapping[str, Checks]
    isobars: IsobarTable | None = None
    two_stage: tuple[str, ...] = ()
    profiles: Mapping[str, tuple[Profile, ...]] = field(default_factory=dict)
    methods: tuple[MethodRow, ...] = ()

    @cached_property
    def loops(self) -> Mapping[float, float]:
        """The modelled loops in J by pressure; none where the pressure was driven, for then there is no isobar."""
        return model_loops(self.fits) if self.record.kind == "isobaric" else {}

    @cached_property
    def measured_loops(self) -> Mapping[float, float]:
        """The loops of the record in J by pressure; none where the pressure was driven."""
        return loop_energies(self.record, self.record.force) if self.record.kind == "isobaric" else {}

    @cached_property
    def elsewhere(self) -> Mapping[str, Elsewhere]:
        """What the record says of the fits on others, by branch."""
        return {branch: Elsewhere.of(one) for branch, one in self.fits.items()}

    @property
    def predictors(self) -> dict[str, Predictor]:
        """The fits by branch, to be asked elsewhere."""
        return {branch: Predictor.of(one, self.elsewhere[branch].spread) for branch, one in self.fits.items()}

    @cached_property
    def warnings(self) -> tuple[Doubt, ...]:
        """What is doubtful of record and law, what effects warn of, hysteresis that law and effect both hold, and
        modelled loops that give energy."""
        one = next(iter(self.fits.values()))
        found = warnings_of(one)
        twice = [term.effect.title for term in one.model.terms if "direction" in term.effect.follows]
        if twice and one.model.law.params and "together" not in self.fits:
            text = (
                f"a law of its own for each branch holds the hysteresis already: {' and '.join(twice)} beside it is "
                "told by holds and turns alone, if at all. Fit both branches together, or leave it out."
            )
            found = (*found, Doubt("effect", text))
        energy = energy_warning(self.loops)
        return found if energy is None else (*found, Doubt("energy", energy))

    @property
    def passive(self) -> bool | None:
        """Whether the modelled loop takes up energy at every pressure; None without two modelled branches."""
        return passive(self.loops)

    @property
    def in_chunks(self) -> bool:
        """Whether the record was read in chunks, so that `record` is a sample of it."""
        return any(one.of_all for one in self.fits.values())

    @property
    def problems(self) -> list[str]:
        """Why a fit is not valid, branch by branch, then isobar by isobar; empty when all are."""
        found = [f"{branch}: {problem}" for branch, one in self.fits.items() for problem in one.problems]
        return found + (self.isobars.problems if self.isobars else [])


def fit_record(record: Record | str | Path, setup: Setup, wishes: FitOptions | None = None) -> FitAnswer:
    """Fit `setup.model` to the branches asked for, all pressures at once, or isobar by isobar and then over pressure.

    Args:
        record: what is fitted; of a path it is read in chunks, as well as from memory, and the answer's record is an
            even sample of its rows, from which are the loops' energies and the faults of sensors that parameters take
            up. Noise floor and test for a lack of fit are left out then.
        setup: the law and its effects.
        wishes: branches, method, weights and intervals; by default both branches together, at once, alike, linear.

    Raises:
        UsageError: for a parameter to hold that the model lacks, and in chunks for wishes, and effects, that need the
            whole record at once.
        FitError: when the record cannot identify the law at all.
        DataError: when it lacks the branch, or what an effect needs.

    Example:
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.tasks.fit import fit_record
        >>> from pam_ident.tasks.setup import Setup
        >>> setup = Setup("martens_boblan")
        >>> answer = fit_record(setup.read(dataset_record("dmsp20_300")), setup)
        >>> print(f"{answer.fits['together'].rmse:.2f} N rms; problems: {answer.problems}")
        3.21 N rms; problems: []
    """
    with computing(record):
        return _fit_record(record, setup, wishes or FitOptions())


def _fit_record(record: Record | str | Path, setup: Setup, wishes: FitOptions) -> FitAnswer:
    branches = branch_names(wishes.branch)
    if isinstance(record, Record):
        admit(record)
        _check_length(record, wishes)
        fits = {
            name: fit(setup.model, record, record.branch_rows(name), held=wishes.held, weighing=wishes.weighing)
            for name in branches
        }
    else:
        _check_chunked(record, setup, wishes)
        with open_long(record, setup.specimen) as on_disk:
            fits = {name: fit_long(setup.model, on_disk, name, wishes.held) for name in branches}
        record = fits[branches[0]].record
        admit(record, in_chunks=True)
    isobars, straight = None, ()
    if wishes.method == "two-stage":
        isobars = fit_isobars(setup.model, record, branches, wishes.held)
        lines = {name: one for name, one in fits.items() if _covers(isobars, name, one)}
        fits |= {name: _from_lines(one, isobars, name) for name, one in lines.items()}
        straight = tuple(lines)
    profiles: dict[str, tuple[Profile, ...]] = {}
    for name, one in fits.items():
        if name not in straight and one.valid:
            fits[name], profiles[name] = _with_intervals(one, setup, wishes)
    checks = {name: checks_of(one) for name, one in fits.items()}
    methods = compare_methods(record, setup.model, wishes.branch) if wishes.method == "both" else ()
    return FitAnswer(record, fits, checks, isobars, straight, profiles, methods)


def answer_of(one: Fit) -> FitAnswer:
    """The answer that a fit of both branches together, made elsewhere, comes to."""
    return FitAnswer(one.record, {"together": one}, {"together": checks_of(one)})


def _check_length(record: Record, wishes: FitOptions) -> None:
    """Raises UsageError for a wish that is for residuals in force, where the length answered."""
    for name, asked in wishes.special.items() if by_length(record) else ():
        raise UsageError(
            f"{record.source or record.name}: in an isotonic test the length answers, and --{name} {asked} is for a "
            "force that does; leave it out"
        )


def _check_chunked(path: str | Path, setup: Setup, wishes: FitOptions) -> None:
    """Raises UsageError for a wish that a record in chunks cannot be given."""
    if setup.where is not None:
        raise UsageError(f"{path} is read in chunks: --where needs all of it in memory; fit a part of the record")
    for name, asked in wishes.special.items():
        raise UsageError(
            f"{path} is read in chunks: --{name} {asked} needs all of it in memory at once; leave that out, or fit a "
            "part of the record"
        )


def checks_of(one: Fit) -> Checks:
    """What a fit is held against; of a record in chunks the faults of its sensors alone, and where the length answered
    the noise of that alone, in mm: what repeats is the load's error, too, which is no lack of fit."""
    if one.lengths is not None:
        return Checks(repeat_noise(InLength.of(one)), None, ())
    return Checks(*((None, None) if one.of_all else (repeat_noise(one), lack_of_fit(one))), one.stand_ins)


def _with_intervals(one: Fit, setup: Setup, wishes: FitOptions) -> tuple[Fit, tuple[Profile, ...]]:
    """The fit with its intervals found as was asked for, and the profiles that gave them."""
    if wishes.intervals == "linear":
        return one, ()
    if wishes.intervals == "profile":
        found = profiles_of(one, setup, wishes.executor)
        ends = {name: (p.low, p.high) for name, p in found.items()}
    else:
        found, ends = {}, bootstrap_of(one, setup, wishes.seed, wishes.executor).intervals
    estimates = tuple(
        replace(e, low=ends[e.name][0], high=ends[e.name][1]) if e.name in ends else e for e in one.estimates
    )
    return replace(one, given=estimates), tuple(found.values())


def _covers(table: IsobarTable, branch: str, one: Fit) -> bool:
    return branch in table.two_stage and {p.name for p in one.model.params} == set(table.two_stage[branch])


def _from_lines(one: Fit, table: IsobarTable, branch: str) -> Fit:
    """The fit with its parameters from straight lines through the isobars, standard errors from their scatter."""
    values = table.two_stage[branch]
    errors = _line_errors(table, branch)
    return replace(
        one,
        values=values,
        given=tuple(_on_lines(e, values[e.name], *errors.get(e.name, (e.stderr, e.dof))) for e in one.estimates),
        message="two-stage",
        sums=None,
    )


def _on_lines(e: Estimate, value: float, stderr: float, dof: float) -> Estimate:
    """What all isobars at once cannot tell, lines through them cannot either."""
    half = float(student(np.array(dof))) * stderr if dof > 0 else math.nan
    verdict = PINNED if e.identified and e.verdict.determined else e.verdict
    return replace(e, value=value, stderr=stderr, low=value - half, high=value + half, dof=dof, verdict=verdict)


def _line_errors(table: IsobarTable, branch: str) -> dict[str, tuple[float, float]]:
    """Standard errors, with degrees of freedom, of intercept and slope over pressure of each isobar coefficient.

    NaN from two isobars.
    """
    rows = [row for row in table.rows if row.branch == branch]
    p = np.array([row.pressure_MPa for row in rows])
    n, spread = len(p), float(np.sum((p - p.mean()) ** 2))
    errors: dict[str, tuple[float, float]] = {}
    for k, name in enumerate(e.name for e in rows[0].estimates):
        y = np.array([row.estimates[k].value for row in rows])
        off = y - np.polyval(np.polyfit(p, y, 1), p)
        variance = float(off @ off) / (n - 2) if n > 2 else math.nan
        errors[f"{name}1"] = math.sqrt(variance / spread), n - 2
        errors[f"{name}0"] = math.sqrt(variance * (1.0 / n + p.mean() ** 2 / spread)), n - 2
    return errors


def profiles_of(one: Fit, setup: Setup, executor: Executor) -> dict[str, Profile]:
    """Profile of each fitted parameter that stands at no bound, by name, a task each."""
    work = partial(_profile, *_packed(one, setup))
    return dict(zip(one.free, executor.all(work, one.free, "profiles"), strict=True))


def bootstrap_of(one: Fit, setup: Setup, seed: int, executor: Executor) -> Bootstrap:
    """A bootstrap by cycles; its draws are made here, some hundred refits to them are a task."""
    work = partial(_refit, *_packed(one, setup))
    return bootstrap(one, DRAWS, "cycle", seed, lambda parts: executor.all(work, parts, "hundreds of refits"))


def _packed(one: Fit, setup: Setup) -> tuple[Setup, Fit]:
    """The two as they can be sent to another process, which loads the user's own effects itself."""
    return setup.bare(), replace(one, model=setup.law_alone)


def _profile(setup: Setup, one: Fit, name: str) -> Profile:
    return profile(replace(one, model=setup.model), name)


def _refit(setup: Setup, one: Fit, draws: Draws):
    return refit_weights(replace(one, model=setup.model), *draws)
