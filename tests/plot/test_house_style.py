"""What holds for every figure: units, one look, colours for the colour-blind, vectors, nothing cut off."""

import importlib
import pkgutil
import re
import xml.etree.ElementTree as ET
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.text import Text

from pam_ident import plot
from pam_ident.core import Specimen
from pam_ident.diagnosis.compare import compare
from pam_ident.diagnosis.nouns import Follows, Pattern
from pam_ident.fitting import fit, fit_isobars
from pam_ident.leg.anatomy import KNEE
from pam_ident.leg.muscle import Muscle
from pam_ident.leg.track import Tracking, TrackRung
from pam_ident.model import Model
from pam_ident.plot import batch_spread, batch_trend, failure_map, loop_diagram, over_pressure, style, tracking
from pam_ident.records import build_record
from pam_ident.records.datasets import dataset_path
from pam_ident.validation.calibration import reliability

MODULES = {
    name: module
    for _, name, _ in pkgutil.iter_modules(plot.__path__)
    if hasattr(module := importlib.import_module(f"pam_ident.plot.{name}"), "draw")
}
WITHOUT_DATA = {"loop_diagram"}
"""Boxes and arrows."""
CATEGORIES = {"confusion"}
"""Figures whose axes count names."""
PALETTE = {
    *(style.BLACK, style.ORANGE, style.SKY, style.GREEN, style.YELLOW, style.BLUE, style.VERMILION, style.PURPLE),
    *(style.INK, style.GREY, style.FAINT, style.BROWN, style.LILAC, "#ffffff", "#e5e8ec", "#f3f4f6"),
}

RUB = Pattern("local", "contraction", 12.0, "mm", 0.2, "")


def run(error):
    time = 0.005 * np.arange(200)
    target = 30.0 - 30.0 * np.cos(2.0 * np.pi * time)
    both = np.zeros((200, 2))
    return Tracking(time, target, target - error * np.sin(2.0 * np.pi * time), both, both)


def track():
    muscles = Muscle.read(dataset_path("leg_muscle") / "ladder.json")
    rungs = tuple(TrackRung(m, run(3.0 * 0.5**k), (2.0 * 0.5**k, 2.5 * 0.5**k)) for k, m in enumerate(muscles))
    return SimpleNamespace(pid_by_hand=run(4.0), pid=run(2.0), rungs=rungs)


def spread_panels():
    value = np.random.default_rng(1).normal(45.0, 3.0, 60)
    names = (("a0", "N"), ("a1", "N/MPa"), ("mu", "1"), ("rms error", "N"), ("E", "MPa"))
    return [batch_spread.data(name, unit, value, np.full(60, 0.5), np.arange(60) == 3) for name, unit in names]


def trend_panels():
    x = np.linspace(100.0, 300.0, 60)
    one = batch_trend.data("a1 (N/MPa)", "initial length (mm)", "ρ 0.9", x, 2.0 * x, np.arange(60) == 3, (2.0, 0.0))
    return [one] * 3


def stated_and_true():
    return [0.01, 0.2, 0.5, 0.9, 0.99] * 20, [False, False, True, True, True] * 20


def hidden_and_named():
    names = ("bladder_elasticity", "creep", "presliding_hysteresis", "unknown", "nothing")
    return {(a, b): 3 if a == b else 1 for a in names for b in names}


def locked():
    """A muscle locked at some lengths, its pressure driven up and down."""
    p, e = (
        np.tile(np.r_[np.linspace(0.05, 0.5, 100), np.linspace(0.5, 0.05, 100)], 4),
        np.repeat([0, 0.05, 0.1, 0.15], 200),
    )
    muscle = Specimen("locked", 200.0, 10.0, 25.4)
    force = 0.9 * muscle.ideal_force(p, e) + np.random.default_rng(1).normal(0.0, 2.0, 800)
    record = build_record("locked", muscle, p, e, force, time=0.05 * np.arange(800))
    return [fit(Model.build("chou_hannaford", effects), record) for effects in ((), ("threshold_pressure",))]


DRAW = {
    "batch_spread": lambda d, _: batch_spread.draw(spread_panels()),
    "batch_trend": lambda d, _: batch_trend.draw(trend_panels()),
    "calibration": lambda d, _: plot.calibration.draw(
        reliability([0.01, 0.2, 0.5, 0.9, 0.99] * 20, [False, False, True, True, True] * 20)
    ),
    "coefficients": lambda d, _: plot.coefficients.draw(
        fit_isobars(Model.build("exponential_law"), d.base.record, ("contraction", "extension"))
    ),
    "confusion": lambda d, _: plot.confusion.draw(hidden_and_named()),
    "failure_map": lambda d, _: plot.failure_map.draw(compare(d.base)),
    "follows": lambda d, _: plot.follows.draw(
        [Follows(what, 0.1, f"something called {what}") for what in plot.follows.COLOUR]
    ),
    "four_bar": lambda d, _: plot.four_bar.draw(KNEE),
    "isobars": lambda d, _: plot.isobars.draw(d.base.record),
    "ladder": lambda _, steps: plot.ladder.draw(steps),
    "laws_compared": lambda d, _: plot.laws_compared.draw([d.base, fit(Model.build("chou_hannaford"), d.base.record)]),
    "loop_diagram": lambda d, _: loop_diagram.draw(),
    "measured_against_model": lambda d, _: plot.measured_against_model.draw(d.base, d.best),
    "over_pressure": lambda d, _: over_pressure.draw(*locked()),
    "profiles": lambda d, _: plot.profiles.draw(compare(d.base)),
    "residual_pattern": lambda d, _: plot.residual_pattern.draw(
        d.best, Pattern("local", "contraction", 12.0, "mm", 0.2, "")
    ),
    "signature": lambda d, _: plot.signature.draw(d.base, d.best),
    "candidates": lambda d, _: plot.candidates.draw(d),
    "tracking": lambda d, _: tracking.draw(track()),
}


@pytest.fixture(scope="module")
def drawn(diagnosis, ladder):
    """Every figure once, by module, laid out, with the texts that were drawn and the boxes they take."""
    found, draw_text = {}, Text.draw
    with pytest.MonkeyPatch.context() as patch:
        for name, draw in DRAW.items():
            figure, texts = draw(diagnosis, ladder), {}

            def noted(self, renderer, texts=texts):
                if self.get_visible() and self.get_text().strip():
                    texts[self] = self.get_window_extent(renderer)  # the last time counts
                draw_text(self, renderer)

            patch.setattr(Text, "draw", noted)
            plot.to_png(figure, 72)
            found[name] = (figure, list(texts.items()))
    return found


def test_every_figure_is_looked_at_here_and_says_what_it_would_draw():
    assert set(DRAW) == set(MODULES)
    assert {name for name, module in MODULES.items() if not hasattr(module, "data")} == WITHOUT_DATA


def labels(axes, which):
    """The label of an axis, or the one of the axes that share it."""
    grouper = axes.get_shared_x_axes() if which == "x" else axes.get_shared_y_axes()
    return {getattr(one, f"get_{which}label")() for one in grouper.get_siblings(axes)} - {""}


def names_its_ticks(axis):
    ticks = [tick.get_text() for tick in axis.get_ticklabels() if tick.get_text()]
    return bool(ticks) and not any(re.fullmatch(r"[−-]?[\d.]+", tick) for tick in ticks)


@pytest.mark.parametrize("name", sorted(set(MODULES) - WITHOUT_DATA - CATEGORIES))
def test_every_axis_says_its_unit(drawn, name):
    asked = [
        labels(axes, which)
        for axes in drawn[name][0].axes
        for which, axis in (("x", axes.xaxis), ("y", axes.yaxis))
        if axes.axison and not (axes.get_label() == "<colorbar>" and which == "x") and not names_its_ticks(axis)
    ]
    assert asked
    for said in asked:
        assert said and all(re.search(r"\(.+\)", one) for one in said), said


@pytest.mark.parametrize("name", MODULES)
def test_it_is_vectors_with_text_as_text_in_house_colours(drawn, name):
    before = dict(matplotlib.rcParams)
    svg = plot.to_svg(drawn[name][0])
    assert dict(matplotlib.rcParams) == before and ET.fromstring(svg).tag.endswith("svg")
    assert "<image" not in svg and "<text" in svg
    allowed = {to_hex(to_rgb(colour)) for colour in PALETTE}
    if name == "failure_map":
        allowed |= {to_hex(colour) for colour in matplotlib.colormaps[failure_map.COLOURS](np.arange(256))}
    used = set(re.findall(r"(?:fill|stroke|color): (#[0-9a-f]{6})", svg))
    assert used and used <= allowed, used - allowed
    assert len(used) > 2


@pytest.mark.parametrize("name", MODULES)
def test_text_can_be_read_and_nothing_is_cut_off_or_written_over(drawn, name):
    figure, texts = drawn[name]
    edge = figure.get_size_inches() * 72.0
    smallest = 4.5 if name == "failure_map" else 7.0  # the numbers in a large map are small
    assert texts
    for text, box in texts:
        assert text.get_fontsize() >= smallest and text.get_fontfamily() == ["sans-serif"], text
        assert min(box.x0, box.y0) >= -1.0 and box.x1 <= edge[0] + 1.0 and box.y1 <= edge[1] + 1.0, text
    upright = [(text, box.padded(-1.0)) for text, box in texts if text.get_rotation() % 90.0 == 0.0]
    for i, (text, box) in enumerate(upright):
        for other, one in upright[:i]:
            assert not box.overlaps(one), (text, other)
