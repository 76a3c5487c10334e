"""The pages that are made from the program: nothing is left out, and an effect of a user's own has a page too."""

import re
from importlib import import_module

import numpy as np
import pytest
from typer.main import get_command

import pam_ident
from pam_ident.cli import app
from pam_ident.core.prose import capital
from pam_ident.effects import catalogue as effects
from pam_ident.effects import get_effect, load_effect_file
from pam_ident.laws import catalogue as laws

OWN = '''"""A ripple that nobody but this laboratory has."""

import math

from pam_ident.core import Inputs, Param
from pam_ident.effects import Effect, ScalesForce

SIZE = Param("A", "1", "amplitude of the ripple | as a share", -0.5, 0.5, scale=0.01)
WAVE = Param("length", "mm", "length of the ripple", 4.0, 8.0, start=5.0, grid=(4.5, 5.0, 6.0))


def _ripple(inputs: Inputs, shape, force):
    xp = inputs.pressure.__array_namespace__()
    return xp.sin(2.0 * math.pi * inputs.displacement_mm / shape["length"])[:, None]


EFFECT = Effect(
    name="own_ripple",
    title="Ripple of our spindle",
    source="our drive's data sheet",
    forms=(ScalesForce("textbook", "F (1 + A sin(2π x/length))", (SIZE,), _ripple, (WAVE,)),),
    test="the same stroke on another part of the spindle",
    levers=("reversal",),
)
'''


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "own_ripple.py"
    path.write_text(OWN, encoding="utf-8")
    return load_effect_file(path)[0]


def read(path):
    return path.read_text(encoding="utf-8")


@pytest.mark.long
def test_every_effect_and_law_has_a_page_that_tells_all_of_it(generated):
    for name, effect in effects().items():
        page = read(generated / "effects" / f"{name}.md")
        told = [capital(effect.title), effect.source, effect.warning, *(f.name for f in effect.forms)]
        told += [f.formula for f in effect.forms] + [f"`{p.name}`" for f in effect.forms for p in f.params]
        assert not [text for text in told if text not in page], name
        assert effect.test.lower() in page.lower()
        assert (generated / "effects" / f"{name}.png").stat().st_size > 5000
        assert f"({name}.md)" in read(generated / "effects" / "index.md")
    for name, law in laws().items():
        page = read(generated / "laws" / f"{name}.md")
        assert not [
            text for text in (capital(law.title), law.formula, *(f"`{p.name}`" for p in law.params)) if text not in page
        ]
        assert law.source[1:] in page


@pytest.mark.long
def test_the_first_words_of_a_page_are_those_of_the_effect_s_file(generated):
    for kind, names in (("effects", effects()), ("laws", laws())):
        for name in names:
            words = import_module(f"pam_ident.{kind}.{name}").__doc__.strip()
            assert words in read(generated / kind / f"{name}.md"), name


@pytest.mark.long
def test_every_command_and_option_is_in_the_reference(generated):
    page = read(generated / "commands.md")
    for name, command in get_command(app).commands.items():
        section = page.partition(f"\n## pam-ident {name}\n")[2].partition("\n## ")[0]
        assert command.help.splitlines()[0] in section
        for option in command.params:
            assert not [word for word in option.opts if word.startswith("--") and word not in section], name
        for sub in getattr(command, "commands", {}):
            assert f"### pam-ident {name} {sub}\n" in section


@pytest.mark.long
def test_every_public_name_is_in_the_reference(generated, maker):
    api = maker("api_page")
    root = read(generated / "api" / "index.md")
    assert not [name for name in pam_ident.__all__ if f"`{name}" not in root]
    for package in api.PACKAGES:
        page = read(generated / "api" / f"{package}.md")
        missing = [n for n in api.public_names(package) if not re.search(rf"\b{re.escape(n)}\b", page)]
        assert not missing, package
    homes = {home.removeprefix("pam_ident.").partition(".")[0] for home in pam_ident._HOME.values()}
    assert homes <= set(api.PACKAGES)


def test_every_page_is_reached_from_the_front_page(root):
    front = read(root / "docs" / "index.md")
    pages = {path.stem for path in (root / "docs").glob("*.md")} - {"index"}
    assert not [page for page in pages if not re.search(rf"^{page}$", front, re.M)]


def test_a_user_s_effect_has_a_page_of_the_same_make(own, maker):
    pages, signatures = maker("effect_pages"), maker("signatures")
    every = [*effects().values(), own]
    left = [(law, signatures.share_left(own, law)) for law in laws()]
    page = pages.effect_page(own, signatures.look_alikes(own, every), left, "own_ripple.png", [e.name for e in every])
    assert page.startswith("# Ripple of our spindle\n\n`own_ripple`\n\nA ripple that nobody but this laboratory has.")
    assert "F (1 + A sin(2π x/length))" in page
    assert "It scales the law's force." in page
    assert r"| `A` | 1 | −0.5 to 0.5 | amplitude of the ripple \| as a share |" in page
    assert "The same stroke on another part of the spindle." in page
    assert signatures.draw(own) is not None


def test_an_effect_whose_needs_no_record_here_meets_has_a_page_without_a_figure(own, maker):
    page = maker("effect_pages").effect_page(own)
    assert "## Forms" in page
    assert "How it looks" not in page


def test_a_law_leaves_nothing_of_what_it_can_write_itself(maker):
    signatures = maker("signatures")
    bias = get_effect("force_bias")[0]
    assert signatures.share_left(bias, "exponential_law") < 1e-9  # a0 is a force bias
    assert signatures.share_left(bias, "chou_hannaford") == pytest.approx(1.0)  # nothing is free there
    assert signatures.share_left(get_effect("coulomb_friction")[0], "exponential_law") > 0.99  # odd in the branch


def test_signatures_are_compared_beyond_the_law(maker):
    """The cosine of friction and friction over pressure, by plain least squares on the same columns."""
    signatures = maker("signatures")
    here, record = signatures.around_law(signatures.PLAIN_LAW), signatures.standard_record()
    inputs = record.inputs
    sliding = -inputs.direction * inputs.moving
    both = np.column_stack([sliding, sliding * inputs.pressure])
    both = both - here.basis @ np.linalg.lstsq(here.basis, both, rcond=None)[0]
    cosine = abs(both[:, 0] @ both[:, 1]) / np.prod(np.linalg.norm(both, axis=0))
    found = dict(signatures.look_alikes(get_effect("coulomb_friction")[0], list(effects().values())))
    assert found["pressure_friction"] == pytest.approx(cosine, abs=1e-9)
    assert 0.8 < cosine < 0.95


READ = ("Tutorial", "How to", "Explanation")
"""Captions of what is read from top to bottom; in reference and validation one looks things up."""


def test_a_page_that_is_read_has_2000_words_at_most(root):
    index = read(root / "docs" / "index.md")
    groups = re.findall(r":caption: ([^\n]+)\n:maxdepth: 1\n\n(.*?)```", index, re.S)
    assert set(READ) < {caption for caption, _ in groups}
    pages = [name for caption, names in groups if caption in READ for name in names.split()]
    counts = {name: len(re.findall(r"\S*\w\S*", read(root / "docs" / f"{name}.md"))) for name in pages}
    assert len(counts) >= 12 and max(counts.values()) <= 2000, counts
