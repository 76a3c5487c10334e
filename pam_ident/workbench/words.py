"""What the page says, as HTML; every text that comes from a record or a user's file is escaped."""

import math
from typing import Any

from markupsafe import Markup

from ..core import UsageError
from ..core.progress import Stage
from ..core.prose import capital
from ..diagnosis import sentence
from ..diagnosis.nouns import Diagnosis, Follows
from ..diagnosis.sentence import told
from ..effects import in_words
from ..fitting.estimate import impossible
from ..notebook.pages import table
from ..plot.follows import COLOUR
from ..plot.style import INK
from ..records.doubt import Doubt
from ..report import tables
from ..report.words import equation, groups, likely, newtons, number, stderr, value_of
from ..schema.diagnosis import STATUS, candidates
from .bench import Bench
from .draft import Draft, DraftColumn


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
            '<p class="lead">Open a record of a test rig, or drop its file anywhere: the law you choose is '
            "fitted, and the workbench says where it fails and what is missing.</p>"
        )
    record = bench.record
    levels = ", ".join(f"{p:g}" for p in record.levels[:8]) + (" …" if len(record.levels) > 8 else "")
    name = Markup('<h2>{}</h2><p class="soft">{} samples at {} MPa gauge pressure</p>').format(
        record.name, len(record), levels
    )
    return name + Markup("").join(_doubt(one) for one in bench.doubts)


def _doubt(one: Doubt) -> Markup:
    return Markup('<p role="note" class="{}">{}</p>').format("error" if one.grave else "soft", one.text)


def draft(shown: Draft, wrong: str = "") -> Markup:
    """What is still to be said of a dropped file."""
    lines = [Markup("<h2>What was dropped</h2>")]
    lacking = [*shown.missing, *([] if shown.has_specimen else ["the muscle's size"])] if shown.ours else []
    if not shown.ours and shown.problem:
        lines.append(Markup("<p>Fix the file, or its columns.toml, and drop it again.</p>"))
    elif shown.missing:
        lines.append(Markup("<p>Say which column is {}.</p>").format(", and ".join(lacking)))
    else:
        unsure = [c.name for c in shown.columns if c.guess.quantity and not c.guess.sure]
        if unsure:
            lines.append(Markup("<p><b>Guessed from the numbers, so check it: {}.</b></p>").format(", ".join(unsure)))
        lines.append(Markup("<p>Check what each column is and its unit{}, then open it.</p>").format(
            "" if shown.has_specimen else ", type in the muscle's size"
        ))  # fmt: skip
    lines += [error(wrong)] if wrong else []
    return Markup("").join(lines)


def column(one: DraftColumn) -> Markup:
    """A column of a dropped file: its name, first cells and range."""
    span = f"{number(one.low)} to {number(one.high)}" if one.low == one.low else "no numbers"
    return Markup('<p><b>{}</b><br><span class="soft">{} …<br>{}</span></p>').format(
        one.name, ", ".join(one.first), span
    )


def headline(found: Diagnosis) -> tuple[str, str]:
    """The verdict in a few words, effects by their plain names, and what is left."""
    first = sentence.start(found.base, found.noise_floor)
    if found.verdict == "adequate":
        return "Nothing is missing that this record could show.", first
    left = ""
    if found.verdict == "unknown_effect" or found.pattern is not None:
        what = f": {found.pattern.text}" if found.pattern else ""
        left = f"Something is left that no known effect explains{what}."
    if not found.selected:
        return left or "Something is missing.", first
    first += f" With {'it' if len(found.selected) == 1 else 'them'} {newtons(found.best.rmse)} are left."
    return sentence.headline(found.selected, [found], found.best.model.own), f"{first} {left}".strip()


def verdict(bench: Bench | None) -> Markup:
    """The verdict on the present model, and its errors."""
    if bench is None:
        return Markup("")
    found, rung = bench.diagnosis, bench.rungs[-1]
    facts = [("error now", newtons(rung.fit.rmse) + " rms")]
    facts += [("on held-out data", newtons(rung.heldout_rmse))] * math.isfinite(rung.heldout_rmse)
    if len(bench.rungs) > 1:
        facts.insert(0, ("error of the law alone", newtons(bench.law_alone.rmse) + " rms"))
    if bench.noise_floor is not None:
        facts.append(("noise", newtons(bench.noise_floor)))
    listed = Markup("").join(Markup("<div><dt>{}</dt><dd>{}</dd></div>").format(*fact) for fact in facts)
    parts = [Markup('<dl class="facts">{}</dl>').format(listed), _fall(bench)]
    parts += [Markup('<p class="error">This fit is not valid: {}.</p>').format(one) for one in rung.fit.problems]
    parts += [Markup('<p class="error">{}.</p>').format(impossible(one)) for one in rung.fit.impossible]
    parts += [Markup("<p>{}.</p>").format(one) for one in rung.fit.at_bounds]
    if bench.held:
        parts.append(Markup("<p>Parameters are held by hand. Release them to have named what is missing.</p>"))
    if found is not None:
        notes = groups(found)
        if found.next_experiment is not None:
            notes.append(f"Next experiment: {found.next_experiment.text}")
        parts = [
            Markup('<p class="lead"><b>{}</b> {}</p>').format(*headline(found)),
            *parts,
            *[Markup("<p>{}</p>").format(note) for note in notes],
        ]
    return Markup("").join(parts)


def _fall(bench: Bench) -> Markup:
    """The error now as a bar beside that of the law alone, with the noise as a line."""
    first, now, floor = bench.law_alone.rmse, bench.fit.rmse, bench.noise_floor
    most = max(first, now, floor or 0.0, 1e-12)
    noise = "" if floor is None else f"--noise:{floor / most:.4f}"
    return Markup('<div class="bar large" aria-hidden="true" style="--share:{};{}"></div>').format(
        f"{now / most:.4f}", noise
    )


def follows(found: tuple[Follows, ...]) -> Markup:
    """What the error follows, as one bar and in a sentence."""
    if not found:
        return Markup("")
    parts = [
        Markup('<span style="flex:{} 0 0;background:{}"></span>').format(f"{one.share:.4f}", COLOUR.get(one.what, INK))
        for one in found
    ]
    bar = Markup('<div class="shares" aria-hidden="true">{}</div>').format(Markup("").join(parts))
    return Markup("<h2>What the error follows</h2>{}<p>{}</p>").format(bar, told(found))


def candidate_cards(bench: Bench | None) -> list[dict[str, Any]]:
    """The candidates as cards: the most probable first, each with the error that adding it leaves."""
    found = bench.diagnosis if bench else None
    if bench is None or found is None:
        return []
    known = found.best.model.own
    now, noise = max(bench.fit.rmse, 1e-12), (bench.noise_floor or 0.0) / max(bench.fit.rmse, 1e-12)
    tried = [
        {
            "key": one.label,
            "title": capital(in_words(one.label, known)),
            "text": f"probability {likely(one.probability)} · leaves {newtons(one.rmse)}",
            "bar": min(one.rmse / now, 1.0), "noise": min(noise, 1.0), "traced": True,
            "kind": "named" if one.label in found.labels else "",
        }
        for one in bench.previews
    ]  # fmt: skip
    return tried or [
        {
            "key": one.label,
            "title": capital(in_words(one.effect, known)),
            "text": f"probability {likely(one.probability)}",
        }
        for one in candidates(found)[:3]
    ]


def no_candidates(bench: Bench | None) -> Markup:
    """In place of candidates, why there are none; else how to use them."""
    if bench is None:
        return Markup('<p class="soft">Candidates stand here once a record is open.</p>')
    if bench.diagnosis is None:
        return Markup('<p class="soft">Not looked for yet.</p>')
    if bench.diagnosis.verdict == "adequate":
        return Markup("<p>Nothing: the error is down to the noise.</p>")
    return Markup('<p class="soft">Point at one to see its trace in the error; choose it to add it.</p>')


def not_judged(bench: Bench | None) -> Markup:
    """Effects that this record cannot show."""
    found = bench.diagnosis if bench else None
    known = found.best.model.own if found else ()
    lines = [
        Markup("<li>{}: {}{}</li>").format(
            in_words(one.label, known), STATUS[one.status], f" ({one.why})" if one.why else ""
        )
        for one in (found.ranking if found else ())
        if one.status != "candidate"
    ]
    if not lines:
        return Markup("")
    return Markup("<details><summary>Not judged from this record: {}</summary><ul>{}</ul></details>").format(
        len(lines), Markup("").join(lines)
    )


def steps(benches: list[Bench], at: int) -> list[dict[str, Any]]:
    """What was done, as cards, with undo and redo."""
    if not benches:
        return []
    found: list[dict[str, Any]] = [
        {"key": "undo", "title": "Undo", "disabled": at <= 0},
        {"key": "redo", "title": "Redo", "disabled": at + 1 >= len(benches)},
    ]
    for k, one in enumerate(benches):
        text = newtons(one.fit.rmse)
        title = _step(benches[k - 1] if k else None, one)
        found.append({"key": str(k), "title": title, "text": text, "current": k == at, "kind": "step"})
    return found


def _step(before: Bench | None, now: Bench) -> str:
    """What led from one bench to the next."""
    if before is not None and before.record is not now.record:
        return now.record.name
    if before is None or before.setup.law != now.setup.law:
        return capital(now.fit.model.law.title)
    if before.held != now.held:
        return f"{', '.join(now.held)} held" if now.held else "released"
    was, held = set(before.fit.model.effect_names), set(now.fit.model.effect_names)
    known = (*now.fit.model.own, *before.fit.model.own)
    changes = [f"+ {in_words(n, known)}" for n in held - was] + [f"− {in_words(n, known)}" for n in was - held]
    return ", ".join(changes) or capital(now.fit.model.law.title)


def against(first: Bench | None, now: Bench | None) -> Markup:
    """The pinned model A beside the present one, B."""
    if first is None or now is None:
        return Markup("<p>Pin a model as A, change it, and compare.</p>")
    rows = [("model", first.fit.model.words, now.fit.model.words)]
    rows += [("error", newtons(first.fit.rmse) + " rms", newtons(now.fit.rmse) + " rms")]
    rows.append(("on held-out data", newtons(first.rungs[-1].heldout_rmse), newtons(now.rungs[-1].heldout_rmse)))
    follow = [told(b.diagnosis.follows) if b.diagnosis else "–" for b in (first, now)]
    rows.append(("what the error follows", follow[0], follow[1]))
    values = [
        {e.name: f"{value_of(e)} ± {stderr(e)} {'' if e.unit == '1' else e.unit}" for e in b.fit.estimates}
        for b in (first, now)
    ]
    rows += [(name, *(one.get(name, "–") for one in values)) for name in dict.fromkeys([*values[0], *values[1]])]
    shown = tables.PageTable(f"A ({first.record.name}) and B ({now.record.name})", ("", "A", "B"), tuple(rows))
    return table(shown)


def model(bench: Bench | None) -> Markup:
    """The model's equation, a line a part."""
    if bench is None:
        return Markup("")
    return Markup("").join(Markup('<p class="soft">{}</p>').format(line) for line in equation(bench.fit.model))


def where(bench: Bench | None) -> Markup:
    """Where the present model fails, in a sentence."""
    if bench is None or bench.diagnosis is None:
        return Markup("")
    return Markup("<p>{}</p>").format(bench.comparison.sentence)


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
