"""What the page says, as HTML; every text that comes from a record or a user's file is escaped."""

from collections.abc import Mapping
from dataclasses import replace

from markupsafe import Markup

from ..core import Specimen, UsageError
from ..core.progress import Stage
from ..diagnosis.follows import told
from ..diagnosis.nouns import Diagnosis, Suspect
from ..notebook.pages import table
from ..records import Record, build_record
from ..records.doubt import Doubt
from ..report import tables
from ..report.words import STATUS, VERDICTS, equation, groups, newtons, titles
from .bench import Bench


def status(text: str, state: str) -> Markup:
    """Where the work is, for eyes and for screen readers."""
    return Markup('<p role="status" aria-live="polite" class="soft" data-state="{}">{}</p>').format(state, text)


def stage(now: Stage | None) -> str:
    """A stage of the work in a line."""
    if now is None:
        return "reading …"
    return " · ".join(one.what + (f" {one.done} of {one.of}" if one.of else "") for one in now.line) + " …"


def error(text: str) -> Markup:
    """What went wrong, and what to do."""
    return Markup('<p role="alert" class="error">{}</p>').format(text)


def head(bench: Bench | None) -> Markup:
    """Which record lies on the bench."""
    if bench is None:
        return Markup(
            '<p class="lead">Open a record of a test rig on the left, or drop it there with its specimen.toml: '
            "the law you choose is fitted, and the workbench says where it fails and what is missing.</p>"
        )
    record = bench.record
    levels = ", ".join(f"{p:g}" for p in record.levels[:8]) + (" …" if len(record.levels) > 8 else "")
    name = Markup('<h2>{}</h2><p class="soft">{} samples at {} MPa gauge pressure</p>').format(
        record.name, len(record), levels
    )
    return name + Markup("").join(_doubt(one) for one in bench.doubts)


def _doubt(one: Doubt) -> Markup:
    return Markup('<p role="note" class="{}">{}</p>').format("error" if one.grave else "soft", one.text)


def verdict(bench: Bench | None) -> Markup:
    """The verdict on the present model, and its errors."""
    if bench is None:
        return Markup("")
    found, rung = bench.diagnosis, bench.rungs[-1]
    facts = [("error now", newtons(rung.fit.rmse) + " rms"), ("on held-out data", newtons(rung.heldout_rmse))]
    if len(bench.rungs) > 1:
        facts.insert(0, ("error of the law alone", newtons(bench.law_alone.rmse) + " rms"))
    if bench.noise_floor is not None:
        facts.append(("noise floor", newtons(bench.noise_floor)))
    listed = Markup("").join(Markup("<div><dt>{}</dt><dd>{}</dd></div>").format(*fact) for fact in facts)
    parts = [Markup('<dl class="facts">{}</dl>').format(listed)]
    parts += [Markup('<p class="error">This fit is not valid: {}.</p>').format(one) for one in rung.fit.problems]
    if found is not None:
        badge, meaning = VERDICTS.get(found.verdict, (found.verdict, ""))
        notes = groups(found, titles(found.best.model))
        if found.next_experiment is not None:
            notes.append(f"Next experiment: {found.next_experiment.text}")
        parts = [
            Markup('<p><span class="badge">{}</span> <span class="soft">{}</span></p>').format(badge, meaning),
            Markup('<p class="lead">{}</p>').format(found.sentence),
            *parts,
            *[Markup("<p>{}</p>").format(note) for note in notes],
        ]
    return Markup("").join(parts)


def suspect(one: Suspect, known: Mapping[str, str]) -> Markup:
    """An effect by its title among the `known`, how likely it is, and what it would leave."""
    return Markup("<p>{}: probability {:.0%}, would leave {} rms, held out {}</p>").format(
        known.get(one.effect, one.effect), one.probability, newtons(one.rmse_after), newtons(one.heldout_rmse_after)
    )


def not_judged(found: Diagnosis) -> Markup:
    """Effects that this record cannot show."""
    lines = [
        Markup("<li>{}: {}{}</li>").format(one.label, STATUS[one.status], f" ({one.why})" if one.why else "")
        for one in found.ranking
        if one.status != "candidate"
    ]
    if not lines:
        return Markup("")
    return Markup("<details><summary>Neither suspected nor cleared: {}</summary><ul>{}</ul></details>").format(
        len(lines), Markup("").join(lines)
    )


def model(bench: Bench | None) -> Markup:
    """The model's equation, a line a part."""
    if bench is None:
        return Markup("")
    return Markup("").join(Markup("<p>{}</p>").format(line) for line in equation(bench.fit.model))


def where(bench: Bench | None, drawn: Mapping[str, Markup]) -> Markup:
    """Where the present model fails, in a sentence and figures."""
    if bench is None:
        return Markup("")
    figures = Markup("").join(drawn.get(name, Markup("")) for name in ("where", "along"))
    return Markup("<p>{}</p>{}").format(bench.comparison.sentence, figures)


def follows(bench: Bench | None, drawn: Mapping[str, Markup]) -> Markup:
    """What the present model's error follows, in a sentence and as a bar."""
    if bench is None:
        return Markup("")
    return Markup("<p>{}</p>{}").format(told(bench.comparison.follows), drawn.get("follows", Markup("")))


def parameters(bench: Bench | None) -> Markup:
    """The present model's parameters."""
    return Markup("") if bench is None else table(tables.parameters(bench.fit, "the present model"))


def command(bench: Bench | None) -> Markup:
    """The command line that repeats it."""
    if bench is None:
        return Markup("")
    return Markup('<p class="soft">The same on the command line:</p><pre tabindex="0">{}</pre>').format(bench.command)


def length(label: str, text: str) -> float:
    """The number that was typed into a field, with a point or a comma. Raises UsageError for anything else."""
    try:
        return float(text.strip().replace(",", "."))
    except ValueError:
        raise UsageError(f"{label}: {text!r}; expected a number") from None


def with_specimen(record: Record, specimen: Specimen) -> Record:
    """The record as measured on another specimen: the same displacement is another contraction."""
    inputs = record.inputs
    made = build_record(
        record.name,
        specimen,
        inputs.pressure,
        inputs.displacement_mm / specimen.initial_length_mm,
        record.force,
        time=inputs.time,
        level=record.level,
        cycle=inputs.cycle,
        direction=inputs.direction if inputs.direction.any() else None,
        temperature=inputs.temperature,
    )
    kept = ("source", "sha256", "columns", "masked", "notes", "said_kind")
    return replace(made, **{key: getattr(record, key) for key in kept})
