"""A user's own effect comes in by a file, and a bad file is refused in one line."""

import numpy as np
import pytest

from pam_ident.core import Param, UsageError
from pam_ident.effects import AddsForce, Effect, Form, catalogue, get_effect, load_effect_file
from pam_ident.model import Model

TEXT = '''
"""Force of a counterweight that swings with the contraction."""

import numpy as np

from pam_ident.core import Param
from pam_ident.effects import AddsForce, Effect

SIZE = Param("W", "N", "weight", -100.0, 100.0, scale=5.0)

EFFECT = Effect(
    name="counterweight",
    title="Counterweight",
    source="our own rig",
    forms=(AddsForce("textbook", "+W sin(10 ε)", (SIZE,), lambda i, s, f: np.sin(10.0 * i.contraction)[:, None]),),
    test="take the weight off",
    levers=("pressure",),
)
'''


@pytest.fixture
def file(tmp_path):
    def write(text):
        path = tmp_path / "mine.py"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_an_effect_file_gives_an_effect_that_a_model_can_use(file, record):
    extra = load_effect_file(file(TEXT))
    assert [effect.name for effect in extra] == ["counterweight"]
    assert "counterweight" in catalogue(extra) and "counterweight" not in catalogue()
    model = Model.build("chou_hannaford", ("counterweight",), extra)
    with_weight = model.force(record.inputs, {"counterweight.W": 7.0})
    without = model.force(record.inputs, {"counterweight.W": 0.0})
    np.testing.assert_allclose(with_weight - without, 7.0 * np.sin(10.0 * record.inputs.contraction), atol=1e-9)


def test_an_effect_file_may_hold_several_effects(file):
    second = TEXT.split("EFFECT = ")[1].replace("counterweight", "second")
    assert [e.name for e in load_effect_file(file(TEXT + "\nOTHER = " + second))] == ["counterweight", "second"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x = 1\n", "defines no effect"),
        ("def broken(:\n", "SyntaxError"),
        ("import no_such_module_here\n", "ModuleNotFoundError"),
        ("1 / 0\n", "ZeroDivisionError"),
        (TEXT.replace('source="our own rig"', 'source=""'), "source"),
        (TEXT.replace('name="counterweight"', 'name="counter weight"'), "counter weight"),
        (TEXT.replace("-100.0, 100.0", "100.0, -100.0"), "bounds"),
    ],
)
def test_a_bad_effect_file_is_refused_by_name_and_reason(file, text, told):
    path = file(text)
    with pytest.raises(UsageError) as caught:
        load_effect_file(path)
    assert str(path) in str(caught.value) and told in str(caught.value) and caught.value.exit_code == 2


@pytest.mark.parametrize("name", ["gone.py", "folder", "notes.txt"])
def test_a_path_that_is_no_python_file_is_refused(tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "notes.txt").write_text("no code\n")
    with pytest.raises(UsageError, match=name.replace(".", r"\.")):
        load_effect_file(tmp_path / name)


def test_names_and_forms_are_looked_up_and_unknown_ones_refused_with_the_known():
    effect, form = get_effect("creep")
    assert form is effect.forms[0]
    assert get_effect("creep:prony_3")[1].name == "prony_3"
    with pytest.raises(UsageError, match=r"unknown effect 'magic'; `pam-ident effects` lists all \d\d"):
        get_effect("magic")
    with pytest.raises(UsageError, match=r"no form 'magic'.*textbook, logarithmic"):
        get_effect("creep:magic")


def test_a_model_refuses_an_effect_named_twice():
    with pytest.raises(UsageError, match="creep named twice"):
        Model.build("sarosi", ("creep", "creep:prony_3"))


def test_an_effect_without_form_or_of_no_role_is_refused():
    size = Param("k", "N", "size")
    with pytest.raises(UsageError, match="at least one form"):
        Effect("empty", "t", "s", (), "t")
    with pytest.raises((UsageError, TypeError)):
        Effect("plain", "t", "s", (Form("textbook", "f", (size,), lambda i, s, f: np.ones((len(i), 1))),), "t")
    good = AddsForce("textbook", "f", (size,), lambda i, s, f: np.ones((len(i), 1)))
    assert Effect("plain", "t", "s", (good,), "t").candidate


def test_the_effect_shown_in_the_contributors_guide_works(file, record, root):
    guide = (root / "CONTRIBUTING.md").read_text(encoding="utf-8")
    (effect,) = load_effect_file(file(guide.split("```python\n")[1].split("```")[0]))
    model = Model.build("chou_hannaford", (effect.name,), (effect,))
    values = model.neutral(record.inputs) | {f"{effect.name}.A": 5.0}
    rise = model.force(record.inputs, values) - model.force(record.inputs, model.neutral(record.inputs))
    np.testing.assert_allclose(rise, 5.0 * np.sin(2.0 * np.pi * record.inputs.displacement_mm / 5.0), atol=1e-9)
