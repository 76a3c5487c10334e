"""What a set of effects leaves beyond noise, in the words of the contract."""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..core.digits import newtons, number, percent
from ..effects import AddsForce
from ..fitting.length import weights_of
from ..model import Term
from ..records import Record
from .leaps import APART, LEAP, leaps
from .nouns import Pattern
from .patterns import catalogue as catalogue_of_patterns
from .patterns.beat import PATTERN as BEAT_IN_TIME
from .patterns.reading import ONE_INSTANT
from .repeats import rounding, step_of
from .search import CLOSE
from .selection import FittedSet, Selection
from .track import comes_to_rest
from .whitening import LAGS

Array = np.ndarray

REMAINDER = 0.25
"""Excess of the whitened sum of squares over the noise's, as a share, from which a remainder counts as unexplained."""
OF_ALL = 0.03
"""Share of what is to be explained that it must be, too: a form that is not exactly right may leave less."""
ALL = 0.995
"""Share of what is to be explained from which it is all of it."""
FORMS = {
    "even": "alike on both branches",
    "odd": "against the motion",
    "pressed": "in proportion to the pressure",
    "loaded": "in proportion to the force",
    "play": "it looks like friction: move the clamp to and fro by hand, the reading must follow at once",
    "late": f"it looks like damping: {ONE_INSTANT}",
}
"""Forms of patterns whose names say too little."""
HUM = 1.0
"""Square of a beat over that of the noise up to which it is noise."""
MOSTLY = 0.5
"""Share of what is left that follows something, from which it is no noise: 0.47 at most in 79 records without anything
hidden, of noise of all colours."""
CORNER = 5
"""Samples around a corner of the motion, where a position that is a little off is most."""
WINDOW, MEMORIES, BURSTING = 20, 4.0, 2.2
"""Samples, or memories of the noise where these are longer, over which what is left is averaged, and how many times the
median of such averages their mean may be: noise is there all the time, however coloured, heavy-tailed, or larger at one
pressure."""
SMOOTHER = 3.0
"""Standard deviations of Fisher's z by which the correlation of neighbours where most of it lies exceeds that elsewhere
or falls short of it, from which it is not louder noise."""
AT_TURNS = 3.0
"""Times the noise that most of what is left at the turns of the motion exceeds where it is none, and times what is left
at rest that is left in motion: in 82 records without anything hidden it was 1.5 at most, in 68 others 1.4."""
FAR, MEDIAN = 5.0, 2.33
"""Standard deviations by which chance is ruled out, and that of the logarithm of a squared median of normal samples,
times the root of their number."""
JUMPING = 1.8
"""How many times as large as in the middle steps of what is left may be in the mean: 1.43 at most in 86 records with
nothing hidden."""
FORETOLD = 0.3
"""Share of the noise's innovations that the LAGS samples before may foretell: 0.04 at most in records with nothing
hidden, 0.24 where a load cell hummed, and 0.47 where a frame rings."""
SWINGS = 0.2
"""The same of means of several samples, where they are largest at some period: 0.18 at most in 163 such records."""
LEAST = (WINDOW + 1) * LAGS
"""Samples that a prediction is made from at least."""
TINY = 0.1
"""Size over the median one below which it does not matter how small it is."""
ONE_IN_100 = 2.58
"""Standard deviations that normal numbers exceed once in a hundred times."""


def pattern_of(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """The pattern in a set, in the words of the contract; a large remainder without a shape is one too."""
    term = _shape_in(fitted)
    if term is None or hum(selection, fitted):
        return remainder_of(selection, fitted)
    explained = selection.empty.squares - fitted.squares
    share = min(max(_gain(selection, fitted, term) / max(explained, 1e-9), 0.0), 1.0)
    name = term.effect.name
    value, unit = next(((fitted.values[f"{name}.{p.name}"], p.unit) for p in term.form.nonlinear), (None, ""))
    shape = catalogue_of_patterns()[name]
    text = f"{in_words(fitted, term)}{_part(share)}"
    return Pattern(shape.kind, shape.along(term.form), value, unit, float(share), text)


def in_words(fitted: FittedSet, term: Term) -> str:
    """A term of a set that is no effect's, as a sentence calls it."""
    name = term.effect.name
    at = {p.name: fitted.values[f"{name}.{p.name}"] for p in term.form.params}
    shape = catalogue_of_patterns()[name]
    return f"{shape.words(at, shape.along(term.form))} ({FORMS.get(term.form.name, term.form.name.replace('_', ' '))})"


def as_good(selection: Selection, fitted: FittedSet, name: str) -> str:
    """What is no effect's and could take the place of a name in a set, in words: the likeliest such set without it that
    the record does not tell from this; else nothing."""
    others = [v for v in selection.cache.values() if v.names != v.candidates and name not in v.names]
    near = [v for v in others if v.criterion < fitted.criterion + CLOSE]
    best = min(near, key=lambda v: v.criterion, default=None)
    term = _shape_in(best) if best else None
    return in_words(best, term) if best and term else ""


def hum(selection: Selection, fitted: FittedSet) -> float:
    """Period in s of a beat of the force that is smaller than the noise, as a load cell hums; else 0."""
    term = _shape_in(fitted)
    if term is None or term.effect.name != BEAT_IN_TIME.name or not isinstance(term.form, AddsForce):
        return 0.0
    without, left = (
        float(np.mean(selection.plain_residual(terms, fitted.values) ** 2))
        for terms in (fitted.without(term), fitted.terms)
    )
    return fitted.values[f"{BEAT_IN_TIME.name}.period"] if without < (1.0 + HUM) * left else 0.0


def _shape_in(fitted: FittedSet) -> Term | None:
    """The term of a set that is no effect's."""
    return next((t for t in fitted.terms if not t.effect.candidate), None)


def _gain(selection: Selection, fitted: FittedSet, term: Term) -> float:
    """Squares that a set leaves more without one of its terms."""
    return selection.refit(fitted.without(term), fitted.values).squares - fitted.squares


def _part(share: float) -> str:
    """How much of the error a pattern is, where that is not all of it."""
    return f", {percent(share)} of what the law left unexplained" if share < ALL else ""


def remainder_of(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What a set leaves, where that is too much for noise or does not look like it; else None."""
    n = len(selection.record)
    left, all_of_it = fitted.squares - n, max(selection.empty.squares - n, 1e-9)
    if left < REMAINDER * n or left < OF_ALL * all_of_it:
        return unlike_noise(selection, fitted)
    rms = math.sqrt(float(np.mean(selection.view(fitted).residual ** 2)))
    size = min(selection.noise.sigma * math.sqrt(left / n), rms)
    share = min(left / all_of_it, 1.0)
    text = f"about {newtons(size)} rms of no recognisable shape{_part(share)}"
    return Pattern("other", "contraction", None, "", share, text)


def unlike_noise(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What a set leaves, where noise does not look like it; beside names not at the turns, where forms err most."""
    looks = (_foretold, _jumps, _bursts, _slow, *(() if fitted.candidates else (_at_turns, _in_motion, _followed)))
    return next((found for look in looks if (found := look(selection, fitted))), None)


def _followed(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What the law leaves, where most of that follows what was driven or the clock."""
    if selection.record.inputs.time is None:
        return None
    first, *_ = shares = selection.following.shares()
    share = sum(one.share for one in shares if one.what != "noise")
    if share < MOSTLY:
        return None
    text = f"{percent(share)} of the squared error follows what was recorded, first of all {first.text}"
    return Pattern("other", first.what, None, "", share, text)


def _evened(selection: Selection, fitted: FittedSet) -> Array:
    """What a set leaves in N (n,), less what rows share of it by an unsure track: the level of a hold that is a little
    off in each is no jump. Nor is what a form leaves that is not exactly right and stands still with the muscle: of
    names what smooth surfaces over the likeliest drivers explain is left out."""
    following, left = selection.following, selection.view(fitted).residual
    left = following.shared.even(left) if following.shared else left
    return following.surfaces.without(following.best, left) if fitted.candidates else left


def _at_turns(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What is left where the muscle turns or starts, or where it comes to rest, in samples that are looked at nowhere
    else: noise does not grow there."""
    unsure = selection.following.unsure
    if unsure is None:
        return None
    residual, stops = selection.view(fitted).residual, comes_to_rest(selection.record.inputs)
    parts = (residual[unsure.unread & here] for here in (~stops, stops))
    found = [v for v in parts if len(v) >= WINDOW and np.median(np.abs(v)) >= AT_TURNS * selection.noise.whole]
    if not found:
        return None
    turns = np.concatenate(found)
    size = float(np.sqrt(np.mean(turns**2)))
    text = f"about {newtons(size)} rms at the turns of the motion, where noise is {newtons(selection.noise.whole)}"
    return Pattern("other", "direction", None, "", float(np.sum(turns**2) / np.sum(residual**2)), text)


def _in_motion(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What is left while the muscle moves, and far less while it rests: noise does not know which it does."""
    moving, unsure = selection.record.inputs.moving, selection.following.unsure
    if moving is None or unsure is None:
        return None
    left, read = _evened(selection, fitted), ~(unsure.unread | selection.noise.outlier)
    moved, rested = left[read & moving], left[read & ~moving]
    if min(len(moved), len(rested)) < WINDOW:
        return None
    size, calm = float(np.std(moved)), math.sqrt(np.var(rested) + rounding(step_of(selection.record)))
    if size < AT_TURNS * calm:
        return None
    text = f"about {newtons(size)} rms while the muscle moves, where it is {newtons(calm)} while it rests"
    return Pattern("other", "speed", None, "", 1.0 - (calm / size) ** 2, text)


def _foretold(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What the samples before foretell is no noise: a beat, a swing, what comes and goes.

    Noise is foretold by its colour and no further, unless it hums: a longer linear prediction (Makhoul 1975,
    Proceedings of the IEEE 63, 561–580) adds nothing. Means of several samples tell of slower swings; noise that is
    slower than its colour is foretold by them, too, but is largest at no period.
    """
    inputs = selection.record.inputs
    if inputs.time is None or len(inputs) < LEAST:
        return None
    own = selection.noise_left_by(fitted)
    white, seen = own.whiten(selection.view(fitted).residual), np.asarray(~own.outlier)
    share, period = _foretold_by_before(white, seen)
    found, together = share > FORETOLD, 1
    while not (found or fitted.candidates) and len(white) >= 2 * LEAST:  # beside names forms leave what is slow, too
        even = len(white) // 2 * 2
        white, seen = white[:even].reshape(-1, 2).mean(axis=1), seen[0:even:2] & seen[1:even:2]
        share, period = _foretold_by_before(white, seen)
        found, together = share > SWINGS and period > 0.0, 2 * together
    if not found:
        return None
    text = f"{percent(share)} of what is left is foretold by the samples before it, beyond any slow noise"
    if period > 0.0:
        text += f"; it swings with a period of about {number(period * together * inputs.interval, 2)} s"
    return Pattern("other", "time", None, "", share, text)


def _foretold_by_before(white: Array, seen: Array) -> tuple[float, float]:
    """Share of the squares of a series (n,) that the LAGS samples before foretell, of those that were `seen` (n,); and
    the period in samples at which its spectrum is highest, 0 at an end of it."""
    whole = sliding_window_view(seen, LAGS + 1).all(axis=1)
    if np.count_nonzero(whole) < LEAST:  # where the motion turns every few samples, gaps foretell nothing
        white, whole = np.where(seen, white, 0.0), seen[LAGS:]
    rows = sliding_window_view(white, LAGS + 1)[whole]
    if len(rows) < LEAST:
        return 0.0, 0.0
    n = len(rows) - LAGS
    before, now = rows[:, :-1], rows[:, -1]
    weights = np.linalg.lstsq(before, now)[0]
    left = now - before @ weights
    share = 1.0 - float(left @ left) / n / float(np.mean(now**2))
    flat = np.abs(np.fft.rfft(np.r_[1.0, -weights[::-1]], 64 * LAGS))  # least where its spectrum is highest
    beat = int(np.argmin(flat))
    return share, 64 * LAGS / beat if 0 < beat < len(flat) - 1 else 0.0


def _jumps(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What stands still and jumps is no noise: however slow that is, it wanders all the time."""
    if selection.record.inputs.time is None:
        return None
    clean = ~selection.noise.outlier | comes_to_rest(selection.record.inputs)  # a level lasts
    left, time = _evened(selection, fitted)[clean], selection.record.inputs.time[clean]
    for apart in APART:
        at, far = leaps(left, time, step_of(selection.record), apart)
        if not len(at):
            continue
        chance = math.exp(ONE_IN_100 * MEDIAN / math.sqrt(len(far) / (2.0 * apart)))  # moments that share no sample
        others = far[np.abs(at - at[int(np.argmax(far))]) > 2 * apart]  # a few neighbours may be far off by chance
        once = LEAP**2 if apart == APART[0] else math.inf
        if float(np.sum(others)) / max(len(others), 1) < max(JUMPING, chance) and far.max() < once:
            continue
        worst = float(time[at[int(np.argmax(far))]])
        text = f"jumps: what is left stays level between sudden steps, the largest at {number(worst)} s"
        share = 1.0 - 1.0 / max(float(far.mean()), 1.0)
        return Pattern("other", "time", worst, "s", share, text)
    return None


def _bursts(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What strikes now and then is no noise: most of it lies in little of the time, where a sample tells of the next.

    Noise may be louder for a while, but is no smoother then. Of each two samples in a row the product is looked at,
    for noise with heavy tails strikes single ones. At the corners of the motion what is left is the position's,
    wherever the force is steep.
    """
    record, inputs, unsure = selection.record, selection.record.inputs, selection.following.unsure
    if inputs.time is None:
        return None
    moves = inputs.direction if inputs.moving is None else inputs.direction * inputs.moving
    corner = np.convolve(np.diff(moves, prepend=moves[0]) != 0.0, np.ones(CORNER), "same") > 0.0
    if unsure:  # nor is known what a rest begins with, which nobody saw the muscle come to
        corner |= unsure.unread
    size, time, level = (v[~corner] for v in (_evened(selection, fitted), inputs.time, weight_or_level(record)))
    window = max(WINDOW, round(MEMORIES * selection.noise.memory_samples(time)))
    count = (len(size) - 2) // window
    if count < WINDOW:
        return None
    size = _by_level(size, level)
    products = [size[2 - k : len(size) - k] * size[2:] for k in (0, 1, 2)]  # at two distances, lest one hide a swing
    square, *beside = (v[: count * window].reshape(-1, window) for v in products)
    pairs = np.abs(beside[0]).mean(axis=1)
    if pairs.mean() < BURSTING * np.median(pairs):
        return None
    struck = pairs > BURSTING * np.median(pairs)
    alike = (np.array([one[at].sum() for one in beside]) / square[at].sum() for at in (struck, ~struck))
    there, elsewhere = (np.arctanh(np.clip(one, -0.999, 0.999)) for one in alike)
    if np.max(np.abs(there - elsewhere)) * math.sqrt(square[struck].size) < SMOOTHER:
        return None
    share, worst = float(pairs[struck].sum() / pairs.sum()), float(time[window * int(np.argmax(pairs))])
    text = f"bursts: {percent(share)} of what is left in {percent(float(struck.mean()))} of the time, the most at "
    return Pattern("other", "time", worst, "s", share, f"{text}{number(worst)} s")


def weight_or_level(record: Record) -> Array:
    """Pressure in MPa or weight in N that was held, (n,)."""
    time, before = record.inputs.time, record.as_measured.inputs.time
    if not record.carried or time is None or before is None:
        return record.level
    return weights_of(record.as_measured)[np.searchsorted(before, time)]  # some rows were left out since


def _by_level(size: Array, level: Array) -> Array:
    """Values (n,) beside the median size at their `level` (n,): noise may be larger at one pressure, or weight."""
    found = size.copy()
    for rows in (level == one for one in np.unique(level)):
        found[rows] /= max(float(np.median(np.abs(size[rows]))), 1e-9)
    return found


def _slow(selection: Selection, fitted: FittedSet) -> Pattern | None:
    """What is larger in slow strokes than in faster ones, where the position is less sure, is no noise: that does not
    know the speed. But it may know the state, and slow strokes may be those at a high pressure: sizes are compared as
    if all were at one."""
    inputs, level = selection.record.inputs, weight_or_level(selection.record)
    if inputs.time is None or inputs.stroke_speed is None or inputs.moving is None:
        return None
    clean = inputs.moving & ~selection.noise.outlier
    if not clean.any():
        return None
    # Evened by what the noise has not, fast strokes would look calm.
    left = _evened(selection, fitted) if selection.noise.shared else selection.view(fitted).residual
    size = _by_level(np.abs(left)[clean], level[clean])
    speed = np.round(np.log2(np.maximum(inputs.stroke_speed[clean], 1e-9)))
    group = np.unique(speed, return_inverse=True)[1]
    logs = _at_one_state(np.log(np.maximum(size, TINY)), group, inputs.pressure[clean], inputs.contraction[clean])
    found = [(n, 2.0 * one) for n, one in zip(np.bincount(group), logs, strict=True) if n >= 2 * WINDOW]
    alone = 1.0 + 2.0 * selection.noise.memory_samples(inputs.time)
    for k, (n, slow) in enumerate(found[:-1]):
        m, fast = min(found[k + 1 :], key=lambda one: one[1])
        chance = FAR * MEDIAN * math.sqrt(alone * (1.0 / n + 1.0 / m))
        if slow - fast > max(math.log(BURSTING), chance):
            times = f"{math.exp(0.5 * (slow - fast)):.2g} times as large in slow strokes as in faster ones"
            text = f"what is left is {times}, as where a muscle sticks and slips"
            return Pattern("other", "speed", None, "", 1.0 - math.exp(fast - slow), text)
    return None


def _at_one_state(values: Array, group: Array, pressure: Array, contraction: Array) -> Array:
    """The mean of values (n,) of each `group` (n,) of 0 … k - 1, (k,), as if all were at one state, from a line of best
    fit in the groups and a quadratic in pressure and contraction, (n,)."""
    p, e = ((v - v.mean()) / max(float(v.std()), 1e-12) for v in (pressure, contraction))
    columns = np.column_stack([group[:, None] == np.arange(group.max() + 1), p, e, p * p, p * e, e * e])
    gram = columns.T @ columns
    return np.linalg.solve(gram + 1e-9 * len(values) * np.eye(len(gram)), columns.T @ values)[:-5]
