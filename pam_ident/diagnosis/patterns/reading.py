"""A length that is not read where and when the force is: with play, which looks like friction, or at another instant,
which looks like what follows the speed."""

from collections.abc import Sequence

from ...core import Inputs, Param
from ...core.digits import number
from ...effects import Form, TransformsContraction
from ...effects.base import Array, Values
from .base import Extent, PatternShape

PLAY = Param("play", "mm", "play of the length's reading", 0.0, 20.0, scale=0.1)
ONE_INSTANT = "see whether the logger reads all channels at one instant"
LATE = Param("late", "s", "how much later than the length the force is read", -1.0, 1.0, scale=0.01)


def _behind(inputs: Inputs, values: Values, force: Array) -> Array:
    return 0.5 * inputs.direction[:, None] / inputs.specimen.initial_length_mm


def _past(inputs: Inputs, values: Values, force: Array) -> Array:
    """The first order of an expansion in the delay."""
    assert inputs.velocity is not None
    return -inputs.velocity[:, None] / inputs.specimen.initial_length_mm


PLAYS = TransformsContraction("play", "ε → ε + play sgn(ε̇)/(2 L0)", (PLAY,), _behind)
LOGGED_LATE = TransformsContraction("late", "ε → ε − late ε̇", (LATE,), _past)


def _forms(span: Extent) -> Sequence[Form]:
    if span.inputs.velocity is None or span.inputs.locked:
        return ()
    return PLAYS, LOGGED_LATE


def misread(form: Form, value: float) -> str:
    """What is wrong with the reading, in words, by the value of the form's parameter."""
    if form is PLAYS:
        return f"a length that is read with a play of {number(value, 2)} mm"
    return f"a force that is logged {number(abs(value), 2)} s {'after' if value > 0 else 'before'} the length"


def _words(at: Values, along: str) -> str:
    form, name = (PLAYS, PLAY.name) if along == "direction" else (LOGGED_LATE, LATE.name)
    return misread(form, at[name])


PATTERN = PatternShape(
    "reading",
    "reading of the length",
    "other",
    "direction",
    _forms,
    _words,
    {LOGGED_LATE.name: "speed"},
)
