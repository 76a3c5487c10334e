"""Does a user's own effect keep what every effect of the package promises, on a clean record that moves everything?"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..core import Specimen
from ..effects import Effect, load_effect_file
from ..records import Record, build_record
from .effect_contract import BASIC, EFFECT_CHECKS, FORM_CHECKS, said, showing

MUSCLE = Specimen("clean", 200.0, 10.0, 25.4, 1.5)


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
            texts = _tried(check, effect, form, showing(record, form))
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


def clean_record(per_move: int = 20, per_hold: int = 6) -> Record:
    """Three isobars, three speeds, two cycles of each, holds, minor loops, a temperature that climbs and falls.

    Minor loops speed up and brake all the way, the others go at one speed. The force is zero. `per_move` and
    `per_hold` are samples of each stroke and each hold.
    """
    rows, clock = [], 0.0
    for pressure in (0.2, 0.5, 0.35):
        clock += 15.0
        cycle = 0
        for speed in (2.0, 10.0, 40.0):
            for low, high in ((0.0, 46.0), (20.0, 34.0)):
                cycle += 1
                for begin, end in ((low, high), (high, low)):
                    took = abs(end - begin) / speed
                    share = np.arange(1, per_move + 1) / per_move
                    way = share if low == 0.0 else share**2 * (3.0 - 2.0 * share)
                    rows += [
                        (clock + took * s, pressure, begin + (end - begin) * x, cycle)
                        for s, x in zip(share, way, strict=True)
                    ]
                    clock += took
                    rest = 3.0 * np.arange(1, per_hold + 1) / per_hold
                    rows += [(clock + r, pressure, end, cycle) for r in rest]
                    clock += 3.0
    time, pressure, x, cycle = np.array(rows).T
    return build_record(
        MUSCLE.name,
        MUSCLE,
        pressure,
        x / MUSCLE.initial_length_mm,
        np.zeros(len(time)),
        time=time,
        cycle=cycle,
        temperature=22.0 + 6.0 * np.sin(time / time[-1] * 5.0),
    )
