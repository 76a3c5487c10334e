"""What the error follows: shares of its square as one bar."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

from matplotlib.figure import Figure

from ..core.digits import percents
from ..diagnosis.nouns import Follows
from .style import (
    BLACK,
    BLUE,
    BROWN,
    FAINT,
    GREEN,
    GREY,
    INK,
    LILAC,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    WIDTH,
    YELLOW,
    canvas,
    styled,
)

COLOUR = {
    "map": BLUE,
    "direction": VERMILION,
    "speed": ORANGE,
    "pressure_rate": BROWN,
    "acceleration": INK,
    "way": PURPLE,
    "rest": GREEN,
    "cycle": YELLOW,
    "clock": SKY,
    "temperature": BLACK,
    "step": LILAC,
    "repeats": GREY,
    "noise": FAINT,
}
"""A colour each, the same in every figure."""
DARK = {BLUE, VERMILION, PURPLE, BLACK, BROWN, INK, GREEN, GREY}
SEEN = 0.005
"""Shares below this are neither drawn nor named, but for the noise."""
WRITTEN = 0.09
"""Shares from this on are written into the bar."""


@dataclass(frozen=True)
class Piece:
    """A piece of the bar from `begin` over `share` of its length, both of 1, in its colour; `percent` is the share in
    words, `text` says what it is."""

    percent: str
    text: str
    begin: float
    share: float
    colour: str


def data(follows: Sequence[Follows]) -> tuple[Piece, ...]:
    """The pieces from left to right in the order given, which is largest first and noise last."""
    whole = dict(zip(follows, percents([one.share for one in follows]), strict=True))
    shown = [one for one in follows if one.share >= SEEN or one.what == "noise"]
    begins = accumulate((one.share for one in shown), initial=0.0)
    return tuple(
        Piece(whole[one], one.text, begin, one.share, COLOUR.get(one.what, INK))
        for one, begin in zip(shown, begins, strict=False)
    )


@styled
def draw(follows: Sequence[Follows], width: float = WIDTH) -> Figure:
    """One bar of the whole squared error, and under it what each piece follows with its share."""
    pieces = data(follows)
    figure = canvas(1.0 + 0.19 * max(len(pieces), 1), width)
    axes = figure.subplots()
    for piece in pieces:
        axes.barh(0, piece.share, left=piece.begin, color=piece.colour, edgecolor="white", linewidth=0.8,
                  label=f"{piece.percent} {piece.text}")  # fmt: skip
        if piece.share >= WRITTEN:
            ink = "white" if piece.colour in DARK else INK
            axes.text(piece.begin + 0.5 * piece.share, 0, piece.percent, ha="center", va="center", color=ink)
    axes.set_xlim(0.0, 1.0)
    axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "25", "50", "75", "100"])
    axes.set_xlabel("share of the squared error (%)")
    axes.set_yticks([0], ["error"])
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    axes.grid(visible=False)
    if pieces:
        figure.legend(loc="outside lower left", labelcolor=INK, handlelength=1.0, labelspacing=0.3)
    return figure
