"""The functions and classes that a user meets first have an example each, and it says what the program answers."""

import doctest
from importlib import import_module

import pytest

import pam_ident

NO_VERBS = ("pam_ident.core.errors.", "pam_ident.api.catalogue.laws", "pam_ident.api.catalogue.effects")
FIRST = [
    *(path for path in pam_ident._HOME.values() if not path.startswith(NO_VERBS)),
    "pam_ident.api.catalogue.Catalogue",
    *(path for path, _ in pam_ident._OLD.values()),
    "pam_ident.fitting.fit",
    "pam_ident.diagnosis.compare",
    "pam_ident.diagnosis.diagnose",
    "pam_ident.tasks.law_choice.choose_law",
    "pam_ident.laws.catalogue",
    "pam_ident.laws.get_law",
    "pam_ident.effects.catalogue",
    "pam_ident.effects.get_effect",
    "pam_ident.effects.load_effect_file",
    "pam_ident.model.Model.build",
    "pam_ident.fitting.Fit",
    "pam_ident.fitting.lack_of_fit",
    "pam_ident.fitting.repeat_noise",
    "pam_ident.records.datasets.dataset_record",
    "pam_ident.tasks.setup.Setup",
    "pam_ident.tasks.fit.fit_record",
    pytest.param("pam_ident.tasks.ladder.climb_ladder", marks=pytest.mark.long),  # as pam.ladder
    "pam_ident.tasks.diagnose.diagnose_record",
    pytest.param("pam_ident.tasks.report.report_record", marks=pytest.mark.long),  # as pam.report
    "pam_ident.batch.run.run_batch",
]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def named(path):
    """A function or class by its dotted name."""
    home, _, name = path.rpartition(".")
    return getattr(named(home), name) if home.rpartition(".")[2][:1].isupper() else getattr(import_module(home), name)


@pytest.mark.parametrize("path", FIRST)
def test_its_example_is_true(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    thing = named(path)
    found = doctest.DocTestParser().get_doctest(thing.__doc__ or "", {}, path, None, None)
    assert found.examples, f"{path} has no example"
    assert any(one.want for one in found.examples), f"{path}: its example shows no answer"
    said = []
    doctest.DocTestRunner(optionflags=FLAGS).run(found, out=said.append)
    assert not said, "".join(said)


def test_an_example_that_is_not_true_is_found():
    said = []
    wrong = doctest.DocTestParser().get_doctest(">>> 1 + 1\n3\n", {}, "wrong", None, None)
    doctest.DocTestRunner(optionflags=FLAGS).run(wrong, out=said.append)
    assert said
