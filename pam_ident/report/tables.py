"""The report's tables as plain text cells; the template gives them their HTML."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..diagnosis.nouns import Diagnosis, Ladder
from ..effects import named
from ..fitting import Fit, IsobarTable
from ..fitting.fit import Estimate
from ..model import steps
from ..plot.failure_map import Cell
from ..records import Record
from ..records.package import told
from ..schema.diagnosis import STATUS
from ..schema.diagnosis import candidates as likeliest
from ..schema.fit import in_order
from .story import Section
from .words import heldout, known_to, likely, newtons, number, percent, standing, stderr, unit, value_of


@dataclass(frozen=True)
class PageTable:
    """A caption, column heads, and rows of cells, the first of each row its head. `numeric` columns stand right.

    A `folded` table is opened by a reader who wants it; paper shows it. `ids` are anchors of rows by their heads,
    `links` anchors that the heads lead to.
    """

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[int, ...] = ()
    folded: bool = False
    ids: Mapping[str, str] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)


def candidates(diagnosis: Diagnosis) -> PageTable:
    """The candidates, the most probable first, then what the record cannot show."""
    known = diagnosis.best.model.own
    rows = tuple(
        (
            named(s.label or s.effect, known),
            "selected" if s.effect in diagnosis.selected else STATUS[s.status],
            likely(s.probability) if s.status == "candidate" else "–",
            number(s.rmse_after, 3),
            number(s.heldout_rmse_after, 3),
            s.why,
        )
        for s in (*likeliest(diagnosis), *(s for s in diagnosis.ranking if s.status != "candidate"))
    )
    head = ("effect", "standing", "probability", "error after (N rms)", "held-out error after (N rms)", "why")
    return PageTable("Candidates, and the error that is left with each", head, rows, (2, 3, 4))


def not_judged(diagnosis: Diagnosis) -> PageTable:
    """The effects that the record cannot show, and why."""
    known = diagnosis.best.model.own
    left = [s for s in diagnosis.ranking if s.status != "candidate"]
    rows = tuple((named(s.label or s.effect, known), STATUS[s.status], s.why) for s in left)
    return PageTable("Effects that this record and this law cannot show", ("effect", "standing", "why"), rows)


def ladder(climbed: Ladder) -> PageTable:
    """The falling errors, step by step."""
    names = steps((rung.fit.model for rung in climbed.rungs), named)
    rows = tuple(
        (
            str(i),
            name.replace("\n", ", "),
            str(len(rung.fit.model.params)),
            number(rung.fit.rmse, 3),
            number(rung.heldout_rmse, 3),
            number(rung.fit.max_error, 3),
            rung.why,
        )
        for i, (name, rung) in enumerate(zip(names, climbed.rungs, strict=True))
    )
    held = f"{heldout(climbed.rungs[-1])} (N rms)"
    head = ("step", "model", "free parameters", "error (N rms)", held, "largest error (N)", "why")
    return PageTable(f"The ladder down to the noise floor of {newtons(climbed.noise_floor)}", head, rows, (2, 3, 4, 5))


def cells(found: Sequence[Cell]) -> PageTable:
    """The numbers of a failure map, a row a cell."""
    rows = tuple(
        (
            number(cell.pressure_MPa, 3),
            " to ".join(f"{round(end, 4) + 0.0:.4f}".replace("-", "−") for end in cell.contraction),
            "–" if cell.branch == "static" else cell.branch,
            str(cell.n),
            known_to(cell.mean, cell.rms / math.sqrt(cell.n)),
            number(cell.rms, 3),
            percent(cell.share),
        )
        for cell in found
    )
    head = (
        "pressure (MPa)",
        "contraction ratio (1)",
        "branch",
        "samples",
        "mean error (N)",
        "rms error (N)",
        "share of the squared error",
    )
    return PageTable(f"The {len(rows)} cells of the map in numbers", head, rows, (3, 4, 5, 6), folded=True)


def fitted(fit: Fit, which: str) -> tuple[PageTable, ...]:
    """The parameters of a fit; no table where nothing was free."""
    return (parameters(fit, which),) if fit.estimates else ()


def parameters(fit: Fit, which: str) -> PageTable:
    """Every fitted parameter with unit, standard error and, in words, whether the record determines it."""
    rows = tuple((e.name, value_of(e), stderr(e), unit(e.unit), standing(e), e.doc) for e in in_order(fit.estimates))
    head = ("parameter", "value", "standard error", "unit", "standing", "meaning")
    return PageTable(f"Parameters of {which}: {fit.model.words}", head, rows, (1, 2))


def isobars(table: IsobarTable) -> list[PageTable]:
    """A table a branch of parameters over pressure, then correlation with pressure, then the two-stage law."""
    found = []
    for branch in dict.fromkeys(row.branch for row in table.rows):
        mine = [row for row in table.rows if row.branch == branch]
        heads = {e.name: f"{e.name} ({unit(e.unit)})" for row in mine for e in in_order(row.estimates)}
        rows = tuple(
            (
                f"{row.pressure_MPa:g}",
                *(_cell(next((e for e in row.estimates if e.name == name), None)) for name in heads),
                number(row.rmse, 3),
            )
            for row in sorted(mine, key=lambda row: -row.pressure_MPa)
        )
        head = ("pressure (MPa)", *heads.values(), "rms error (N)")
        word = "both branches together" if branch == "together" else branch
        found.append(
            PageTable(
                f"Each isobar fitted alone, {word}: value ± standard error", head, rows, tuple(range(1, len(head)))
            )
        )
    if table.correlation:
        found.append(_by_branch("Correlation of each coefficient with pressure", "coefficient", table.correlation, 5))
    if table.two_stage:
        title = "The law from straight lines through the isobars (two-stage method)"
        found.append(_by_branch(title, "parameter", table.two_stage, 5))
    return found


def _cell(estimate: Estimate | None) -> str:
    if estimate is None:
        return "–"
    if not estimate.identified:
        return "not determined"
    return f"{value_of(estimate)} ± {stderr(estimate)}" + (" (at its bound)" if estimate.at_bound else "")


def _by_branch(caption: str, what: str, values: Mapping[str, Mapping[str, float]], digits: int) -> PageTable:
    branches = tuple(values)
    names = dict.fromkeys(name for branch in branches for name in values[branch])
    rows = tuple((name, *(number(values[b].get(name), digits) for b in branches)) for name in names)
    return PageTable(caption, (what, *branches), rows, tuple(range(1, len(branches) + 1)))


def loops(section: Section) -> PageTable:
    """Energy of each isobar's loop, measured and modelled, and whether the model could be a passive muscle."""
    pressures = sorted(set(section.loop_measured) | set(section.loop_model))
    rows = tuple(
        (
            f"{p:g}",
            number(section.loop_measured.get(p), 3),
            number(section.loop_model.get(p), 3),
            _passive(section.loop_model.get(p)),
        )
        for p in pressures
    )
    head = ("pressure (MPa)", "measured (J)", "model (J)", "the model's loop")
    return PageTable("Energy taken up in one loop; positive dissipates", head, rows, (1, 2))


def _passive(energy: float | None) -> str:
    if energy is None:
        return "–"
    if abs(energy) < 1e-4:
        return "has no area"
    return "dissipates" if energy > 0 else "gives energy back: no passive muscle can"


def provenance(items: Mapping[str, object]) -> PageTable:
    """Where the report came from; mappings inside are written out, the command is left to its own place."""
    rows: list[tuple[str, ...]] = []
    for key, value in items.items():
        if key == "command":
            continue
        text = ", ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, Mapping) else str(value)
        rows.append((str(key), text))
    return PageTable("Where this report came from", ("what", "value"), tuple(rows))


def source(record: Record) -> PageTable:
    """What was read of one record."""
    rows = [
        ("record", record.name),
        ("file", record.source or "not from a file"),
        ("SHA-256", record.sha256 or "–"),
        ("samples", f"{len(record)}" + (f", {record.masked} more left out as unusable" if record.masked else "")),
        ("isobars (MPa)", ", ".join(f"{p:g}" for p in record.levels)),
        ("specimen", record.specimen.name),
        *told(record.metadata),
        *((f"column for {key}", str(value)) for key, value in record.columns.items()),
    ]
    return PageTable(f"What was read: {record.name}", ("what", "value"), tuple(rows))
