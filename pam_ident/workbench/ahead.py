"""The step that a person will likely take, diagnosed while they look at the page."""

from collections.abc import Iterator
from dataclasses import replace

from ..core.progress import tell
from ..records import Record
from ..tasks.setup import Setup
from .bench import Bench
from .history import History
from .work import Work

LOOK_S = 0.05
"""Seconds between two looks at work that is waited for."""


class Ahead:
    """Adds the likeliest candidate of a bench in a thread; what comes of it is the history's `ahead`."""

    def __init__(self) -> None:
        self.work: Work[Bench] | None = None
        self._of: tuple[Record, Setup] | None = None

    def begin(self, bench: Bench | None, history: History) -> None:
        """Find it, if the bench has candidates."""
        self.stop()
        if bench is None or not bench.previews:
            return
        label = bench.previews[0].label
        self._of = bench.record, replace(bench.setup, effects=(*bench.setup.effects, label))

        def found() -> Iterator[Bench]:
            step = bench.adding(label)
            if history.known(step) is None:
                history.ahead = step.diagnosed()
            yield step

        self.work = Work(found)

    def stop(self) -> None:
        """Let it be."""
        if self.work is not None:
            self.work.stop()

    def awaited(self, bench: Bench, history: History) -> Bench | None:
        """A bench as it was found ahead, once that is done; of any other step nothing, and no more is done ahead."""
        record, setup = self._of or (None, None)
        if self.work is None or bench.record is not record or bench.setup != setup or bench.held:
            self.stop()
            return None
        while self.work.busy:
            self.work.wait(LOOK_S)
            if self.work.stage is not None:
                tell(self.work.stage.what, self.work.stage.done, self.work.stage.of)
        return history.known(bench)
