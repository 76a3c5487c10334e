"""The gate before every answer: what looks wrong, what a verb cannot answer, and what is too little to name from."""

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..core import DataError, FitError, PamError, UsageError
from ..core.digits import millimetres, newtons, percent
from ..core.prose import capital
from ..core.threads import one_blas_thread
from ..fitting import Fit, fit
from ..fitting.estimate import impossible
from ..fitting.length import at_limit, by_length, weights_of
from ..model import Model
from ..records import Record
from ..records.doubt import GRAVE, Doubt, grave
from ..records.gate import doubts_of
from ..records.kind import KINDS
from ..records.plausible import FAINT_MPA

LITTLE, UNLIKE = 0.1, 0.3
"""Share of the squared force, and correlation with it where it varies, from which a law explains anything at all."""
CONSTANT = 0.2
"""Standard deviation of a force beside its mean, below which it hardly varies."""
MOST_LEFT = 0.2
"""Share of a force's variance that a model may leave with all that was found missing, or nothing was found."""
OUTLYING, DECIDES, RARE = 10.0, 0.5, 0.01
"""In a table: robust standard deviations from which a row is an outlier, the share of the squared error from which
outliers decide a fit, and the share of the rows (one at least) up to which they are faults."""
LEAST_STEP_S = 1e-9
"""Mean step of a clock that does not stand."""
BEYOND_N = 1e100
"""A force whose square no number holds."""
ROWS, ROWS_A_PARAMETER, STATES, ROWS_A_STROKE = 20, 3, 8, 4
"""The floor of information for naming: rows in all and a free parameter of the law, different states of pressure and
contraction (and two more than free parameters), rows of a stroke on average."""
SPAN, FORCE_N = 1e-4, 1e-9
"""The same for ranges: contraction, force."""
NOT_HELD = 0.3
"""Error of a force about the weights that were held, beside these, both rms, from which none was."""
STEADY = 0.5
"""Correlation of the pressure with itself one sample later, below which it jumps faster than it is logged."""


class NothingNamed(PamError):
    """Nothing is named of a record of `n` samples; `doubts` are why, and what else looks wrong."""

    def __init__(self, message: str, n: int, doubts: tuple[Doubt, ...]) -> None:
        self.n, self.doubts = n, doubts
        super().__init__(message)

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), str(self), self.n, self.doubts)  # an exception is pickled by its message alone


def _again(kind: type[NothingNamed], *given: Any) -> NothingNamed:
    found = kind.__new__(kind)
    NothingNamed.__init__(found, *given)
    return found


class Refused(NothingNamed, DataError):
    """A record of which this cannot be answered, whatever is assumed."""


class TooLittle(NothingNamed, FitError):
    """A record that holds too little to answer from."""


class GraveDoubt(NothingNamed, DataError):
    """A record, or the law on it, looks so wrong that nothing is named; `stops` are the doubts that stop it."""

    def __init__(self, where: str, n: int, doubts: tuple[Doubt, ...], stops: tuple[Doubt, ...]) -> None:
        first, *others = dict.fromkeys(doubt.code for doubt in stops)
        more = f" (and {', '.join(others)})" if others else ""
        codes = " ".join(f"--assume {code}" for code in (first, *others))
        super().__init__(
            f"{where}: nothing is named: {stops[0].text.rstrip('.')}{more}. Fix it in the file or by a "
            f"columns.toml; if it is meant so, {codes}",
            n,
            doubts,
        )


def check_codes(assume: Iterable[str]) -> None:
    """Raises UsageError for a code that no doubt has."""
    for code in assume:
        if code != "all" and code not in GRAVE:
            raise UsageError(f"--assume {code}: expected all or one of {', '.join(GRAVE)}")


def doubts_about(one: Fit) -> tuple[Doubt, ...]:
    """What looks wrong in the record of a fit, and in its law on it, the grave first."""
    found = (*doubts_of(one.record), *_doubt_pressures(one), *_doubt_outliers(one), *doubt_values(one))
    if one.lengths is not None:
        return _grave_first((*_doubt_length(one), *found))
    force = one.record.force[one.rows]
    size = float(np.sqrt(np.mean(force**2)))
    modelled = one.model.force(one.record.inputs, one.values)[one.rows]
    varies = force.std() > CONSTANT * abs(force.mean()) and modelled.std() > 0.0
    unlike = varies and np.corrcoef(modelled, force)[0, 1] < UNLIKE
    if one.rmse**2 < (1.0 - LITTLE) * size**2 and not unlike:
        return _grave_first(found)
    law = Doubt(
        "explains_nothing",
        f"The {one.model.words} leaves {newtons(one.rmse)} rms of a force of {newtons(size)} rms: it "
        "explains nothing. Check units, signs and the specimen, or take another law.",
        "force",
        True,
    )
    return _grave_first((law, *found))


def _doubt_pressures(one: Fit) -> Iterator[Doubt]:
    """What of the law one pressure does not tell."""
    names = one.model.law.pinned
    if names:
        text = (
            f"one pressure, {one.record.level[one.rows][0]:g} MPa, does not tell {', '.join(names)} from the other "
            "parameters: held at 0. The law stands for that pressure alone; measure at others."
        )
        yield Doubt("one_pressure", text, "pressure")


def _doubt_length(one: Fit) -> Iterator[Doubt]:
    """What looks wrong where a fit was to predict the length, and what it was not fitted to."""
    assert one.lengths is not None
    weight, errors = one.lengths.weight[one.rows], one.length_errors
    left_out = int(one.lengths.limit.sum())
    moves = math.sqrt(errors.spread / errors.n) if errors else 0.0
    if errors and errors.rmse**2 >= (1.0 - LITTLE) * moves**2:
        text = (
            f"The {one.model.words} leaves {millimetres(errors.rmse)} rms of a length that moves by "
            f"{millimetres(moves)} rms: it explains nothing. Check units, signs and the specimen, or take another law."
        )
        yield Doubt("explains_nothing", text, "displacement", True)
    if len(np.unique(weight)) == 1 and not one.shared:
        text = (
            f"all samples carry one weight, about {newtons(weight[0])}: what the law says of another rests on its form "
            "alone. Hang other weights."
        )
        yield Doubt("one_weight", text, "force")
    if left_out:
        text = (
            f"{left_out} samples at the end of the length, where the pressure does not move it, are no data on the law."
        )
        yield Doubt("at_limit", text, "displacement")


def _grave_first(found: Iterable[Doubt]) -> tuple[Doubt, ...]:
    return tuple(sorted(found, key=lambda doubt: not doubt.grave))


def _doubt_outliers(one: Fit) -> Iterator[Doubt]:
    """Rows of a table that decide its fit. In a record with time what leaves its neighbours was left out when read."""
    if one.record.inputs.time is not None or len(one.record) < ROWS:
        return
    size = np.where(one.rows, np.abs(one.residual), 0.0)
    far = np.flatnonzero(size > OUTLYING * np.median(size[one.rows]) / 0.6745)
    share = float(np.sum(size[far] ** 2) / np.sum(size**2)) if len(far) else 0.0
    if share > DECIDES and len(far) <= max(RARE * one.n, 1):
        row = int(size.argmax())
        rest = f", with {len(far) - 1} more," if len(far) > 1 else ""
        yield Doubt(
            "outlier",
            f"sample {row + 1} reads {newtons(one.record.force[row])}, {newtons(size[row])} off the fit, and decides "
            f"it{rest} by {percent(share)} of the squared error. Fix or delete the row.",
            "force",
            True,
        )


def doubt_values(one: Fit) -> Iterator[Doubt]:
    """Parameters whose values nature does not allow."""
    for e in one.impossible:
        yield Doubt("impossible_parameter", f"{impossible(e)}. The model imitates something else by it.")


def warnings_of(one: Fit) -> tuple[Doubt, ...]:
    """The same, and what the effects of its model warn of."""
    return (*doubts_about(one), *(Doubt("effect", text) for text in effect_warnings(one.model)))


def effect_warnings(model: Model) -> list[str]:
    """What the effects of a model warn of."""
    return [f"{capital(effect.title)}: {effect.warning}" for effect in model.own if effect.warning]


def admit(record: Record, in_chunks: bool = False) -> None:
    """Raises Refused where the clock stands, for a force beyond arithmetic, and for an isotonic test `in_chunks`."""
    if not np.abs(record.force).max() < BEYOND_N:
        row = int(np.abs(record.force).argmax())
        text = f"sample {row + 1} reads a force of {newtons(record.force[row])}. Fix or delete the row"
        raise _refused(Refused, record, "impossible_value", text)
    time = record.inputs.time
    if time is not None and len(record) > 1 and np.ptp(time) < LEAST_STEP_S * len(record):
        text = f"the clock advances by {np.ptp(time):.3g} s in {len(record)} rows. Fix its unit, or leave the time out"
        raise _refused(Refused, record, "clock_scale", text)
    if in_chunks and by_length(record):
        text = (
            f"an isotonic test, {KINDS['isotonic']}: it is answered from memory, not in chunks. Give a part "
            'of it, or say `kind = "isobaric"` at the top of specimen.toml if this is one'
        )
        raise _refused(Refused, record, "kind", text)


def require_rows(record: Record) -> None:
    """Raises TooLittle where the rows are too few to say where a model fails."""
    if len(record) < STATES:
        text = f"{len(record)} rows, and the least is {STATES}. Measure more"
        raise _refused(TooLittle, record, "too_little", text)


def _require_weights(record: Record) -> None:
    """Raises Refused for an isotonic test whose load was not held."""
    if not by_length(record):
        return
    weight = weights_of(record)
    off, held = (float(np.sqrt(np.mean(one**2))) for one in (record.force - weight, weight))
    if off > NOT_HELD * held:
        text = (
            f"an isotonic test, and the force is {newtons(off)} rms off a held load of {newtons(held)}: no effect can "
            "be told from another by it. Hold the load, or say another `kind` in specimen.toml"
        )
        raise _refused(Refused, record, "kind", text)


def _refused(kind: type[NothingNamed], record: Record, code: str, text: str) -> NothingNamed:
    return kind(f"{_name(record)}: {text}", len(record), (Doubt(code, text),))


def _lacking(record: Record, parameters: int) -> str | None:
    inputs, n = record.inputs, len(record)
    rows, states = max(ROWS, ROWS_A_PARAMETER * parameters), max(STATES, parameters + 2)
    if n < rows:
        return f"{n} rows, and the least for {parameters} free parameters is {rows}"
    if np.ptp(inputs.contraction) < SPAN:
        return f"the length changes by {np.ptp(inputs.displacement_mm):.2g} mm in all"
    if np.abs(inputs.pressure).max() < FAINT_MPA:
        return f"the pressure reaches {np.abs(inputs.pressure).max():.2g} MPa"
    if np.ptp(record.force) < FORCE_N:
        return f"the force is {newtons(record.force[0])} in every row"
    different = len(np.unique(np.round(np.column_stack([inputs.pressure, inputs.contraction]), 5), axis=0))
    if different < states:
        return f"{different} different states of pressure and length, and the least for this law is {states}"
    if by_length(record) and len(np.unique(weights_of(record)[~at_limit(record)])) < 2:
        return "all samples that tell of the law carry one weight, and its size scales the pressure (hang three)"
    if inputs.time is None:
        return None
    strokes = len(np.unique(record.stroke[record.stroke > 0]))
    if not strokes:
        return "no stroke in one direction"
    if n / strokes < ROWS_A_STROKE:
        return f"{n / strokes:.2g} rows a stroke, and the least is {ROWS_A_STROKE}"
    off = inputs.pressure - inputs.pressure.mean()
    if record.kind == "dynamic" and np.mean(off[1:] * off[:-1]) < STEADY * np.mean(off**2):
        return "the pressure jumps from row to row, faster than it is logged"
    return None


def require_nameable(record: Record, assume: tuple[str, ...] = (), parameters: int = 0) -> None:
    """Raises NothingNamed as `may_name` does, by what needs no fit, for a law of so many free `parameters`."""
    if len(record) >= ROWS:
        _stop(record, doubts_of(record), assume)
    admit(record)
    _require_weights(record)
    lacking = _lacking(record, parameters)
    if lacking is not None:
        text = f"{lacking}; too little to name an effect by. Measure more, or fix the record"
        raise _refused(TooLittle, record, "too_little", text)


def may_name(record: Record, model: Model, assume: tuple[str, ...] = ()) -> tuple[Doubt, ...]:
    """What is doubtful of a record and a model's law on it, none of it grave but what is assumed to be meant.

    Raises NothingNamed: Refused for a kind of test that cannot be diagnosed, GraveDoubt, and TooLittle.
    """
    require_nameable(record, assume, len(model.params))
    doubts = doubts_about(fit(model, record, detail=False))
    _stop(record, doubts, assume)
    return doubts


def check_completed(one: Fit, assume: tuple[str, ...] = ()) -> None:
    """Raises GraveDoubt where a model with all that was named still leaves a large part of what varies."""
    force = one.record.force
    if not one.model.terms or force.std() < CONSTANT * abs(force.mean()) or one.r2 > 1.0 - MOST_LEFT:
        return
    text = (
        f"The {one.model.words} would leave {newtons(one.rmse)} rms of a force that varies by {newtons(force.std())} "
        "rms: names explain little here. Check units, signs and the specimen, or take another law."
    )
    law = Doubt("explains_nothing", text, "force", True)
    _stop(one.record, (law, *doubts_of(one.record)), assume)


def _stop(record: Record, doubts: tuple[Doubt, ...], assume: tuple[str, ...]) -> None:
    stops = grave(doubts, assume)
    if stops:
        raise GraveDoubt(_name(record), len(record), doubts, stops)


@contextmanager
def computing(record: Record | str | Path) -> Iterator[None]:
    """Numbers worked out on one thread; arithmetic that a degenerate record breaks becomes a FitError."""
    try:
        with one_blas_thread(), np.errstate(all="ignore"):
            yield
    except (np.linalg.LinAlgError, FloatingPointError, ZeroDivisionError, OverflowError) as error:
        raise FitError(
            f"{_name(record)}: the arithmetic breaks down on this record ({error}); check it for constant columns and "
            "values beyond reason"
        ) from None


def _name(record: Record | str | Path) -> str:
    return record.source or record.name if isinstance(record, Record) else str(record)
