"""An effect of one's own: the scaffold works as written, and what is broken in a file is told in plain words."""

import re

import pytest
from typer.testing import CliRunner

from pam_ident.cli import app
from pam_ident.core import UsageError
from pam_ident.effects import AddsForce, ScalesForce, TransformsContraction, TransformsPressure, load_effect_file
from pam_ident.tasks.new_effect import ROLES, new_effect
from pam_ident.validation.check_effects import check_effect, check_effects

TYPES = {
    "adds_force": AddsForce,
    "scales_force": ScalesForce,
    "transforms_pressure": TransformsPressure,
    "transforms_contraction": TransformsContraction,
}


def ask(*words):
    return CliRunner().invoke(app, ["effects", *map(str, words)])


@pytest.mark.parametrize("role", TYPES)
def test_a_scaffold_of_each_role_loads_and_keeps_the_contract(role, tmp_path, record):
    assert set(ROLES) == set(TYPES)
    path = tmp_path / "spindle_play.py"
    result = ask("new", path, "--" + role.replace("_", "-"))
    assert result.exit_code == 0 and "effects check" in result.stdout, result.output
    assert [p.name for p in tmp_path.iterdir()] == ["spindle_play.py"]
    (effect,) = load_effect_file(path)
    assert effect.name == "spindle_play" and type(effect.forms[0]) is TYPES[role]
    assert check_effect(effect, record) == []


def test_the_example_for_contributors_keeps_the_contract(root, tmp_path):
    example = re.search(r"```python\n(.*?)```", (root / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.S)
    assert example is not None
    path = tmp_path / "spindle_ripple.py"
    path.write_text(example[1], encoding="utf-8")
    (effect,), problems = check_effects(str(path))
    assert effect.name == "spindle_ripple" and problems == []


def test_check_says_what_is_kept_and_a_named_scaffold_takes_the_name(tmp_path):
    path = tmp_path / "file-of-mine.py"
    assert ask("new", path, "--name", "mine").exit_code == 0
    result = ask("check", path)
    assert result.exit_code == 0 and result.stdout.startswith("mine: textbook keep"), result.output


@pytest.mark.parametrize(
    ("name", "given", "told"),
    [
        ("two-words.py", None, "--name"),
        ("fine.py", "for", "'for'"),
        ("fine.py", "a__b", "single underscores"),
        ("creep.py", None, "known already"),
        ("notes.txt", None, ".py"),
        ("no/folder.py", None, "no folder"),
    ],
)
def test_a_name_that_cannot_be_is_refused_and_nothing_written(tmp_path, name, given, told):
    with pytest.raises(UsageError, match=re.escape(told)):
        new_effect(tmp_path / name, given)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_stays_as_it_is(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("x = 1\n")
    with pytest.raises(UsageError, match="is there already"):
        new_effect(path)
    assert path.read_text() == "x = 1\n"


def test_two_roles_at_once_are_refused(tmp_path):
    result = ask("new", tmp_path / "a.py", "--adds-force", "--scales-force")
    assert result.exit_code == 2 and "one form" in result.stderr


BREAKS = {
    "columns of one dimension": ("[:, None]", "", "expected (samples, linear) = "),
    "a misspelt shape": ('values["length"]', 'values["lenght"]', "KeyError: 'lenght', line"),
    "a formula that blows up": ("xp.exp(-inputs.displacement_mm", "xp.exp(1e3 / inputs.displacement_mm", "not finite"),
    "a force of nothing": ("scale=10.0", "scale=1e-6", "N rms; set scale"),
    "an unreadable unit": ('"A", "N"', '"A", "pounds"', "unit 'pounds'"),
    "a parameter without words": ('"stroke over which it fades"', '""', "says nothing about itself"),
    "a grid out of bounds": ("grid=(4.0,", "grid=(0.1,", "0.1 in its grid"),
    "an unknown lever": ('levers=("pressure",)', 'levers=("luck",)', "unknown luck"),
    "an unknown need of a form": ("(LENGTH,))", "(LENGTH,), needs=('tide',))", "needs: unknown tide"),
    "no lever": ('levers=("pressure",)', "levers=()", "levers is empty"),
    "a need not named": ("xp.exp(-inputs.displacement_mm", "xp.exp(-inputs.time", "uses what needs = () does not name"),
    "a size that the neutral does not undo": (
        "-1000.0, 1000.0, scale",
        "-1000.0, 1000.0, neutral=1.0, scale",
        "at its",
    ),
    "a shape that no start reaches": (
        "xp.exp(-inputs.displacement_mm /",
        "xp.sin(inputs.displacement_mm * 60 /",
        "leaves",
    ),
    "a shape in steps": ('values["length"])', 'round(float(values["length"]), 3))', "not smooth in mine.length"),
    "functions of NumPy's": ("xp = inputs.pressure.__array_namespace__()", "import numpy as xp", "not from numpy"),
    "a sum over samples": ("-inputs.displacement_mm /", "-xp.cumsum(inputs.displacement_mm) /", "rows are muscles"),
    "a memory that is not told": (
        "-inputs.displacement_mm /",
        "-xp.abs(inputs.displacement_mm - xp.roll(inputs.displacement_mm, 1)) /",
        "add remembers=True",
    ),
    "twice the same column": ("(SIZE,), _columns", "(SIZE, OTHER), _twice", "cannot pin the size"),
}


@pytest.mark.parametrize("case", BREAKS)
def test_what_is_broken_is_told(case, tmp_path, record):
    path = tmp_path / "mine.py"
    new_effect(path)
    old, broken, told = BREAKS[case]
    text = path.read_text(encoding="utf-8")
    assert old in text
    twice = """
OTHER = Param("B", "N", "the same again", -1000.0, 1000.0, scale=10.0)


def _twice(inputs, values, force):
    return inputs.xp.hstack([_columns(inputs, values, force)] * 2)


EFFECT ="""
    path.write_text(text.replace(old, broken).replace("\nEFFECT =", twice), encoding="utf-8")
    (effect,) = load_effect_file(path)
    problems = check_effect(effect, record)
    assert any(told in problem.text for problem in problems), problems
    result = ask("check", path)
    assert result.exit_code == 2 and told in result.stdout and "not kept" in result.stderr
