"""The verbs: each takes a record, or what one is read from, and a law and effects, by name or as objects."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, overload
from warnings import warn

from ..core import UsageError
from ..core.lmfit_names import from_lmfit_names
from ..fitting import Fit
from ..fitting import fit as old_fit
from ..model import Model
from ..tasks.fit import FitOptions, fit_record
from ..tasks.law_choice import AUTO, LawChoice
from ..tasks.together import fit_records
from .answers import ComparisonResult, DiagnosisResult, LadderResult, RecordAnswer
from .asking import ObjectSetup, settled, setup_of
from .fitted import FitResult
from .record import ShownRecord, read
from .together import SharedFitResult
from .working import no_argument, worked


@overload
def fit(record: Any, law: Any = ..., effects: Any = ..., *, shared: None = None, **more: Any) -> FitResult: ...


@overload
def fit(record: Any, law: Any = ..., effects: Any = ..., *, shared: Any, **more: Any) -> SharedFitResult: ...


@worked
def fit(
    record: Any,
    law: Any = AUTO,
    effects: Any = (),
    *,
    shared: Any = None,
    specimen: Any = None,
    branch: str = "together",
    method: str = "global",
    held: Any = None,
    weights: str = "equal",
    loss: str = "linear",
    intervals: str = "linear",
    free_geometry: bool = False,
    **old: Any,
) -> FitResult | SharedFitResult:
    """Fit a law, with or without effects, to a record, or to several at once.

    Args:
        record: a Record, or what `pam.read` takes.
        law: name, Law or Model; by default the one that predicts held-out data best.
        effects: names (`creep`, `creep:prony_3`) or Effects, one or several.
        shared: of a list of records, fitted together: the parameters that have one value for all; names, an effect's
            for all of its own, or `all`. Any other is each record's own.
        specimen: the muscle, as `pam.read` takes it.
        branch: together, separate, contraction or extension.
        method: global; or two-stage, each isobar alone and then over pressure.
        held: parameters that keep a value, a dictionary by name; or lmfit's Parameters, whose values are all kept.
        weights: equal, or sensors, from the specimen's sensors.
        loss: linear, or huber.
        intervals: linear, profile or bootstrap.
        free_geometry: whether radius and braid angle are fitted, too.
        old: what the function of this name took before.

    Raises:
        UsageError: for an unknown name, with those that look like it.
        DataError, FitError: where the record cannot be read or fitted.

    Example:
        >>> import pam_ident as pam
        >>> fitted = pam.fit("dmsp20_300", "martens_boblan")
        >>> print(fitted)
        Rubber law of Martens and Boblan fitted to DMSP-20-300: 3.21 N rms, 7.70 N at most, R² 0.999924, 60 samples
        >>> print(fitted.predict(0.25, 0.1)[["force_N", "reading_low_N", "reading_high_N"]].round(0).to_string())
           force_N  reading_low_N  reading_high_N
        0    135.0          115.0           155.0
    """
    if _is_old("fit", record, old):
        _say_old("fit", "pam.fit(record, law, effects)", "pam_ident.fitting")
        return old_fit(record, law, *([effects] if effects != () else []), held=held, **old)  # type: ignore[return-value]
    setup = setup_of(law, effects, free_geometry=free_geometry)
    wishes = FitOptions(branch, method, _held(held), weights, loss, intervals)
    if shared is not None:
        names = (shared,) if isinstance(shared, str) else tuple(shared)
        return SharedFitResult(fit_records([read(one, specimen) for one in record], setup, names, wishes), setup)
    measured = read(record, specimen)
    setup, choice = settled(measured, setup)
    return FitResult(fit_record(measured, setup, wishes), setup, choice)


@worked
def compare(
    record: Any, law: Any = AUTO, effects: Any = (), *, specimen: Any = None, free_geometry: bool = False
) -> ComparisonResult:
    """Where a law fails on a record.

    Args:
        record: a Record, what `pam.read` takes, or a result, whose model is asked about.
        law, effects, specimen, free_geometry: as `pam.fit` takes them.

    Raises:
        UsageError, DataError, FitError: as `pam.fit`.

    Example:
        >>> import pam_ident as pam
        >>> found = pam.compare("hidden_effect", "exponential_law")
        >>> print(found.follows["share"].idxmax())
        direction
    """
    from ..diagnosis import compare as old_compare
    from ..tasks.compare import compare_record

    if isinstance(record, Fit):
        _say_old("compare", "pam.compare(record, law)", "pam_ident.diagnosis")
        return old_compare(record)  # type: ignore[return-value]
    measured, setup, choice = _asked(record, law, effects, specimen, free_geometry=free_geometry)
    return ComparisonResult(compare_record(measured, setup), setup, choice)


@worked
def diagnose(
    record: Any,
    law: Any = AUTO,
    effects: Any = (),
    *,
    specimen: Any = None,
    without: Any = (),
    only: Any = (),
    also: Any = (),
    prior: str | None = None,
    extra: Any = (),
    assume: Any = (),
    heldout: str = "",
    free_geometry: bool = False,
    **old: Any,
) -> DiagnosisResult:
    """Which effect a law lacks on a record, or that it lacks none.

    Args:
        record: a Record, what `pam.read` takes, or a result, whose model is asked about.
        law, effects, specimen, free_geometry: as `pam.fit` takes them.
        without, only: effects that are not tried, or the only ones that are.
        also: effects that are tried though they are no candidates by themselves, such as `moving_mass`.
        prior: TOML file of prior odds of effects, lines such as `creep = 10`.
        extra: Effects of your own that are tried beside the known ones.
        assume: codes of grave warnings that are meant so, or `all`; they do not stop naming then.
        old: what the function of this name took before.
        heldout: `length`, `pressure`, `run`, `cycle` or `muscle`, held out whole while everything is chosen anew.

    Raises:
        UsageError, DataError, FitError: as `pam.fit`, and where a record looks wrong, cannot show causes, or holds too
            little.

    Example:
        >>> import pam_ident as pam
        >>> print(pam.diagnose("nothing_hidden", "exponential_law").verdict)
        adequate
    """
    from ..diagnosis import diagnose as old_diagnose
    from ..tasks.diagnose import diagnose_record

    if _is_old("diagnose", record, old):
        _say_old("diagnose", "pam.diagnose(record, law)", "pam_ident.diagnosis")
        return old_diagnose(record, law, tuple(effects or extra), tuple(without), tuple(only), **old)  # type: ignore[return-value]
    measured, setup, choice = _asked(
        record, law, effects, specimen, without=without, only=only, also=also, prior=prior, extra=extra, assume=assume,
        heldout=heldout, free_geometry=free_geometry, naming=True,
    )  # fmt: skip
    return DiagnosisResult(diagnose_record(measured, setup), setup, choice)


@worked
def ladder(
    record: Any,
    law: Any = AUTO,
    effects: Any = (),
    *,
    specimen: Any = None,
    without: Any = (),
    only: Any = (),
    also: Any = (),
    extra: Any = (),
    assume: Any = (),
    heldout: str = "",
    free_geometry: bool = False,
) -> LadderResult:
    """Diagnose and add, down to the noise.

    Args:
        record, law, effects, specimen, without, only, also, extra, assume, free_geometry: as `pam.diagnose` takes them.
        heldout: `length`, `pressure`, `run`, `cycle` or `muscle`, held out whole while everything is chosen anew;
            `refit` to refit the parameters alone, at a quarter of the time. By default what suits the record.

    Raises:
        UsageError, DataError, FitError: as `pam.diagnose`.

    Example:
        >>> import pam_ident as pam
        >>> print(len(pam.ladder("nothing_hidden", "exponential_law", heldout="refit")), "rung")
        1 rung
    """
    from ..tasks.ladder import climb_ladder

    measured, setup, choice = _asked(
        record, law, effects, specimen, without=without, only=only, also=also, extra=extra, assume=assume,
        heldout=heldout, free_geometry=free_geometry, naming=True,
    )  # fmt: skip
    return LadderResult(climb_ladder(measured, setup), setup, choice)


@worked
def report(
    record: Any,
    law: Any = AUTO,
    effects: Any = (),
    *,
    out: str | Path = "report.html",
    specimen: Any = None,
    without: Any = (),
    only: Any = (),
    also: Any = (),
    assume: Any = (),
    heldout: str = "",
    free_geometry: bool = False,
) -> Path:
    """Write the whole answer about a record into one file: HTML, Markdown or PDF, by its ending.

    Args:
        record, law, effects, specimen, without, only, also, assume, free_geometry: as `pam.diagnose` takes them.
        out: the file.
        heldout: `length`, `pressure`, `run`, `cycle` or `muscle`, held out whole while everything is chosen anew;
            `refit` to refit the parameters alone, at a quarter of the time. By default what suits the record.

    Raises:
        UsageError, DataError, FitError: as `pam.diagnose`, and where the file cannot be written.

    Example:
        >>> import pam_ident as pam
        >>> print(pam.report("nothing_hidden", "exponential_law", out="answer.html", heldout="refit"))
        answer.html
    """
    from ..tasks.report import check_report, report_record

    check_report(str(out))
    measured, setup, _ = _asked(
        record, law, effects, specimen, without=without, only=only, also=also, free_geometry=free_geometry,
        assume=assume, heldout=heldout,
    )  # fmt: skip
    report_record(measured, setup, str(out))
    return Path(out)


def _asked(
    record: Any, law: Any, effects: Any, specimen: Any, naming: bool = False, **more: Any
) -> tuple[ShownRecord, ObjectSetup, LawChoice | None]:
    """The record, what is asked of it, and how its law was chosen; of a result its own model, where none was named."""
    if isinstance(record, FitResult | RecordAnswer):
        own = record if isinstance(record, FitResult) else record.fit
        measured, law = own.record, own.model if law == AUTO else law
    else:
        measured = read(record, specimen)
    return measured, *settled(measured, setup_of(law, effects, **more), naming)


def _held(given: Any) -> dict[str, float]:
    """Values of parameters by name. Raises UsageError for anything else."""
    try:
        if hasattr(given, "valuesdict"):
            return from_lmfit_names(given.valuesdict())
        return {name: float(value) for name, value in (given or {}).items()}
    except (AttributeError, TypeError, ValueError):
        raise UsageError(f"held={given!r}: expected a number by parameter, such as held={{'mu': 40.0}}") from None


def _is_old(name: str, record: Any, old: Mapping[str, Any]) -> bool:
    """Whether a function is called as it was before. Raises UsageError for an argument that it does not have."""
    if isinstance(record, Model) or "model" in old:
        return True
    for word in old:
        raise no_argument(globals()[name], word)
    return False


def _say_old(name: str, new: str, home: str) -> None:
    warn(
        f"pam_ident.{name} takes a record first: {new}. What it was is {home}.{name}; this goes in the next version",
        DeprecationWarning,
        stacklevel=4,
    )
