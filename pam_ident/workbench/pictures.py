"""The bench in pictures: the figures of the report, as SVG for the page."""

import threading
from collections.abc import Callable, Mapping
from itertools import count

from markupsafe import Markup
from matplotlib.figure import Figure

from .. import plot
from ..report.svg import embed
from .bench import Bench

POINTS = 1500
_numbers = count()
_drawing = threading.Lock()
"""Figures share matplotlib's settings, so that two sessions must not draw at once."""


def pictures(bench: Bench) -> dict[str, Markup]:
    """Figures by name: `follows`, `measured`, `where`, `along`, after a diagnosis `falling`, with an effect `trace`."""
    ladder = bench.ladder
    before, after = bench.law_alone, bench.fit if bench.fit.model.terms else None
    found: dict[str, Markup] = {}

    def hang(name: str, label: str, draw: Callable[[], Figure], tips: Mapping[str, str] | None = None) -> None:
        found[name] = embed(draw(), f"w{next(_numbers)}", label, tips=tips)

    with _drawing:
        hang("follows", "What the error of the present model follows, as one bar",
             lambda: plot.follows.draw(bench.comparison.follows))  # fmt: skip
        if ladder is not None and len(ladder.rungs) > 1:
            hang("falling", "Rms error as effects are added", lambda: plot.ladder.draw(ladder))
        hang("measured", "Measured and modelled force over contraction, and the error below",
             lambda: plot.measured_against_model.draw(before, after, POINTS))  # fmt: skip
        hang("where", "Mean error over pressure and contraction, by branch",
             lambda: plot.failure_map.draw(bench.comparison), plot.failure_map.tips(bench.comparison))  # fmt: skip
        if plot.profiles.data(bench.comparison):
            hang("along", "Error along each coordinate of the test", lambda: plot.profiles.draw(bench.comparison))
        if after is not None:
            hang("trace", "Error over the record before and after the effects were added",
                 lambda: plot.signature.draw(before, after, POINTS))  # fmt: skip
    return found
