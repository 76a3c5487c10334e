"""The column at the side of the page: what is asked, the model, and what can be kept."""

from collections.abc import Callable

import panel as pn

from ..core import PamError
from ..core.prose import capital
from ..effects import Effect, catalogue
from ..laws import listed as listed_laws
from ..records.datasets import dataset_names, dataset_record
from ..tasks.setup import Setup
from . import words
from .bench import Bench
from .cards import Cards, Sliders
from .parts import LOOK, SpecimenForm, html

WIDE = {"sizing_mode": "stretch_width"} | LOOK


class Side:
    """The widgets, and `column` that holds them; what they do is the page's. `removed` is told an effect's name, `held`
    all parameters that are held, with their values."""

    def __init__(self, setup: Setup, removed: Callable[[str], None], held: Callable[[dict[str, float]], None]) -> None:
        self.drop = pn.widgets.FileInput(multiple=True, label="Record: choose or drop its files", **WIDE)
        self.example = pn.widgets.Select(label="or an example", options={"choose …": "", **_examples()}, **WIDE)
        self.columns = pn.widgets.Button(label="Columns and units …", visible=False, **WIDE)
        self.law = pn.widgets.Select(
            label="Force law", options={capital(law.title): law.name for law in listed_laws()}, **WIDE
        )
        self.law.value = setup.law
        known = {"as the specimen says": False, "radius and braid angle fitted": True}
        self.geometry = pn.widgets.Select(label="Geometry", options=known, value=setup.free_geometry, **WIDE)
        self.form = SpecimenForm()
        self.use_specimen = pn.widgets.Button(label="Use this specimen", **WIDE)
        self.specimen = pn.Card(
            self.form.row,
            self.use_specimen,
            header=html("<h3>Specimen</h3>"),
            collapsed=True,
            margin=(8, 10),
            styles={"box-shadow": "none"},
            **WIDE,
        )
        self.model, self.terms = html(), Cards("Effects in the model", removed)
        self.effect = pn.widgets.Select(label="Another effect", options=[], **WIDE)
        self.form_of = pn.widgets.Select(label="in the form", options=[], **WIDE)
        self.effect.param.watch(lambda _: self._show_forms(), "value")
        self.add_other = pn.widgets.Button(label="Add this effect", **WIDE)
        self._held, self._bench, self._effects = held, None, {}
        self.hold = pn.widgets.Select(label="Hold a parameter", options=[""], **WIDE)
        self.hold.param.watch(lambda _: self._on_hold(), "value")
        self.sliders = Sliders(self._hold)
        self.save = pn.widgets.FileDownload(filename="report.html", label="Save the report", color="primary", **WIDE)
        self.save_specimen = pn.widgets.FileDownload(filename="specimen.toml", label="Save specimen.toml", **WIDE)
        self.save_columns = pn.widgets.FileDownload(filename="columns.toml", label="Save columns.toml", **WIDE)
        self.command = html()
        self.column = pn.Column(
            html("<h2>Record</h2>"), self.drop, self.example, self.columns, self.specimen,
            html("<h2>Model</h2>"), self.law, self.geometry, self.terms, self.effect, self.form_of, self.add_other,
            html("<h2>By hand</h2>"), self.hold, self.sliders,
            html("<h2>Keep it</h2>"), self.save, self.save_specimen, self.save_columns, self.command,
            styles={"flex": "1 1 17rem", "min-width": "0"}, css_classes=["side"], **LOOK,
        )  # fmt: skip

    def show(self, bench: Bench | None, setup: Setup) -> None:
        """What is asked for now."""
        self._bench = bench
        self.command.object = str(words.command(bench))
        self.law.value, self.geometry.value = setup.law, setup.free_geometry
        self._effects = _to_add(bench) if bench else {}
        titles = {capital(effect.title): name for name, effect in self._effects.items()}
        self.effect.param.update(options=titles or [""], value=next(iter(titles.values()), ""))
        self._show_forms()
        self.add_other.disabled = bench is None
        self.save_specimen.disabled = bench is None
        self.terms.items = [
            {"key": term.effect.name, "title": f"Remove {term.effect.title}", "text": term.form.formula}
            for term in (bench.fit.model.terms if bench else ())
        ]
        self._show_held(bench)
        if bench is not None:
            self.form.show(bench.record.specimen)
            self.save.filename = f"{bench.record.name}.html"

    @property
    def other(self) -> str:
        """The label of the effect and the form that are chosen."""
        return self.form_of.value or self.effect.value

    def _show_forms(self) -> None:
        effect = self._effects.get(self.effect.value)
        forms = (
            {f"{form.name.replace('_', ' ')}: {form.formula}": f"{effect.name}:{form.name}" for form in effect.forms}
            if effect
            else {}
        )
        self.form_of.param.update(options=forms or [""], value=next(iter(forms.values()), ""))

    def _show_held(self, bench: Bench | None) -> None:
        held = bench.held if bench else {}
        free = [e.name for e in bench.fit.estimates if e.name not in held] if bench else []
        self.hold.param.update(options=["", *free], value="")
        self.sliders.lay(bench.fit if bench else None, held)

    def _on_hold(self) -> None:
        if self.hold.value and self._bench is not None:
            self._hold(self.hold.value, self._bench.fit.values[self.hold.value])

    def _hold(self, name: str, value: float | None) -> None:
        held = dict(self._bench.held) if self._bench else {}
        held.pop(name, None) if value is None else held.update({name: value})
        self._held(held)


def _to_add(bench: Bench) -> dict[str, Effect]:
    """Effects that the model does not hold, by name."""
    held = set(bench.fit.model.effect_names)
    return {name: effect for name, effect in catalogue(bench.setup.extra).items() if name not in held}


def _examples() -> dict[str, str]:
    """Data sets that hold a force record."""
    found = {}
    for name in dataset_names():
        try:
            dataset_record(name)
        except PamError:
            continue
        found[name.replace("_", " ")] = name
    return found
