"""The tutorial says what the program prints."""

import importlib.util
import re

import pytest


@pytest.fixture(scope="module")
def pages(root):
    """The tutorial as it is written, and as it is with the outputs of now."""
    spec = importlib.util.spec_from_file_location("make_tutorial", root / "docs" / "make_tutorial.py")
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    text = maker.PAGE.read_text(encoding="utf-8")
    return text, maker.refreshed(text), maker.BLOCK


NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def agree(shown, now):
    """Words equal, numbers within one unit of the last digit that is shown: arithmetic differs by machine."""
    if NUMBER.split(shown) != NUMBER.split(now):
        return False
    for a, b in zip(NUMBER.findall(shown), NUMBER.findall(now), strict=True):
        digits = a.partition("e")[0].partition(".")[2]
        unit = 10.0 ** -len(digits) if "e" not in a else 0.1 * abs(float(a))
        if abs(float(a) - float(b)) > 1.01 * unit:
            return False
    return True


@pytest.mark.long
def test_every_shown_output_is_what_the_program_prints(pages):
    text, now, _ = pages
    shown, fresh = text.splitlines(), now.splitlines()
    assert len(shown) == len(fresh), "run `python docs/make_tutorial.py`, and read the page again"
    wrong = [(a, b) for a, b in zip(shown, fresh, strict=True) if not agree(" ".join(a.split()), " ".join(b.split()))]
    assert not wrong, "run `python docs/make_tutorial.py`, and mend the words around what changed"


@pytest.mark.long
def test_forces_told_in_the_words_stand_in_an_output(pages):
    text, now, block = pages
    outputs = [float(x) for found in block.finditer(now) for x in re.findall(r"\d+\.\d+|\d+", found["output"])]
    told = re.findall(r"(\d+(?:\.\d+)?) N\b", block.sub("", text))
    assert len(told) >= 12
    for number in told:
        digits = len(number.partition(".")[2])
        assert any(round(x, digits) == float(number) for x in outputs), f"{number} N"


@pytest.mark.long
def test_the_tutorial_ends_with_the_hidden_effect(pages):
    _, now, block = pages
    outputs = {found["command"]: found["output"] for found in block.finditer(now)}
    diagnosis = next(o for c, o in outputs.items() if c.startswith("pam-ident diagnose datasets/hidden_effect"))
    assert "verdict missing_effect" in diagnosis
    assert "Missing: pressure_friction" in diagnosis
    assert any("verdict adequate" in o for c, o in outputs.items() if "nothing_hidden" in c)


def test_a_changed_digit_is_noticed():
    assert agree("rmse 6.34 N, largest error 18.4 N", "rmse 6.35 N, largest error 18.4 N")
    assert not agree("rmse 6.34 N", "rmse 6.36 N")
    assert not agree("Missing: creep", "Missing: damping")
