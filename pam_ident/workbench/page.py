"""The page: what lies on the bench, and what changes it."""

import asyncio
import io
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import panel as pn
from panel.viewable import Viewer

from ..core import DataError, PamError
from ..records import Record
from ..records.datasets import dataset_record
from ..records.record import rebuilt
from ..records.specimen_file import specimen_toml
from ..tasks.setup import Setup
from . import words
from .ahead import Ahead
from .bench import Bench
from .cards import Cards, Tabs
from .draft import Draft
from .drafting import Drafting
from .history import History
from .parts import LOOK, Page, html, on_press
from .side import Side
from .view import Views
from .work import Work

TICK_MS = 100
"""How often the page looks for what the work has found."""
Found = tuple[bool, Bench] | Draft
"""A bench, and whether it is a new step; or what was dropped."""
WIDE: dict[str, Any] = {"sizing_mode": "stretch_width"}


class Workbench(Viewer):
    """The workbench on one record, for the browser and for a notebook.

    `record` is a path, `law` a force law by name; `effects` (`name` or `name:form`) are in the model from the start,
    `effect_files` hold the user's own. `specimen` is the path of a specimen file; without it the one beside the record
    is taken; `where` is a condition on its rows. `history` is what was done on this page before it was loaded anew.
    """

    def __init__(
        self,
        record: str | Path | None = None,
        law: str = "exponential_law",
        effects: tuple[str, ...] = (),
        effect_files: tuple[str, ...] = (),
        specimen: str | None = None,
        free_geometry: bool = False,
        history: History | None = None,
        where: str | None = None,
    ) -> None:
        super().__init__()
        self.history = history or History()
        self.setup = Setup(law, effects, effect_files, free_geometry, specimen, where=where)
        _ = self.setup.model
        self.work: Work[Found] | None = None
        self.ahead = Ahead()
        self.asking = self.history.draft is not None and bool(self.history.draft.problem)
        self._make_side()
        self._make_main()
        self._clock = None
        if pn.state.curdoc is not None:
            pn.state.on_session_destroyed(lambda _: self._halt())
        if self.bench is not None:
            self.setup = self.bench.setup
        elif record is not None:
            self._begin(lambda: self._opened(self.setup.read(record), str(record)))
        self._show()

    def __panel__(self) -> pn.viewable.Viewable:
        """The whole page."""
        return self.page

    @property
    def bench(self) -> Bench | None:
        """The step that is shown."""
        return self.history.bench

    # What is asked

    def _make_side(self) -> None:
        side = self.side = Side(
            self.setup, lambda name: self._change(lambda bench: bench.removing(name)), self._on_hold
        )
        side.drop.param.watch(self._on_drop, "value")
        side.example.param.watch(self._on_example, "value")
        for choice in (side.law, side.geometry):
            choice.param.watch(self._on_law, "value")
        on_press(side.columns, lambda: self._ask(True))
        on_press(side.use_specimen, self._on_specimen)
        on_press(side.add_other, lambda: self._change(lambda bench: bench.adding(side.other)))
        side.save.callback = partial(self._kept, lambda bench: bench.report())
        side.save_specimen.callback = partial(self._kept, lambda bench: specimen_toml(bench.record.specimen))
        side.save_columns.callback = partial(
            self._kept, lambda _: self.history.draft.toml if self.history.draft else ""
        )

    def _make_main(self) -> None:
        self.head, self.verdict, self.follows = html(), html(), html()
        self.error = html(visible=False)
        self.status = html(words.status("", ""), **WIDE)
        self.bar = pn.indicators.Progress(active=True, width=160, visible=False)
        self.stop, self.find, self.anyway = (
            pn.widgets.Button(label=label, visible=False, color=color, **LOOK)
            for label, color in (
                ("Stop", "default"),
                ("Find what is missing", "primary"),
                ("Answer all the same", "default"),
            )
        )
        on_press(self.stop, self._halt)
        on_press(self.find, lambda: self._begin(lambda: _found(self.bench)))
        on_press(self.anyway, lambda: self._change(lambda bench: bench.all_the_same()))
        self.draft = Drafting(self._on_open, lambda: self._ask(False))
        self.steps = Cards("Steps taken", self._on_step, css_classes=["strip"])
        self.pin = pn.widgets.Button(label="Pin this model as A", **LOOK)
        on_press(self.pin, self._on_pin)
        self.view = Views()
        self.texts = {name: html() for name in ("where", "parameters", "against", "model")}
        self.tabs = Tabs(
            {
                "Where it fails": pn.Column(self.texts["where"], self.view.map, **WIDE),
                "Parameters": pn.Column(self.texts["model"], self.texts["parameters"], **WIDE),
                "A against B": pn.Column(self.pin, self.texts["against"], **WIDE),
            },
            **WIDE,
        )
        self.candidates = Cards("Candidates", lambda label: self._change(lambda bench: bench.adding(label)))
        self.no_candidates, self.not_judged = html(), html()
        self.main = pn.Column(
            self.head, self.error, pn.FlexBox(self.find, self.anyway, self.bar, self.stop, self.status, **WIDE),
            self.draft.panel, self.verdict, self.steps, self.view.zoom, self.view.figures, self.tabs,
            styles={"flex": "40 1 36rem", "min-width": "0"},
        )  # fmt: skip
        self.right = pn.Column(
            html("<h2>What may be missing</h2>"), self.no_candidates, self.candidates, self.not_judged,
            self.follows,
            styles={"flex": "1 1 17rem", "min-width": "0"},
        )  # fmt: skip
        self.page = Page(
            html("<h1>pam-ident workbench</h1>"),
            pn.FlexBox(self.side.column, self.main, self.right, flex_wrap="wrap", gap="0 1.2rem", **WIDE), **WIDE,
        )  # fmt: skip

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

    def _halt(self) -> None:
        self.ahead.stop()
        if self.work is not None:
            self.work.stop()

    def look(self) -> None:
        """Show what the work has found since the last look, and how far it is."""
        with self.page.turn:
            self._look()

    def _look(self) -> None:
        work = self.work
        if work is None:
            return
        busy = work.busy
        found = work.take()
        for one in found:
            if isinstance(one, Draft):
                self.history.draft, self.asking = one, bool(one.problem)
                if one.problem and (one.has_specimen or not one.ours):
                    self._complain(one.problem)
            elif one[0]:
                self.history.push(one[1])
            else:
                self.history.renew(one[1])
        if found:
            self.setup = self.bench.setup if self.bench else self.setup
            self._show()
        if not busy:
            self.work = None
            if work.error:
                self._complain(work.error)
            if self._clock is not None:
                self._clock.stop()
                self._clock = None
                if not work.stopped:
                    self.ahead.begin(self.bench, self.history)
        self._busy(work.stopped)

    def wait(self) -> None:
        """Until the work is done, everything shown. For notebooks and tests, where nobody looks in between."""
        while self.work is not None:
            self.work.wait()
            self.look()

    def _opened(self, record: Record, path: str) -> Iterator[Found]:
        return self._told(Bench.begin(record, path, self._asked()))

    def _asked(self) -> Setup:
        """The law alone, as the side says, with the effects that the page began with if it is still empty."""
        effects = () if self.history.steps else self.setup.effects
        return replace(
            self.setup, law=self.side.law.value, effects=effects, free_geometry=self.side.geometry.value, assume=()
        )

    def _told(self, bench: Bench) -> Iterator[Found]:
        """The bench as fitted, then diagnosed, then with its candidates tried; what is known is not asked again."""
        known = self.history.known(bench)
        yield True, known or bench
        if known is None:
            known = self.ahead.awaited(bench, self.history)
            if known is not None:
                yield False, known
        yield from _found(known or bench)

    def _change(self, change: Callable[[Bench], Bench]) -> None:
        bench = self.bench
        if bench is not None:
            self._begin(lambda: self._told(change(bench)))

    def _on_drop(self, _: Any) -> None:
        if not self.side.drop.value:
            return
        names, contents = self.side.drop.filename, self.side.drop.value
        if not isinstance(names, list) or not isinstance(contents, list) or len(names) != len(contents):
            self._complain("the files did not arrive whole; drop them again")
            return
        named = dict(zip(names, contents, strict=True))
        self.setup = replace(self.setup, where=None)
        self._begin(lambda: self._dropped(named))

    def _dropped(self, files: Mapping[str, bytes]) -> Iterator[Found]:
        """A record, if the files are one by themselves; else what they hold, for a person to say what it is."""
        draft = Draft.of(files)
        try:
            record, name = draft.read(None, by_hand=False)
        except DataError as error:
            yield replace(draft, problem=str(error))
            return
        yield draft
        yield from self._opened(record, name)

    def _on_open(self) -> None:
        draft = self.draft.draft
        if draft is None:
            return
        try:
            given = self.draft.form.given("muscle")
        except PamError as error:
            self._complain(str(error))
            return
        self.history.draft = draft

        def read() -> Iterator[Found]:
            record, name = draft.read(given)
            yield replace(draft, problem="")
            yield from self._opened(record, name)

        if given is None and not draft.has_specimen:
            self._complain("the specimen is missing: type in at least its length, radius and braid angle")
        else:
            self._begin(read)

    def _ask(self, ask: bool) -> None:
        self.asking = ask
        self.draft.show(self.history.draft, ask)

    def _on_example(self, _: Any) -> None:
        if self.side.example.value:
            path = dataset_record(self.side.example.value)
            self.history.draft = None
            self.setup = replace(self.setup, where=None)  # which is of the record that the page began with
            self._begin(lambda: self._opened(self.setup.read(path), self.side.example.value))

    def _on_law(self, _: Any) -> None:
        setup, bench = self.setup, self.bench
        if (self.side.law.value, self.side.geometry.value) == (setup.law, setup.free_geometry):
            return
        self.setup = self._asked()
        if bench is not None:
            self._begin(partial(self._opened, bench.record, bench.path))

    def _on_specimen(self) -> None:
        bench = self.bench
        try:
            given = self.side.form.given(bench.record.specimen.name if bench else "muscle")
        except PamError as error:
            self._complain(str(error))
            return
        if given is None or bench is None:
            self._complain("a specimen needs at least its length, radius and braid angle, and a record to belong to")
            return
        self._begin(lambda: self._opened(rebuilt(bench.record, given), bench.path))

    def _on_hold(self, held: dict[str, float]) -> None:
        self._change(lambda bench: bench.holding(held))

    def _on_step(self, key: str) -> None:
        """Go back or forth; nothing is worked out anew."""
        at = {"undo": self.history.at - 1, "redo": self.history.at + 1}.get(key)
        self._halt()
        self.work = None
        if self.history.go(int(key) if at is None else at) and self.bench is not None:
            self.setup = self.bench.setup
            self.error.visible = False
            self._show()

    def _on_pin(self) -> None:
        self.history.pinned = self.bench
        self._show()

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
        waiting = work is None and bench is not None and not bench.judged and not bench.held
        stopped_by_doubt = bench is not None and bench.stopped
        self.find.visible, self.anyway.visible = waiting and not stopped_by_doubt, waiting and stopped_by_doubt
        said = words.stage(work.stage) if work is not None else "stopped" if stopped else ""
        self.status.object = str(words.status(said, "busy" if work is not None else ""))
        self.side.save.disabled = bench is None or bench.ladder is None
        self.side.save_columns.disabled = self.history.draft is None

    def _complain(self, text: str) -> None:
        self.error.object, self.error.visible = str(words.error(text)), True

    def _show(self) -> None:
        """The bench as it is."""
        bench, pinned = self.bench, self.history.pinned
        self.head.object = str(words.head(bench))
        self.follows.object = str(words.follows(bench.diagnosis.follows if bench and bench.diagnosis else ()))
        for name in ("where", "parameters", "model"):
            self.texts[name].object = str(getattr(words, name)(bench))
        self.texts["against"].object = str(words.against(pinned, bench))
        self.steps.items = words.steps(self.history.steps, self.history.at)
        self.no_candidates.object = str(words.no_candidates(bench))
        self.not_judged.object = str(words.not_judged(bench))
        self.pin.disabled = bench is None
        for one in (self.view.zoom, self.view.figures, self.tabs, self.right):
            one.visible = bench is not None
        if bench is not None:
            self.view.show(bench, pinned.fit if pinned and pinned is not bench else None)
        # After the traces, or a card that is pointed at as soon as it is there has lost its preview.
        self.candidates.items = words.candidate_cards(bench)
        self.side.columns.visible = self.history.draft is not None and self.history.draft.ours
        self.side.show(bench, self.setup)
        self.draft.show(self.history.draft, self.asking)
        self.verdict.object = str(words.verdict(bench))  # once all that it tells of is there
        self._busy()


def _found(bench: Bench | None) -> Iterator[Found]:
    if bench is None or bench.held:
        return
    if not bench.judged:
        for found in bench.diagnosing():
            yield False, found
            bench = found
    if not bench.previews:
        yield False, bench.tried()


def _loop_runs() -> bool:
    """Whether somebody looks in between: a server or a notebook."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True
