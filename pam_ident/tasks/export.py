"""A fitted model in the language of another program."""

from dataclasses import dataclass, replace
from pathlib import Path

from ..core import UsageError
from ..core.files import check_target, write_json, write_whole
from ..effects import load_effect_files
from ..export.fitted import Fitted
from ..export.targets import get_target
from ..records import read_specimen
from ..schema.fit import fit_json
from .fit import FitAnswer, FitOptions, fit_record
from .law_choice import settle
from .setup import Setup


@dataclass(frozen=True)
class Exported:
    """The files written, what is to be said of them, and why the fit is not valid, if it is not."""

    paths: tuple[Path, ...]
    notes: tuple[str, ...]
    problems: tuple[str, ...]


def check_export(to: str, out: str) -> Path:
    """Where an export is to go. Raises UsageError for an unknown kind, a wrong ending or a folder that is not there."""
    return check_target(out, (".json" if to == "json" else get_target(to).suffix,))


def export_fit(
    source: str, to: str, out: str, effect_files: tuple[str, ...] = (), specimen: str | None = None
) -> Exported:
    """Write the model in a file of `fit --json`, `add --json` or `ladder --json`, of a ladder the last rung.

    `effect_files` hold effects of a user's own that the file names; `specimen` stands in for the file's. Raises
    UsageError for what cannot be exported, DataError for a file that cannot be read.
    """
    path = check_export(to, out)
    if to == "json":
        raise UsageError(f"{source}: is a fit as JSON already; copy it, or give a record with --law LAW")
    if not source.lower().endswith(".json"):
        raise UsageError(f"{source}: expected a file that `fit --json` wrote; to fit a record now add --law LAW")
    extra = load_effect_files(effect_files)
    given = None if specimen is None else read_specimen(specimen)
    return _write(Fitted.read(source, given, extra), to, path)


def export_record(source: str, to: str, out: str, setup: Setup, branch: str = "together") -> Exported:
    """Fit a model to a record and write it. Raises as `fit_record` and `export_fit` do."""
    check_export(to, out)
    record = setup.read(source)
    setup, choice = settle(record, setup)
    found = export_answer(fit_record(record, setup, FitOptions(branch=branch)), to, out, source)
    return replace(found, notes=(f"law: {choice.why}", *found.notes)) if choice else found


def export_answer(answer: FitAnswer, to: str, out: str, source: str) -> Exported:
    """Write a fit to the record `source`. Raises as `export_fit` does."""
    path = check_export(to, out)
    fitted = Fitted.of(answer.fits)
    if to == "json":
        write_json(path, fit_json(source, fitted.model.law.name, answer))
        return Exported((path,), (), fitted.problems)
    return _write(fitted, to, path)


def _write(fitted: Fitted, to: str, path: Path) -> Exported:
    """The file's name without its ending names the function in it; a file beside it that nobody named replaces only an
    earlier one of its kind. Raises UsageError where another is there."""
    made = get_target(to).write(fitted, path.stem)
    beside = {check_target(path.with_suffix(end)): text for end, text in made.beside.items()}
    for one in beside:
        if one.exists() and made.mark not in one.read_text(encoding="utf-8", errors="replace"):
            other = path.with_stem(f"{path.stem}_{to}")
            raise UsageError(f"{one}: is there already, and not from --to {to}, which writes it, too; --out {other}")
    texts = {path: made.text} | beside
    paths = tuple(write_whole(where, text) for where, text in texts.items())
    notes = (*made.notes, f"{fitted.caution} (docs/exports.md)") if fitted.caution else made.notes
    return Exported(paths, notes, fitted.problems)
