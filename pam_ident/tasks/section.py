"""All that a report says about one record."""

from dataclasses import replace

from ..core import FitError
from ..diagnosis import compare
from ..diagnosis.nested import HERE
from ..diagnosis.nouns import Diagnosis, Ladder
from ..fitting import Fit, IsobarTable, fit_isobars, loop_energies
from ..fitting.energy import energy_warning, model_loops
from ..model import Model
from ..parallel.executor import Executor
from ..records import Record
from ..report import Section
from .gate import computing, doubt_values, doubts_about, effect_warnings
from .ladder import climb_ladder
from .setup import Setup


def build_section(record: Record, setup: Setup, executor: Executor = HERE) -> Section:
    """Diagnosis, ladder, comparisons before and after, isobars and loops of one record.

    `executor` chooses anew without the held-out rows. Raises FitError or DataError, NothingNamed among them.
    """
    with computing(record):
        ladder = climb_ladder(record, setup, executor)
        diagnosis = ladder.first
        return section_of(record, diagnosis.base, diagnosis, ladder, completed(diagnosis, ladder))


def section_of(record: Record, base: Fit, diagnosis: Diagnosis, ladder: Ladder, best: Fit | None) -> Section:
    """The section of what has been found: `base` is the law as given, `best` the completed model, None without one."""
    held = record.kind == "isobaric"
    loops = model_loops({"together": best or base}) if held else {}
    return Section(
        record,
        compare(base),
        diagnosis,
        compare(best) if best is not None else None,
        ladder,
        _isobars(base.model, record) if held else (),
        loop_energies(record, record.force) if held else {},
        loops,
        _warnings(base, best or base, loops),
    )


def completed(diagnosis: Diagnosis, ladder: Ladder) -> Fit | None:
    """The model with all that was found missing: the ladder's last rung, or the diagnosis' where that fits better.

    None where nothing was added. Where the ladder is nested, what it left out for that is not in it.
    """
    if ladder.nested is not None:
        return ladder.rungs[-1].fit if len(ladder.rungs) > 1 else None
    found = [diagnosis.best] if diagnosis.selected else []
    if len(ladder.rungs) > 1:
        found.append(ladder.rungs[-1].fit)
    return min(found, key=lambda one: one.rmse) if found else None


def _isobars(model: Model, record: Record) -> tuple[IsobarTable, ...]:
    """The law alone, isobar by isobar, where it has parameters and the isobars have samples enough."""
    if not model.law.params:
        return ()
    both = all((record.inputs.direction == sign).any() for sign in (1.0, -1.0))
    try:
        return (fit_isobars(replace(model, terms=()), record, ("contraction", "extension") if both else ("together",)),)
    except FitError:
        return ()


def _warnings(base: Fit, best: Fit, loops: dict[float, float]) -> tuple[str, ...]:
    doubts = [*doubts_about(base), *(doubt_values(best) if best is not base else ())]
    energy = energy_warning(loops)
    return (*(doubt.text for doubt in doubts), *effect_warnings(best.model), *([energy] if energy else []))
