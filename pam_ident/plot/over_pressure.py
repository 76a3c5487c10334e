"""What answered a driven pressure, measured and modelled: the force of a locked muscle, or the length under a load."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..core.digits import newtons
from ..fitting import Fit
from ..fitting.length import Lengths, weights_of
from ..records import Record
from ..records.kind import held_lengths
from .style import BLUE, GREEN, INK, ORANGE, PURPLE, SKY, VERMILION, canvas, cloud, styled, thin, zero_line

Array = np.ndarray
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)


@dataclass(frozen=True)
class Held:
    """The samples of one held length, or weight, in order of time, (n,) each: pressure in MPa, what was measured and
    what the models say of it, in N or mm; `after` is None without a second fit."""

    label: str
    pressure: Array
    measured: Array
    before: Array
    after: Array | None


def data(fit: Fit, after: Fit | None = None, limit: int = 1500) -> tuple[Held, ...]:
    """What was held, lowest first, with at most `limit` samples in all."""
    record = fit.record.as_measured
    hung = record.kind == "isotonic"
    held = weights_of(record) if hung else held_lengths(record.inputs.contraction)
    measured = record.inputs.displacement_mm if hung else record.force
    models = [None if one is None else _modelled(one, record) for one in (fit, after)]
    shown = thin(len(record), limit)
    found = []
    for value in np.unique(held):
        rows = shown[held[shown] == value]
        label = newtons(value) if hung else f"{record.specimen.initial_length_mm * value:.1f} mm"
        before, later = (None if one is None else one[rows] for one in models)
        assert before is not None
        found.append(Held(label, record.inputs.pressure[rows], measured[rows], before, later))
    return tuple(found)


def _modelled(fit: Fit, record: Record) -> Array:
    """What a fit says of the answer of a record, (n,): NaN where the model has no stable length."""
    if record.kind != "isotonic":
        return fit.model.force(record.inputs, fit.values)
    found = Lengths.of(fit.model, record, fit.values)
    return np.where(found.slope < 0.0, record.specimen.initial_length_mm * found.contraction, np.nan)


def panels(after: Fit | None) -> tuple[Figure, Axes, list[Axes]]:
    """A figure with a tall panel for the answer, and below it one for the error of each fit."""
    titles = ("Error of the model as given", *(("Error after",) if after else ()))
    figure = canvas(4.2 + 1.5 * len(titles))
    top, *errors = figure.subplots(1 + len(titles), 1, sharex=True, height_ratios=[4.2] + [1.5] * len(titles))
    top.set_title(f"Measured (points) and {'completed model' if after else 'model'} (lines)")
    for panel, title in zip(errors, titles, strict=True):
        zero_line(panel)
        panel.set_title(title)
    return figure, top, errors


@styled
def draw(fit: Fit, after: Fit | None = None, limit: int = 1500) -> Figure:
    """The answer over the pressure on top; below it the error of `fit`, and of `after` on the same scale."""
    record, curves = fit.record.as_measured, data(fit, after, limit)
    answer, unit = ("shortening", "mm") if record.kind == "isotonic" else ("force", "N")
    figure, top, errors = panels(after)
    reach = 0.0
    for k, held in enumerate(curves):
        colour, last = COLOURS[k % len(COLOURS)], held.before if held.after is None else held.after
        cloud(top, held.pressure, held.measured, colour, 3.0, label=held.label)
        top.plot(held.pressure, last, color=INK, linewidth=0.7)
        for panel, model in zip(errors, (held.before, held.after), strict=False):
            assert model is not None
            error = held.measured - model
            reach = max(reach, float(np.nanmax(np.abs(error), initial=0.0)))
            cloud(panel, held.pressure, error, colour, 3.0, 0.45)
    top.set_ylabel(f"{answer} ({unit})")
    what = "weight" if record.kind == "isotonic" else "held at a shortening of"
    top.legend(title=what, loc="upper left", labelcolor=INK, ncols=1 + len(curves) // 7)
    for panel in errors:
        panel.set_ylim(-1.08 * reach, 1.08 * reach)
        panel.set_ylabel(f"error ({unit})")
    errors[-1].set_xlabel("gauge pressure p (MPa)")
    return figure
