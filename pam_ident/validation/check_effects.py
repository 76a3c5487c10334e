"""Does a user's own effect keep what every effect of the package promises?"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..effects import Effect, load_effect_file
from ..records import Record
from .effect_contract import BASIC, EFFECT_CHECKS, FORM_CHECKS, said
from .effect_record import clean_record


@dataclass(frozen=True)
class BrokenPromise:
    """What is wrong with an effect, or with one of its forms (empty for the effect as a whole), in words."""

    effect: str
    form: str
    text: str


def check_effects(file: str) -> tuple[tuple[Effect, ...], list[BrokenPromise]]:
    """The effects in a file, and what is wrong with them. Raises UsageError where the file cannot be loaded."""
    effects = load_effect_file(file)
    record = clean_record()
    return effects, [problem for effect in effects for problem in check_effect(effect, record)]


def check_effect(effect: Effect, record: Record) -> list[BrokenPromise]:
    """All that an effect does not keep of what it promises; a form that cannot be computed is not fitted either."""
    found = [BrokenPromise(effect.name, "", text) for check in EFFECT_CHECKS for text in _tried(check, effect, record)]
    for form in effect.forms:
        for check in FORM_CHECKS:
            texts = _tried(check, effect, form, record)
            found += [BrokenPromise(effect.name, form.name, text) for text in texts]
            if texts and check in BASIC:
                break
    return found


def _tried(check: Callable[..., list[str]], *given: object) -> list[str]:
    """What a check finds; a formula that breaks down is a finding too."""
    try:
        with np.errstate(all="ignore"):
            return check(*given)
    except Exception as error:
        return [f"breaks down ({said(error)})"]
