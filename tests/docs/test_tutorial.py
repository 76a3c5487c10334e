"""The tutorial says what the program prints."""

import importlib.util
import re

import pytest


@pytest.fixture(scope="module")
def maker(root):
    """What writes the outputs of now into the tutorial and the README."""
    spec = importlib.util.spec_from_file_location("make_tutorial", root / "docs" / "make_tutorial.py")
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    return maker


@pytest.fixture(scope="module")
def pages(maker):
    """The tutorial as it is written, and as it is with the outputs of now."""
    text = maker.PAGE.read_text(encoding="utf-8")
    return text, maker.refreshed(text), maker.BLOCK


def compare(agree, text, now):
    shown, fresh = text.splitlines(), now.splitlines()
    assert len(shown) == len(fresh), "run `python docs/make_tutorial.py`, and read the page again"
    wrong = [(a, b) for a, b in zip(shown, fresh, strict=True) if not agree(" ".join(a.split()), " ".join(b.split()))]
    assert not wrong, "run `python docs/make_tutorial.py`, and mend the words around what changed"


@pytest.mark.long
def test_every_shown_output_is_what_the_program_prints(pages, agree):
    compare(agree, *pages[:2])


@pytest.mark.long
def test_the_readme_shows_what_the_program_prints(maker, agree):
    text = maker.README.read_text(encoding="utf-8")
    (block,) = maker.BLOCK.finditer(text)
    assert len(block["output"].splitlines()) == 10
    compare(agree, text, maker.refreshed(text))


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
    assert "verdict: missing effect" in diagnosis
    assert "Missing: friction that grows with pressure (pressure_friction" in " ".join(diagnosis.split())
    assert any("verdict: adequate" in o for c, o in outputs.items() if "nothing_hidden" in c)


def test_a_changed_digit_is_noticed(agree):
    assert agree("rmse 6.34 N, largest error 18.4 N", "rmse 6.35 N, largest error 18.4 N")
    assert not agree("rmse 6.34 N", "rmse 6.36 N")
    assert not agree("Missing: creep", "Missing: damping")
