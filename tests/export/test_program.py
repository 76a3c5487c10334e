"""What a program holds: arguments, memory, its refusals; and effects of users' own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import BY_NAME, MUSCLE, Case

from pam_ident.core import Param, UsageError
from pam_ident.effects import AddsForce, Effect
from pam_ident.export.program import program
from pam_ident.export.targets.c import c_header
from pam_ident.export.targets.matlab import matlab_function
from pam_ident.export.targets.python import python_function
from pam_ident.laws import get_law
from pam_ident.model import Model, Term
from pam_ident.validation.effect_contract import LAW_VALUES

SIZE = Param("A", "N", "size", -10.0, 10.0, scale=1.0)


def own(column, **more) -> Case:
    """A case with an effect of a user's own, of size 2."""
    form = AddsForce("own", "+A f", (SIZE,), lambda inputs, shape, force: column(inputs)[:, None])
    effect = Effect("own", "Own", "a test", (form,), "none", **more)
    model = Model(get_law("exponential_law"), (Term(effect, form),))
    return Case("own", model, {"together": LAW_VALUES | {"own.A": 2.0}})


def run(case: Case, *arguments):
    defined: dict = {}
    exec(python_function(case.fitted, "muscle"), defined)
    return defined["muscle"](*arguments)


def law_force(p, e):
    v = LAW_VALUES
    decay = np.exp(-v["mu"] * e)
    return v["a0"] + v["a1"] * p - (v["b0"] + v["b1"] * p) * e + (v["c0"] + v["c1"] * p) * decay


def test_a_law_is_asked_for_pressure_and_contraction_alone():
    made = program(BY_NAME["law_exponential_law"].fitted)
    assert made.arguments == ("pressure_MPa", "contraction") and made.later is None and made.memory == ()


@pytest.mark.parametrize(
    ("name", "arguments", "slots"),
    [
        ("coulomb_friction_textbook", ("direction", "held"), 0),
        ("coulomb_friction_relaxing", ("direction", "time_s", "held"), 2),
        ("stribeck_friction_textbook", ("velocity_mm_s", "direction", "time_s", "held"), 4),
        ("viscous_damping_power", ("velocity_mm_s",), 0),
        ("creep_textbook", ("time_s",), 3),
        ("creep_prony_3", ("time_s",), 5),
        ("creep_logarithmic", ("time_s",), 11),
        ("presliding_hysteresis_textbook", (), 2),
        ("mullins_softening_shaped", ("cycle",), 0),
        ("thermal_softening_textbook", ("temperature_C",), 1),
    ],
)
def test_only_what_is_needed_is_asked_for_and_remembered(name, arguments, slots):
    """A Maxwell element needs its state, and of the last sample contraction and time, which several share."""
    made = program(BY_NAME[name].fitted)
    assert made.arguments[2:] == arguments and len(made.memory) == slots


FUNCTIONS = {
    "trigonometry": (
        lambda xp, e: xp.sin(e) + xp.cos(2 * e) * xp.arctan2(e, 1 + e),
        lambda e: math.sin(e) + math.cos(2 * e) * math.atan2(e, 1 + e),
    ),
    "roots": (
        lambda xp, e: xp.cbrt(e) + xp.sqrt(xp.abs(e)),
        lambda e: math.copysign(abs(e) ** (1 / 3), e) + math.sqrt(abs(e)),
    ),
    "steps": (
        lambda xp, e: xp.floor(30 * e) + (30 * e) // 2.0 + xp.remainder(7 * e, 0.3),
        lambda e: math.floor(30 * e) + (30 * e) // 2.0 + (7 * e) % 0.3,
    ),
    "choice": (
        lambda xp, e: xp.where((e > 0.1) & ~(e > 0.2), e, -1.0) + xp.clip(e, 0.05, 0.15),
        lambda e: (e if 0.1 < e <= 0.2 else -1.0) + min(max(e, 0.05), 0.15),
    ),
    "powers": (
        lambda xp, e: e**3 + (1 + e) ** -2 + (1 + e) ** 0.7 + 1 / xp.sqrt(1 + e),
        lambda e: e**3 + (1 + e) ** -2 + (1 + e) ** 0.7 + 1 / math.sqrt(1 + e),
    ),
    "series": (
        lambda xp, e: sum(xp.stack([e * k for k in range(1, 5)])) + xp.arange(3.0).sum(),
        lambda e: 10 * e + 3.0,
    ),
    "matrix": (
        lambda xp, e: (xp.stack([e, e * e]).T @ xp.asarray([[1.0, 2.0], [3.0, 4.0]]))[:, 1],
        lambda e: 2 * e + 4 * e * e,
    ),
    "whole": (lambda xp, e: (e * 20).astype(int) * 1.5 + (e > 0), lambda e: 1.5 * int(e * 20) + (e > 0)),
}


@pytest.mark.long
@pytest.mark.parametrize("word", FUNCTIONS)
def test_an_effect_of_a_users_own_is_exported_as_it_is_written(word):
    traced, plain = FUNCTIONS[word]
    case = own(lambda inputs: traced(inputs.xp, inputs.contraction))
    for e in (-0.037, 0.0, 0.061, 0.151, 0.26):
        assert run(case, 0.4, e) == pytest.approx(law_force(0.4, e) + 2.0 * plain(e), rel=1e-13)
    for text in (c_header(case.fitted, "muscle"), matlab_function(case.fitted, "muscle")):
        assert "own_A = 2.0" in text


@pytest.mark.parametrize(
    ("column", "words"),
    [
        (lambda i: i.xp.sort(i.contraction), "sort"),
        (lambda i: i.xp.cumsum(i.contraction), "cumsum"),
        (lambda i: np.sin(np.asarray(i.contraction)), "xp"),
        (lambda i: i.contraction * math.inf, "finite"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_words(column, words):
    with pytest.raises(UsageError, match=words):
        c_header(own(column).fitted, "muscle")


def test_names_of_the_language_and_of_arguments_are_no_names_of_parameters():
    """A law whose parameters are called as functions, keywords and arguments are."""
    words = ("exp", "double", "contraction", "t_1", "muscle")
    law = get_law("polynomial")
    renamed = replace(
        law, linear=tuple(replace(p, name=n) for p, n in zip(law.linear, (*words, "a", "b"), strict=True))
    )
    values = dict(zip((p.name for p in renamed.linear), range(1, 8), strict=True))
    case = Case("words", Model(renamed), {"together": {k: float(v) for k, v in values.items()}})
    p, e = 0.5, 0.1
    assert run(case, p, e) == pytest.approx(p * (1 + 2 * e + 3 * e * e) + 4 + 5 * e + 6 * e**2 + 7 * e**3, rel=1e-14)
    text = c_header(case.fitted, "muscle")
    for word in words:
        assert f"const double p_{word} = " in text


def test_no_text_of_a_user_leaves_its_comment():
    """Neither by a new line nor by what joins lines in C."""
    fitted = BY_NAME["law_exponential_law"].fitted
    hostile = replace(fitted, record="a\n#error b\r\nc */ d ??/", specimen=replace(MUSCLE, name="x\\\nreturn 0;\\"))
    for text, mark in (
        (c_header(hostile, "muscle"), "//"),
        (python_function(hostile, "muscle"), "#"),
        (matlab_function(hostile, "muscle"), "%"),
    ):
        told = [line for line in text.splitlines() if "#error" in line or "return 0" in line or "*/" in line]
        assert told and all(line.startswith(mark) for line in told)
        assert not any(line.endswith(("\\", "??/")) for line in text.splitlines())
