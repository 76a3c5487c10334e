"""The page: what lies on the bench, and the buttons that change it."""

import asyncio
import io
import threading
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import panel as pn
from markupsafe import Markup
from panel.viewable import Viewer

from ..core import PamError, Specimen
from ..records import Record
from ..records.datasets import dataset_names, dataset_record
from ..report.words import titles
from ..workflow.list_laws import list_laws
from ..workflow.setup import Setup
from . import words
from .bench import Bench, specimen_toml
from .dropped import read_dropped
from .pictures import pictures
from .work import Work

STYLE = (files("pam_ident.workbench") / "style.css").read_text(encoding="utf-8")
TICK_MS = 150
"""How often the page looks for what the work has found."""
MOST_SUSPECTS = 7
"""Suspects that get a line; the others can be added by name."""
SIDE = 340
"""Width of the column with what is asked, in pixels."""
Found = tuple[Bench, Mapping[str, Markup]]


class Workbench(Viewer):
    """The workbench on one record, for the browser and for a notebook.

    `record` is a path, `law` a force law by name; `effects` (`name` or `name:form`) are in the model from the start,
    `effect_files` hold the user's own. `specimen` is the path of a specimen file; without it the one beside the record
    is taken.
    """

    def __init__(
        self,
        record: str | Path | None = None,
        law: str = "exponential_law",
        effects: tuple[str, ...] = (),
        effect_files: tuple[str, ...] = (),
        specimen: str | None = None,
        free_geometry: bool = False,
    ) -> None:
        super().__init__()
        self.setup = Setup(law, effects, effect_files, free_geometry, specimen)
        _ = self.setup.model
        self.record: tuple[Record, str] | None = None
        self.bench: Bench | None = None
        self.work: Work[Found] | None = None
        self._make_side()
        self._make_main()
        self._clock = None
        if pn.state.curdoc is not None:
            pn.state.on_session_destroyed(lambda _: self.work and self.work.stop())
        if record is not None:
            self._begin(lambda: self._opened(self.setup.read(record), str(record)))
        self._show()

    def __panel__(self) -> pn.viewable.Viewable:
        """The whole page."""
        return self.page

    # What is asked

    def _make_side(self) -> None:
        wide = {"sizing_mode": "stretch_width"}
        self.drop = pn.widgets.FileInput(multiple=True, label="Record (and its specimen.toml)", **wide)
        self.drop.param.watch(self._on_drop, "value")
        self.example = pn.widgets.Select(label="or an example", options={"choose …": "", **_examples()}, **wide)
        self.example.param.watch(self._on_example, "value")
        self.law = pn.widgets.Select(label="Force law", options={law.title: law.name for law in list_laws()}, **wide)
        self.law.value = self.setup.law
        self.law.param.watch(self._on_law, "value")
        known = {"as the specimen says": False, "radius and braid angle fitted": True}
        self.geometry = pn.widgets.Select(label="Geometry", options=known, value=self.setup.free_geometry, **wide)
        self.geometry.param.watch(self._on_law, "value")
        self.fields = {
            key: pn.widgets.TextInput(label=name, **wide)
            for key, name in (
                ("initial_length_mm", "Initial length (mm)"),
                ("initial_radius_mm", "Initial radius (mm)"),
                ("braid_angle_deg", "Braid angle (°)"),
                ("wall_thickness_mm", "Wall thickness (mm), if known"),
            )
        }
        self.use_specimen = pn.widgets.Button(label="Use this specimen", **wide)
        self.use_specimen.on_click(lambda _: self._on_specimen())
        self.save_specimen = pn.widgets.FileDownload(
            callback=self._specimen_file, filename="specimen.toml", label="Save specimen.toml", **wide
        )
        self.specimen = pn.Card(
            *self.fields.values(),
            self.use_specimen,
            self.save_specimen,
            title="Specimen",
            collapsed=True,
            margin=(8, 10),
            **wide,
        )
        self.model = pn.Column(**wide)
        self.other = pn.widgets.Select(label="Another effect", options=[], **wide)
        self.add_other = pn.widgets.Button(label="Add this effect", **wide)
        self.add_other.on_click(lambda _: self._change(lambda bench: bench.adding(self.other.value)))
        self.save = pn.widgets.FileDownload(
            callback=self._report_file, filename="report.html", label="Save the report", color="primary", **wide
        )
        self.command = _html()
        self.side = pn.Column(
            _html("<h2>Record</h2>"), self.drop, self.example, self.specimen,
            _html("<h2>Law</h2>"), self.law, self.geometry,
            _html("<h2>Model</h2>"), self.model, self.other, self.add_other,
            _html("<h2>Keep it</h2>"), self.save, self.command,
            width=SIDE,
        )  # fmt: skip

    def _make_main(self) -> None:
        wide = {"sizing_mode": "stretch_width"}
        self.head = _html()
        self.error = _html(visible=False)
        self.status = _html(words.status("", ""), **wide)
        self.bar = pn.indicators.Progress(active=True, width=240, visible=False)
        self.stop = pn.widgets.Button(label="Stop", visible=False)
        self.stop.on_click(lambda _: self.work and self.work.stop())
        self.find = pn.widgets.Button(label="Find what is missing", color="primary", visible=False)
        self.find.on_click(lambda _: self._change(lambda bench: bench))
        self.verdict = _html()
        self.suspects = pn.Column(**wide)
        self.views = {name: _html() for name in ("falling", "measured", "where", "trace", "parameters")}
        self.tabs = pn.Tabs(
            ("Measured against model", self.views["measured"]),
            ("Where it fails", self.views["where"]),
            ("Trace of the effects", self.views["trace"]),
            ("Parameters", self.views["parameters"]),
            **wide,
        )
        self.main = pn.Column(
            self.head, self.error, pn.Row(self.find, self.bar, self.stop, self.status), self.verdict,
            self.views["falling"], self.suspects, self.tabs,
            styles={"flex": "1 1 30rem", "min-width": "0"},
        )  # fmt: skip
        self.page = _Page(
            _html("<h1>pam-ident workbench</h1>"), pn.FlexBox(self.side, self.main, flex_wrap="wrap"), **wide
        )

    # What is done

    def _begin(self, begin: Callable[[], Iterator[Found]]) -> None:
        """Start work; what was under way is told to stop, and what it finds is not looked at."""
        if self.work is not None:
            self.work.stop()
        self.error.visible = False
        self.work = Work(begin)
        if self._clock is None and _loop_runs():
            self._clock = pn.state.add_periodic_callback(self.look, TICK_MS)
        self._busy()

    def look(self) -> None:
        """Show what the work has found since the last look, and how far it is."""
        with self.page.turn:
            self._look()

    def _look(self) -> None:
        work = self.work
        if work is None:
            return
        busy = work.busy
        for bench, drawn in work.take():
            self.bench, self.record = bench, (bench.record, bench.path)
            self.setup = bench.setup
            self._show(drawn)
        if not busy:
            self.work = None
            if work.error:
                self._complain(work.error)
            if self._clock is not None:
                self._clock.stop()
                self._clock = None
        self._busy(work.stopped)

    def wait(self) -> None:
        """Until the work is done, everything shown. For notebooks and tests, where nobody looks in between."""
        while self.work is not None:
            self.work.wait()
            self.look()

    def _opened(self, record: Record, path: str) -> Iterator[Found]:
        return _told(Bench.begin(record, path, self.setup))

    def _change(self, change: Callable[[Bench], Bench]) -> None:
        bench = self.bench
        if bench is not None:
            self._begin(lambda: _told(change(bench)))

    def _on_drop(self, _: Any) -> None:
        if not self.drop.value:
            return
        named = dict(zip(self.drop.filename, self.drop.value, strict=True))
        try:
            given = self._given_specimen()
        except PamError as error:
            self._complain(str(error))
            return
        self.setup = Setup(self.law.value, (), self.setup.effect_files, self.geometry.value)
        self._begin(lambda: self._opened(*read_dropped(named, given)))

    def _on_example(self, _: Any) -> None:
        if self.example.value:
            path = dataset_record(self.example.value)
            self.setup = Setup(self.law.value, (), self.setup.effect_files, self.geometry.value)
            self._begin(lambda: self._opened(self.setup.read(path), str(path)))

    def _on_law(self, _: Any) -> None:
        setup = self.setup
        if (self.law.value, self.geometry.value) == (setup.law, setup.free_geometry):
            return
        self.setup = Setup(self.law.value, (), setup.effect_files, self.geometry.value, setup.specimen)
        if self.record is not None:
            self._begin(partial(self._opened, *self.record))

    def _on_specimen(self) -> None:
        try:
            given = self._given_specimen()
        except PamError as error:
            self._complain(str(error))
            return
        if given is None or self.record is None:
            self._complain("a specimen needs at least its length, radius and braid angle, and a record to belong to")
            return
        record, path = self.record
        self._begin(lambda: self._opened(words.with_specimen(record, given), path))

    def _given_specimen(self) -> Specimen | None:
        values = {key: words.length(field.label, field.value) for key, field in self.fields.items() if field.value}
        if len(values.keys() - {"wall_thickness_mm"}) < 3:
            return None
        name = self.record[0].specimen.name if self.record else "specimen"
        return Specimen(name, **values)  # pyright: ignore[reportArgumentType] - lengths and an angle

    def _report_file(self) -> io.BytesIO | None:
        return self._kept(lambda bench: bench.report())

    def _specimen_file(self) -> io.BytesIO | None:
        return self._kept(lambda bench: specimen_toml(bench.record.specimen))

    def _kept(self, make: Callable[[Bench], str]) -> io.BytesIO | None:
        try:
            return io.BytesIO(make(self.bench).encode()) if self.bench else None
        except PamError as error:
            self._complain(str(error))
            return None

    # What is shown

    def _busy(self, stopped: bool = False) -> None:
        work, bench = self.work, self.bench
        self.bar.visible = self.stop.visible = work is not None
        self.find.visible = work is None and bench is not None and bench.diagnosis is None
        said = words.stage(work.stage) if work is not None else "stopped" if stopped else ""
        self.status.object = str(words.status(said, "busy" if work is not None else ""))
        self.save.disabled = bench is None or bench.ladder is None
        self.save_specimen.disabled = bench is None

    def _complain(self, text: str) -> None:
        self.error.object, self.error.visible = str(words.error(text)), True

    def _show(self, drawn: Mapping[str, Markup] | None = None) -> None:
        """The bench as it is, with its pictures."""
        bench, drawn = self.bench, drawn or {}
        self.head.object = str(words.head(bench))
        self.verdict.object = str(words.verdict(bench))
        for name in ("falling", "measured", "trace"):
            self.views[name].object = str(drawn.get(name, ""))
        self.views["where"].object = str(words.where(bench, drawn))
        self.views["parameters"].object = str(words.parameters(bench))
        self.command.object = str(words.command(bench))
        self.law.value, self.geometry.value = self.setup.law, self.setup.free_geometry
        self.other.options = list(bench.to_add) if bench else []
        self.add_other.disabled = bench is None
        if bench is not None:
            for key, field in self.fields.items():
                value = getattr(bench.record.specimen, key)
                field.value = "" if value is None else f"{value:.10g}"
            self.save.filename = f"{bench.record.name}.html"
        self.model.objects = self._terms()
        self.suspects.objects = self._suspects()
        self._busy()

    def _terms(self) -> list[Any]:
        """The model's equation, and a button for each effect that takes it out."""
        shown: list[Any] = [_html(words.model(self.bench))]
        for term in self.bench.fit.model.terms if self.bench else ():
            button = pn.widgets.Button(label=f"Remove {term.label}", sizing_mode="stretch_width")
            button.on_click(lambda _, name=term.effect.name: self._change(lambda bench: bench.removing(name)))
            shown.append(button)
        return shown

    def _suspects(self) -> list[Any]:
        """A line a suspect, with a button that adds it; what cannot be judged from this record at the end."""
        found = self.bench.diagnosis if self.bench else None
        if found is None:
            return []
        shown: list[Any] = [_html("<h2>Suspects</h2>")]
        known = titles(found.best.model)
        candidates = [one for one in found.ranking if one.status == "candidate"]
        for suspect in candidates[:MOST_SUSPECTS]:
            label = next((x for x in found.labels if x.partition(":")[0] == suspect.effect), suspect.label)
            color = "primary" if suspect.effect in found.selected else "default"
            button = pn.widgets.Button(label=f"Add {label}", color=color, width=280)
            button.on_click(lambda _, label=label: self._change(lambda bench: bench.adding(label)))
            shown.append(pn.Row(button, _html(words.suspect(suspect, known))))
        shown.append(_html(words.not_judged(found)))
        return shown


class _Page(pn.Column):
    """A column that hears the browser only while nobody else changes it.

    A kernel of JupyterLab hears it in another thread than the one that looks for what the work has found, and what is
    changed while Panel takes in a message never reaches the browser.
    """

    def __init__(self, *objects: Any, **options: Any) -> None:
        self.turn = threading.RLock()
        super().__init__(*objects, **options)

    def _on_msg(self, ref: str, manager: Any, msg: Any) -> None:
        with self.turn:
            super()._on_msg(ref, manager, msg)


def _told(bench: Bench) -> Iterator[Found]:
    """The bench as fitted, and then diagnosed; each with its pictures."""
    yield bench, pictures(bench)
    bench = bench.diagnosed()
    yield bench, pictures(bench)


def _loop_runs() -> bool:
    """Whether somebody looks in between: a server or a notebook."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True


def _html(text: str = "", **options: Any) -> pn.pane.HTML:
    return pn.pane.HTML(str(text), stylesheets=[STYLE], **({"sizing_mode": "stretch_width"} | options))


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
