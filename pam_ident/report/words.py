"""Numbers and names as they are read."""

import math
import re

from ..core import digits
from ..core.prose import capital
from ..diagnosis.nouns import Diagnosis, Rung
from ..effects import AddsForce, Form, ScalesForce, TransformsContraction, TransformsPressure, in_words
from ..fitting.fit import Estimate
from ..model import Model

VERDICTS = {
    "adequate": ("Adequate", "The model explains this record down to its noise; no effect needs to be added."),
    "missing_effect": ("Missing effect", "The model leaves an error that a known physical effect explains."),
    "unknown_effect": (
        "Unknown effect",
        "The model leaves an error that no effect of the catalogue explains well enough.",
    ),
}
ROLES: dict[type[Form], str] = {
    AddsForce: "added to the force",
    ScalesForce: "scales the force",
    TransformsPressure: "changes the pressure the law is given",
    TransformsContraction: "changes the contraction the law is given",
}


# Controls but tab and line feed, what turns the direction of text, and what XML does not allow.
UNSEEN = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ufffe\uffff"
    r"\ud800-\udfff]"
)
SHARE = re.compile(r"(?<=[<>]) (?=\d)|(?<=\d) (?=%)")


def plain(text: str) -> str:
    """The text with a � for each character that cannot be seen and could make it read as something else."""
    return UNSEEN.sub("\ufffd", text)


def together(text: str) -> str:
    """The text with each per cent sign, and > and <, on the line of its number."""
    return SHARE.sub("\u00a0", text)


def number(value: float | None, places: int = 4) -> str:
    """Significant digits without a power of ten for everyday sizes, a true minus sign, a dash for no value."""
    return _set(digits.number(value, places))


def newtons(value: float | None) -> str:
    """A force error in N with three digits."""
    return _set(digits.newtons(value))


def known_to(value: float, error: float) -> str:
    """A value with the digits that its standard error leaves."""
    return _set(digits.known_to(value, error))


def percent(share: float | None) -> str:
    """A share in whole per cent."""
    return _set(digits.percent(share))


likely = digits.probability


def value_of(estimate: Estimate) -> str:
    """A parameter's value with the digits that its standard error leaves."""
    return known_to(estimate.value, math.nan if estimate.at_bound else estimate.stderr)


def interval(estimate: Estimate) -> str:
    """The 95 % interval to the place of the value, a dash where there is none."""
    ends = estimate.low, estimate.high
    return "–" if all(map(math.isnan, ends)) else _set(digits.interval(*ends, estimate.stderr))


def with_error(value: float, error: float) -> str:
    """A value ± its standard error; alone where it has none."""
    return known_to(value, error) + (f" ± {number(error, 2)}" if math.isfinite(error) else "")


def _set(text: str) -> str:
    """Digits as they are typeset."""
    return text.replace("-", "−") if any(map(str.isdigit, text)) else text.replace("-", "–")


def heldout(rung: Rung) -> str:
    """What the error of a rung on held-out data is called."""
    return ("" if rung.refit_rmse is None else "nested ") + "held-out error"


def stderr(estimate: Estimate) -> str:
    """A standard error, or in words why there is none."""
    if not estimate.identified:
        return "not determined"
    return number(estimate.stderr, 2) if math.isfinite(estimate.stderr) else "not computed"


def standing(estimate: Estimate) -> str:
    """Whether the record determines a parameter, in words."""
    if not estimate.identified:
        return "not determined by this record" + (", at its bound" if estimate.at_bound else "")
    word = "at its bound" if estimate.at_bound else "determined"
    return f"{word}, impossible" if estimate.possible is False else word


def unit(text: str) -> str:
    """A unit as printed; 1 means a pure number."""
    return text or "1"


def equation(model: Model) -> list[str]:
    """The law's formula, and a line an effect with its formula and what it does."""
    lines = [f"{capital(model.law.title)}: {model.law.formula} (source: {model.law.source})"]
    for term in model.terms:
        role = next((word for kind, word in ROLES.items() if isinstance(term.form, kind)), "")
        lines.append(
            f"{capital(term.effect.title)} ({term.label}), {role}: {term.form.formula} (source: {term.effect.source})"
        )
    return lines


def groups(diagnosis: Diagnosis) -> list[str]:
    """Effects that a record cannot tell apart, a line a group of two or more."""
    return [
        f"This record cannot tell apart: {'; '.join(in_words(name, diagnosis.best.model.own) for name in group)}."
        for group in diagnosis.groups
        if len(group) > 1
    ]
