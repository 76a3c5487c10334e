"""The page: what lies on the bench, and the buttons that change it."""

import asyncio
import io
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import panel as pn
from markupsafe import Markup
from panel.viewable import Viewer

from ..core import PamError
from ..records import Record
from ..records.datasets import dataset_record
from ..report.words import titles
from ..tasks.setup import Setup
from . import words
from .bench import Bench, specimen_toml
from .dropped import read_dropped
from .parts import Page, html
from .pictures import pictures
from .side import Side
from .work import Work

TICK_MS = 150
"""How often the page looks for what the work has found."""
MOST_SUSPECTS = 7
"""Suspects that get a line; the others can be added by name."""
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
        side = self.side = Side(self.setup)
        side.drop.param.watch(self._on_drop, "value")
        side.example.param.watch(self._on_example, "value")
        for choice in (side.law, side.geometry):
            choice.param.watch(self._on_law, "value")
        side.use_specimen.on_click(lambda _: self._on_specimen())
        side.add_other.on_click(lambda _: self._change(lambda bench: bench.adding(side.other.value)))
        side.save.callback, side.save_specimen.callback = self._report_file, self._specimen_file

    def _make_main(self) -> None:
        wide = {"sizing_mode": "stretch_width"}
        self.head = html()
        self.error = html(visible=False)
        self.status = html(words.status("", ""), **wide)
        self.bar = pn.indicators.Progress(active=True, width=240, visible=False)
        self.stop = pn.widgets.Button(label="Stop", visible=False)
        self.stop.on_click(lambda _: self.work and self.work.stop())
        self.find = pn.widgets.Button(label="Find what is missing", color="primary", visible=False)
        self.find.on_click(lambda _: self._change(lambda bench: bench))
        self.anyway = pn.widgets.Button(label="Answer all the same", visible=False)
        self.anyway.on_click(lambda _: self._change(lambda bench: bench.all_the_same()))
        self.verdict = html()
        self.suspects = pn.Column(**wide)
        self.views = {name: html() for name in ("follows", "falling", "measured", "where", "trace", "parameters")}
        self.tabs = pn.Tabs(
            ("Measured against model", self.views["measured"]),
            ("Where it fails", self.views["where"]),
            ("Trace of the effects", self.views["trace"]),
            ("Parameters", self.views["parameters"]),
            **wide,
        )
        self.main = pn.Column(
            self.head, self.error, pn.Row(self.find, self.anyway, self.bar, self.stop, self.status), self.verdict,
            self.views["follows"], self.views["falling"], self.suspects, self.tabs,
            styles={"flex": "1 1 30rem", "min-width": "0"},
        )  # fmt: skip
        self.page = Page(
            html("<h1>pam-ident workbench</h1>"), pn.FlexBox(self.side.column, self.main, flex_wrap="wrap"), **wide
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
        if not self.side.drop.value:
            return
        names, contents = self.side.drop.filename, self.side.drop.value
        if not isinstance(names, list) or not isinstance(contents, list) or len(names) != len(contents):
            self._complain("the files did not arrive whole; drop them again")
            return
        named = dict(zip(names, contents, strict=True))
        try:
            given = self.side.given_specimen(self.record[0].specimen.name if self.record else "specimen")
        except PamError as error:
            self._complain(str(error))
            return
        self.setup = Setup(self.side.law.value, (), self.setup.effect_files, self.side.geometry.value)
        self._begin(lambda: self._opened(*read_dropped(named, given)))

    def _on_example(self, _: Any) -> None:
        if self.side.example.value:
            path = dataset_record(self.side.example.value)
            self.setup = Setup(self.side.law.value, (), self.setup.effect_files, self.side.geometry.value)
            self._begin(lambda: self._opened(self.setup.read(path), str(path)))

    def _on_law(self, _: Any) -> None:
        setup = self.setup
        if (self.side.law.value, self.side.geometry.value) == (setup.law, setup.free_geometry):
            return
        self.setup = Setup(self.side.law.value, (), setup.effect_files, self.side.geometry.value, setup.specimen)
        if self.record is not None:
            self._begin(partial(self._opened, *self.record))

    def _on_specimen(self) -> None:
        try:
            given = self.side.given_specimen(self.record[0].specimen.name if self.record else "specimen")
        except PamError as error:
            self._complain(str(error))
            return
        if given is None or self.record is None:
            self._complain("a specimen needs at least its length, radius and braid angle, and a record to belong to")
            return
        record, path = self.record
        self._begin(lambda: self._opened(words.with_specimen(record, given), path))

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
        waiting = work is None and bench is not None and bench.diagnosis is None
        stopped_by_doubt = bench is not None and bench.stopped
        self.find.visible, self.anyway.visible = waiting and not stopped_by_doubt, waiting and stopped_by_doubt
        said = words.stage(work.stage) if work is not None else "stopped" if stopped else ""
        self.status.object = str(words.status(said, "busy" if work is not None else ""))
        self.side.save.disabled = bench is None or bench.ladder is None
        self.side.save_specimen.disabled = bench is None

    def _complain(self, text: str) -> None:
        self.error.object, self.error.visible = str(words.error(text)), True

    def _show(self, drawn: Mapping[str, Markup] | None = None) -> None:
        """The bench as it is, with its pictures."""
        bench, drawn = self.bench, drawn or {}
        self.head.object = str(words.head(bench))
        self.verdict.object = str(words.verdict(bench))
        for name in ("follows", "falling", "measured", "trace"):
            self.views[name].object = str(drawn.get(name, ""))
        self.views["follows"].object = str(words.follows(bench, drawn))
        self.views["where"].object = str(words.where(bench, drawn))
        self.views["parameters"].object = str(words.parameters(bench))
        self.side.show(bench, self.setup)
        self.side.model.objects = self._terms()
        self.suspects.objects = self._suspects()
        self._busy()

    def _terms(self) -> list[Any]:
        """The model's equation, and a button for each effect that takes it out."""
        shown: list[Any] = [html(words.model(self.bench))]
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
        shown: list[Any] = [html("<h2>Suspects</h2>")]
        known = titles(found.best.model)
        candidates = [one for one in found.ranking if one.status == "candidate"]
        for suspect in candidates[:MOST_SUSPECTS]:
            label = next((x for x in found.labels if x.partition(":")[0] == suspect.effect), suspect.label)
            color = "primary" if suspect.effect in found.selected else "default"
            button = pn.widgets.Button(label=f"Add {label}", color=color, width=280)
            button.on_click(lambda _, label=label: self._change(lambda bench: bench.adding(label)))
            shown.append(pn.Row(button, html(words.suspect(suspect, known))))
        shown.append(html(words.not_judged(found)))
        return shown


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
