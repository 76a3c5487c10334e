"""Results as HTML: a sentence, tables, figures. Every text is escaped; figures are inline and load nothing."""

import math
from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from markupsafe import Markup
from matplotlib.figure import Figure

from .. import plot
from ..core.digits import number
from ..report import tables
from ..report.easel import live
from ..report.render import environment
from ..report.svg import image
from ..report.tables import PageTable
from ..report.words import interval, stderr, unit, value_of
from . import lines
from .live import samples, standing

if TYPE_CHECKING:
    from bokeh.models import Column

    from ..core import Specimen
    from ..diagnosis.nouns import Comparison, Diagnosis, Ladder
    from ..fitting import Fit
    from ..leg.track import Track
    from ..records import Record
    from ..records.doubt import Doubt

POINTS = 400
"""Points of a cloud, so that a cell stays small."""
MOST_BYTES = 250_000
"""A figure that is longer as SVG is shown as PNG."""
TABLE = """<table><caption>{{ table.caption }}</caption>
<thead><tr>{% for cell in table.head %}<th>{{ cell }}</th>{% endfor %}</tr></thead>
<tbody>{% for row in table.rows %}<tr>{% for cell in row %}
<td style="text-align:{{ "right" if loop.index0 in table.numeric else "left" }}">{{ cell }}</td>
{% endfor %}</tr>{% endfor %}</tbody></table>"""


def page(result: Any) -> str:
    """HTML of a result."""
    return str(PAGES[lines.kind_of(result)](result))


def banner(doubts: "Iterable[Doubt]") -> str:
    """HTML of what looks wrong, a line each."""
    return str(Markup("").join(Markup('<p role="note">{}</p>').format(str(doubt)) for doubt in doubts))


def table(one: PageTable) -> Markup:
    """A table with its caption; numbers stand right."""
    return Markup(environment().from_string(TABLE).render(table=one))


def picture(figure: Figure, label: str, live: "Column | None" = None) -> Markup:
    """A figure; `live` is the same to zoom and to point at."""
    drawn = image(figure, label, MOST_BYTES)
    if live is not None:
        return standing(drawn, f"pam-{uuid4().hex[:10]}-live", live)
    return Markup('<div style="max-width:60em;background:white">{}</div>').format(drawn)


def _said(sentence: str) -> Markup:
    return Markup("<p>{}</p>").format(sentence)


def _specimen(one: "Specimen") -> Markup:
    known = ((f.name, getattr(one, f.name)) for f in fields(one) if f.name not in ("name", "sensors"))
    facts = [(name, "–" if value is None else f"{value:g}") for name, value in known]
    if one.sensors is not None:
        facts += [(f"sensors, {f.name}", f"{getattr(one.sensors, f.name):g}") for f in fields(one.sensors)]
    return table(PageTable(f"Specimen {one.name}", ("what", "value"), tuple(facts)))


def _record(one: "Record") -> Markup:
    figure = picture(plot.isobars.draw(one, POINTS), f"Force over contraction at each pressure of {one.name}")
    return table(tables.source(one)) + figure


def _fit(one: "Fit") -> Markup:
    equation = Markup("<pre>{}</pre>").format(str(one.model))
    rows = tuple((e.name, value_of(e), stderr(e), interval(e), unit(e.unit), e.doc) for e in one.estimates)
    head = ("parameter", "value", "standard error", "95 % interval", "unit", "meaning")
    drawn, shown = plot.measured_against_model.draw(one, limit=POINTS), live(one, None, samples())
    figure = picture(drawn, "Measured and modelled force, and the error", live=shown and shown.isobars)
    return _said(lines.fit(one)) + equation + table(PageTable("Parameters", head, rows, (1, 2, 3))) + figure


def _comparison(one: "Comparison") -> Markup:
    label = "Mean error over pressure and contraction, by branch"
    shown = live(one.fit, None, samples())
    drawn = plot.failure_map.draw(one)
    return _said(one.sentence) + picture(drawn, label, shown and shown.mapped(one))


def _diagnosis(one: "Diagnosis") -> Markup:
    following = Markup("") if one.next_experiment is None else _said(f"Next: {one.next_experiment.text}")
    after = one.best if one.selected else None
    drawn, shown = plot.signature.draw(one.base, after, POINTS), live(one.base, after, samples())
    trace = picture(drawn, "Error over the record, and what is added", live=shown and shown.trace)
    figure = picture(plot.candidates.draw(one), "Error that is left with each candidate")
    return _said(one.sentence) + following + trace + table(tables.candidates(one)) + figure


def _ladder(one: "Ladder") -> Markup:
    figure = picture(plot.ladder.draw(one), "Error as effects are added, down to the noise floor")
    return _said(lines.ladder(one)) + table(tables.ladder(one)) + figure


def _track(one: "Track") -> Markup:
    from ..export.frames import controllers
    from ..plot import tracking  # brings JAX, which no other result should wait for

    rows = tuple(
        (
            name,
            effects,
            "" if math.isnan(left) else number(left, 3),
            f"{rms:.3f}",
            f"{peak:.3f}",
            "" if math.isnan(low) else f"{low:.3f} to {high:.3f}",
        )
        for name, effects, left, rms, peak, low, high in controllers(one).itertuples(index=False)
    )
    head = ("controller", "effects", "fit leaves (N)", "rms (deg)", "peak (deg)", "95 % band of rms")
    figure = picture(tracking.draw(one), "Knee angle wanted and reached, and the error")
    said = Markup(banner(one.doubts)) + _said(lines.track(one))
    return said + table(PageTable("Knee tracking", head, rows, (2, 3, 4, 5))) + figure


PAGES: dict[str, Callable[[Any], Markup]] = {
    "Specimen": _specimen,
    "Record": _record,
    "Fit": _fit,
    "Comparison": _comparison,
    "Diagnosis": _diagnosis,
    "Ladder": _ladder,
    "Track": _track,
}
"""By the name of the result's type."""
