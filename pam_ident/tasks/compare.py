"""Where a model fails on a record."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..core import UsageError
from ..core.digits import millimetres, newtons, percent
from ..diagnosis.compare import compare
from ..diagnosis.follows import Following
from ..diagnosis.nouns import Bin, Comparison, Follows
from ..diagnosis.sentence import told
from ..fitting import Fit, fit
from ..fitting.carried import InLength, driven
from ..fitting.length import by_length, weights_of
from ..records import Record
from .gate import admit, computing, require_rows
from .setup import Setup


def compare_record(record: Record, setup: Setup) -> Comparison:
    """Fit `setup.model` to both branches together and split the error by place: where the length answered that of the
    length, in mm, by the weight, too. Raises FitError or DataError."""
    admit(record)
    require_rows(record)
    with computing(record):
        one = fit(setup.model, record)
        return _compare_length(one) if by_length(record) else compare(one)


def _compare_length(one: Fit) -> Comparison:
    """What it follows is that of the force at the measured length. Under one weight it is not asked: the length is a
    line over pressure, and all drivers that go with the pressure are one."""
    assert one.lengths is not None
    follows: tuple[Follows, ...] = ()
    if len(np.unique(one.lengths.weight[one.rows])) > 1:
        follows = Following.of(fit(one.model, driven(one.model, one.record, one.values))).shares()
    found = compare(InLength.of(one), follows)
    by = {"load_N": tuple(_by_weight(one)), **found.by}
    return replace(found, fit=one, by=by, sentence=_sentence(one, replace(found, by=by)))


def _by_weight(one: Fit) -> Iterator[Bin]:
    assert one.lengths is not None
    weight, off = weights_of(one.record), np.where(one.rows, one.lengths.residual, 0.0)
    for w in np.unique(weight[one.rows]):
        mine = off[(weight == w) & one.rows]
        square = float(mine @ mine)
        share = square / max(float(off @ off), 1e-300)
        yield Bin(newtons(w), float(w), float(w), len(mine), float(mine.mean()), math.sqrt(square / len(mine)), share)


def _sentence(one: Fit, found: Comparison) -> str:
    assert one.length_errors is not None
    worst, place = (max(found.by[key], key=lambda part: part.share) for key in ("load_N", "pressure_MPa"))
    text = (
        f"The {one.model.words} misses the length by {millimetres(one.length_errors.rmse)} rms (at most "
        f"{millimetres(one.length_errors.largest)}). {percent(worst.share)} of the squared error lies under "
        f"{worst.label}, {percent(place.share)} about {place.label}."
    )
    if found.odd is not None and found.even is not None:
        text += f" {percent(found.odd)} of it changes sign with the branch, {percent(found.even)} is the same on both."
    return f"{text} {told(found.follows, 'squared error of the force at that length')}" if found.follows else text


def failure_picture(comparison: Comparison, suffix: str) -> str | bytes:
    """The failure map as the text of an SVG file, or the bytes of a PNG file for `.png`. Raises UsageError where the
    length answered."""
    from ..plot import failure_map, to_png, to_svg

    if comparison.fit.lengths is not None:
        raise UsageError("--out draws an error of the force, and in an isotonic test the length answers; leave it out")
    figure = failure_map.draw(comparison)
    return to_png(figure) if suffix.lower() == ".png" else to_svg(figure)
