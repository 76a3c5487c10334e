"""What was done on the bench, step by step, to go back to and forth; kept while the server runs."""

from collections import OrderedDict
from dataclasses import dataclass, field
from secrets import token_urlsafe

from .bench import Bench
from .draft import Draft

MOST_STEPS, LEAST_STEPS, MOST_PAGES = 40, 3, 8
MOST_ROWS = 1_000_000
"""Rows of all steps of a page together."""


@dataclass
class History:
    """The `steps` taken, the one that is shown (`at`), the one `pinned` as A, the `draft` of what was dropped, and
    what was found `ahead` of a step that is likely to be taken."""

    steps: list[Bench] = field(default_factory=list)
    at: int = -1
    pinned: Bench | None = None
    draft: Draft | None = None
    ahead: Bench | None = None

    @property
    def bench(self) -> Bench | None:
        """The step that is shown."""
        return self.steps[self.at] if self.steps else None

    def known(self, bench: Bench) -> Bench | None:
        """A step with the same model of the same record that was diagnosed already, or one that was found ahead."""
        steps = [*self.steps, *([self.ahead] if self.ahead else [])]
        alike = (one for one in steps if one.record is bench.record and one.setup == bench.setup and not one.held)
        return None if bench.held else next((one for one in alike if one.previews or one.diagnosis), None)

    def push(self, bench: Bench) -> None:
        """A new step; what had been undone is gone. A slider that is moved on is the same step."""
        if self.bench is not None and bench.held and bench.held.keys() == self.bench.held.keys():
            self.renew(bench)
            return
        most = min(max(MOST_ROWS // len(bench.record), LEAST_STEPS), MOST_STEPS)
        self.steps = [*self.steps[: self.at + 1], bench][-most:]
        self.at = len(self.steps) - 1

    def renew(self, bench: Bench) -> None:
        """More is known of the step that is shown."""
        self.steps[self.at] = bench

    def go(self, at: int) -> bool:
        """Show another step, if there is one."""
        there = 0 <= at < len(self.steps)
        self.at = at if there else self.at
        return there


class Kept:
    """Histories by the word that a page carries in its address, the latest few."""

    def __init__(self) -> None:
        self._found: OrderedDict[str, History] = OrderedDict()

    def of(self, word: str | None) -> tuple[str, History]:
        """The history that a word stands for, or a new one with a new word."""
        if word is None or word not in self._found:
            word = token_urlsafe(16)
            self._found[word] = History()
        self._found.move_to_end(word)
        while len(self._found) > MOST_PAGES:
            self._found.popitem(last=False)
        return word, self._found[word]
