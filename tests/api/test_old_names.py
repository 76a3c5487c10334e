"""The names of before go on for a version, and say what stands in their place."""

import importlib
import subprocess
import sys
import types

import pytest

import pam_ident as pam
from pam_ident.core import Specimen
from pam_ident.fitting import Fit
from pam_ident.records.datasets import dataset_record


@pytest.mark.parametrize("name", sorted(pam._OLD))
def test_an_old_name_is_what_it_was_and_names_the_new_one(name):
    path, _ = pam._OLD[name]
    home, _, found = path.rpartition(".")
    with pytest.warns(DeprecationWarning, match=rf"pam_ident\.{name} goes in the next version; take "):
        assert getattr(pam, name) is getattr(importlib.import_module(home), found)


def test_the_old_order_of_arguments_gives_the_old_answers():
    record = pam.read(dataset_record("dmsp20_300"))
    with pytest.warns(DeprecationWarning, match=r"pam\.fit\(record, law, effects\)"):
        one = pam.fit(pam.Model.build("martens_boblan"), record)
    assert isinstance(one, Fit) and one.values == pam.fit(record, "martens_boblan").fits["together"].values
    with pytest.warns(DeprecationWarning, match=r"pam\.compare\(record, law\)"):
        assert pam.compare(one).fit is one


def test_functions_of_the_catalogues_are_found_there():
    with pytest.warns(DeprecationWarning, match=r"from pam_ident\.laws import get_law"):
        assert pam.laws.get_law("sarosi") is pam.laws["sarosi"]
    with pytest.warns(DeprecationWarning, match=r"from pam_ident\.effects import load_effect_file"):
        assert callable(pam.effects.load_effect_file)


@pytest.mark.parametrize("name", ["report", "batch", "laws", "effects"])
def test_a_subpackage_of_the_same_name_does_not_take_its_place(name):
    module = importlib.import_module(f"pam_ident.{name}")
    assert isinstance(module, types.ModuleType) and getattr(pam, name) is not module


def test_importing_it_loads_nothing_heavy():
    code = (
        "import sys, pam_ident as pam; dir(pam)\n"
        "print([n for n in ('numpy', 'scipy', 'pandas', 'matplotlib', 'jinja2', 'rich') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.long
def test_a_fit_draws_nothing_and_so_loads_no_figures():
    code = (
        "import sys, pam_ident as pam; print(pam.fit('dmsp20_300', 'sarosi').params['value'].size)\n"
        "print([n for n in ('matplotlib', 'jax', 'lmfit') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["6", "[]"]


def test_a_specimen_is_checked():
    with pytest.raises(
        pam_error(), match="unknown key of a specimen 'initial_lenght_mm'; did you mean initial_length_mm"
    ):
        pam.read({"pressure_MPa": [0.1]}, specimen={"initial_lenght_mm": 1})
    assert pam.read("dmsp20_300", specimen=Specimen("other", 280.5, 10.0, 25.0)).specimen.name == "other"


def pam_error():
    from pam_ident.core import UsageError

    return UsageError
