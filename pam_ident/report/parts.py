"""What a report says about one record, part by part, in the order a reader asks."""

from collections.abc import Callable
from dataclasses import replace

from .. import plot
from ..core.prose import capital
from ..diagnosis.nouns import Diagnosis
from ..effects import named
from ..records import Record
from . import tables
from .easel import Easel, Part
from .easel import live as figures_of
from .opening import held_out, opening
from .rungs import steps
from .story import Section
from .words import equation, groups, newtons, percent


def parts(section: Section, prefix: str, points: int, samples: int = 0) -> tuple[Part, ...]:
    """All parts that the section has something to say in; figures to zoom into have so many `samples`, if any."""
    easel = Easel(prefix, points, figures_of(section.before, section.after, samples))
    builders: tuple[Callable[[Section, Easel], Part | None], ...] = (
        opening,
        _numbers,
        _measured,
        _failure,
        _candidates,
        _ladder,
        _pattern,
        _parameters,
        _isobars,
        _passivity,
        _warnings,
        _source,
    )
    found = (build(section, easel) for build in builders)
    return tuple(part for part in found if part is not None)


def _numbers(section: Section, easel: Easel) -> Part:
    fits = [section.before, *([section.after] if section.after else [])]
    facts = (
        ("model", fits[-1].model.words),
        ("error", " → ".join(newtons(one.rmse) for one in fits) + " rms"),
        ("held-out error", held_out(section)),
        ("noise", newtons(section.noise_floor)),
        ("record", f"{len(section.record)} samples, {_kind(section.record)}"),
    )
    text = () if section.ladder else (section.diagnosis.sentence,)  # a ladder says it of each of its steps
    return Part(f"{easel.prefix}-numbers", "The answer in numbers", text, facts=facts)


def _kind(record: Record) -> str:
    return f"{len(record.levels)} isobars" if record.inputs.pressure_rate is None else f"{record.kind}: pressure driven"


def _measured(section: Section, easel: Easel) -> Part:
    before, after = section.before, section.after
    figure = plot.measured_against_model.draw(before, after, easel.points)
    levels, live = None, None
    if section.record.drives_pressure:
        what = "The answer to the pressure"
        caption = (
            "What answered the pressure: points are measured, lines are the model. Below, the error measured − model"
        )
    else:
        what = "Force over contraction"
        caption = (
            "Force over contraction ratio at each pressure. Points are measured, lines are the model; in a record in "
            "time a line is the model's mean over all cycles and speeds. Below, the error measured − model of every "
            "point shown"
        )
        levels = {gid: f"{level:g} MPa" for gid, level in plot.measured_against_model.isobars(before).items()}
        live = easel.live and easel.live.isobars
    label = f"{what}, measured and modelled by the {before.model.words}, and the error below"
    caption += ", before and after adding the effects, on one scale." if after else "."
    picture = easel.hang(figure, label, caption, levels, levels, live)
    return Part(f"{easel.prefix}-measured", "Measured against model", pictures=(picture,))


def _failure(section: Section, easel: Easel) -> Part:
    comparison = section.comparison
    cells = plot.failure_map.cells(plot.failure_map.data(comparison))
    pictures = [
        easel.hang(
            plot.failure_map.draw(comparison),
            "Heat map of the mean error over pressure and contraction, by branch; the table of its cells has the same",
            "Mean error (N) in each cell of pressure and contraction. Framed: the cells with the largest share of the "
            "squared error. Grey: no sample. A pointer on a cell brings up its numbers; the table has all of them.",
            plot.failure_map.tips(comparison),
            live=easel.live and easel.live.mapped(comparison),
        )
    ]
    if plot.profiles.data(comparison):
        pictures.append(
            easel.hang(
                plot.profiles.draw(comparison),
                "Mean and rms error along each coordinate of the test",
                "The error along each coordinate: points are its mean, the band is ± its rms about zero. A point at "
                "the band's edge is systematic error; a point near zero in a wide band is error that cancels.",
            )
        )
    text = [comparison.sentence]
    if section.comparison_after is not None:
        text.append(f"With the effects added: {section.comparison_after.sentence}")
    table = tables.cells(cells)
    return Part(f"{easel.prefix}-failure", "Where the model fails", tuple(text), tuple(pictures), (table,))


def _candidates(section: Section, easel: Easel) -> Part | None:
    diagnosis = section.diagnosis
    if not diagnosis.ranking:
        return None
    if diagnosis.verdict == "adequate":
        table, text = (
            tables.not_judged(diagnosis),
            "Nothing is missing. These effects cannot be judged from this record.",
        )
        return (
            Part(f"{easel.prefix}-candidates", "What was not judged", (text,), tables=(table,)) if table.rows else None
        )
    caption = (
        "What each effect would leave of the error. In grey italics: effects that this "
        "record cannot show or that the law already imitates; they may be there or not."
    )
    drawn = plot.candidates.draw(replace(diagnosis, noise_floor=section.noise_floor))
    picture = easel.hang(drawn, "Bars of the error that each candidate would leave", caption)
    notes = groups(diagnosis)
    if diagnosis.next_experiment:
        experiment = diagnosis.next_experiment
        vary = f" (vary: {', '.join(experiment.vary)})" if experiment.vary else ""
        notes.append(f"Next experiment: {experiment.text}{vary}")
    return Part(
        f"{easel.prefix}-candidates",
        "Which effect is missing",
        (_selected(diagnosis),),
        (picture,),
        (tables.candidates(diagnosis),),
        tuple(notes),
    )


def _selected(diagnosis: Diagnosis) -> str:
    if not diagnosis.selected:
        return "No effect is selected."
    names = (named(label, diagnosis.best.model.own) for label in diagnosis.labels)
    return f"Selected, largest first: {'; '.join(names)}."


def _ladder(section: Section, easel: Easel) -> Part | None:
    ladder = section.ladder
    if ladder is None or not ladder.rungs:
        return None
    first, last = ladder.rungs[0].fit.rmse, ladder.rungs[-1].fit.rmse
    count = len(ladder.rungs) - 1
    anchor, heading = f"{easel.prefix}-ladder", "The falling error"
    notes = (f"Why it ends there: {ladder.last.sentence}", *([ladder.nested.text] if ladder.nested else []))
    if count == 0:
        text = f"No effect was added to the law, which leaves {newtons(first)} rms."
        return Part(anchor, heading, (text,), tables=(tables.ladder(ladder),), notes=notes)
    text = (
        f"From {newtons(first)} to {newtons(last)} rms in {count} step{'' if count == 1 else 's'}; "
        f"the noise floor is {newtons(ladder.noise_floor)}."
    )
    return Part(
        anchor,
        heading,
        (text,),
        tables=(tables.ladder(ladder),),
        notes=notes,
        steps=steps(ladder, easel, [one for one in (section.before, section.after) if one]),
    )


def _pattern(section: Section, easel: Easel) -> Part | None:
    pattern = section.diagnosis.pattern
    if pattern is None:
        return None
    picture = easel.hang(
        plot.residual_pattern.draw(section.diagnosis.best, pattern),
        f"Mean error left by the best model along {pattern.coordinate}",
        "The mean of what the best model leaves, with a band of ± 2 standard errors. Dotted: the place, the moment or "
        "the periods that the pattern names.",
    )
    text = f"{capital(pattern.text)}. It holds {percent(pattern.share)} of the squared error that was to be explained."
    return Part(f"{easel.prefix}-pattern", "What no known effect explains", (text,), (picture,))


def _parameters(section: Section, easel: Easel) -> Part:
    before, after = section.before, section.after
    last = after or before
    shown = tables.fitted(before, "the law as given")
    if after is not None:
        shown += tables.fitted(after, "the completed model")
    return Part(
        f"{easel.prefix}-parameters",
        "Parameters",
        tuple(equation(last.model)),
        tables=shown,
        notes=tuple(f"This fit is not valid: {problem}." for problem in last.problems),
    )


def _isobars(section: Section, easel: Easel) -> Part | None:
    shown = [table for one in section.isobar_tables for table in tables.isobars(one)]
    if not shown:
        return None
    text = "Coefficients that wander with pressure show what one shared set of parameters has to average over."
    return Part(f"{easel.prefix}-isobars", "Isobar by isobar", (text,), tables=tuple(shown))


def _passivity(section: Section, easel: Easel) -> Part | None:
    if not section.loop_measured and not section.loop_model:
        return None
    bad = [p for p, energy in sorted(section.loop_model.items()) if energy < -1e-4]
    text = "A muscle under constant pressure can only take up energy in a closed loop."
    if bad:
        places = ", ".join(f"{p:g}" for p in bad)
        text += f" The model gives energy back at {places} MPa; do not use it in a control loop there."
    elif section.loop_model:
        text += " The model gives none back at any pressure."
    return Part(f"{easel.prefix}-passivity", "Energy of the loops", (text,), tables=(tables.loops(section),))


def _warnings(section: Section, easel: Easel) -> Part | None:
    if not section.warnings:
        return None
    return Part(f"{easel.prefix}-warnings", "Warnings", notes=section.warnings)


def _source(section: Section, easel: Easel) -> Part:
    return Part(f"{easel.prefix}-record", "The record", tables=(tables.source(section.record),))
