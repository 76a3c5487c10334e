"""What is printed calls effects and laws by words; the names to type stand in brackets."""

import re

import pytest

from pam_ident.cli.diagnose import describe
from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.sentence import reservations, sentence
from pam_ident.effects import catalogue, in_words, named
from pam_ident.fitting import fit
from pam_ident.laws import catalogue as laws
from pam_ident.model import Model, steps
from pam_ident.records import read_record, thinned

CODE = re.compile(rf"\b({'|'.join(name for name in (*catalogue(), *laws()) if '_' in name)})\b")
IN_BRACKETS, KEYS = re.compile(r"\([^()]*\)"), re.compile(r"^  \w.*$", re.MULTILINE)
"""Names to type, and the rows of a table under the keys that JSON has, too."""


def codes(text):
    """Names of effects and laws in its sentences that nobody is asked to type."""
    return CODE.findall(IN_BRACKETS.sub("", KEYS.sub("", text)))


@pytest.fixture(scope="module")
def record():
    return thinned(read_record("hidden_effect"), 600)


def test_a_name_in_brackets_and_a_row_of_a_table_are_to_be_typed():
    old = "exponential_law leaves 6.34 N rms. Missing: pressure_friction:contact_area."
    assert codes(old) == ["exponential_law", "pressure_friction"]
    assert not codes("Missing: friction (pressure_friction).\n  pressure_friction:free  98 %")


@pytest.mark.long
@pytest.mark.parametrize("law", ["exponential_law", "modified_chou_hannaford"])
def test_a_diagnosis_has_none_outside_of_brackets(record, law):
    some = ("pressure_friction", "coulomb_friction", "bladder_elasticity", "end_taper", "wall_thickness")
    found = diagnose(Model.build(law), record, only=some)
    assert named(found.labels[0]) in found.sentence
    assert not codes("\n".join(describe(found)))


def test_no_sentence_on_any_effect_has_one(record):
    base = fit(Model.build("exponential_law"), record)
    for name, other in zip(catalogue(), [*list(catalogue())[1:], "creep"], strict=True):
        said = sentence(base, base, [f"{name}:free"], 0.7, [(name, other)], None, 2.0, True, ())
        said += reservations({name: 0.2}, {name: (0.8, "It explains little.")}, ())
        assert "Probably missing" in said
        assert not codes(said) and said.count(f"({name}:free)") == said.count(f"({other})") == 1


@pytest.mark.parametrize("name", catalogue())
def test_the_words_of_an_effect_begin_as_in_a_sentence_and_hold_no_code(name):
    words, proper = in_words(name), ("Coulomb", "Stribeck", "Mullins")
    assert (words[0].islower() or words.startswith(proper)) and "_" not in words
    assert named(f"{name}:a_form") == f"{words} ({name}:a_form)"
    assert in_words("nobody_knows_it") == named("nobody_knows_it") == "nobody_knows_it"


def test_steps_tell_what_came_and_what_went():
    models = [Model("sarosi"), Model("sarosi", ["creep", "coulomb_friction"]), Model("sarosi", ["creep"])]
    assert steps(models) == (
        "six-parameter law of Sárosi",
        "+ creep and stress relaxation\n+ Coulomb friction",
        "− Coulomb friction",
    )
    assert steps(models[:2], named)[1].splitlines()[0] == "+ creep and stress relaxation (creep)"


def test_a_parameter_at_its_bound_is_one_of_an_effect_in_words():
    threads = ("bladder_elasticity:yeoh", "length_offset", "braid_extensibility:power")
    (told,) = fit(Model.build("chou_hannaford", threads), read_record("dmsp20_300")).at_bounds
    assert told == "q = 1.3 of extensible threads stands at its bound: the data pull it further"
