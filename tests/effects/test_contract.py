"""What every effect in the catalogue promises, form by form. A new file in effects/ is tested here unnamed.

The promises are those of `pam-ident effects check`; that they notice what is broken is tested in test_own_effect.py.
Formulas are held against independent figures in test_physics.py.
"""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.effects import catalogue
from pam_ident.validation.effect_contract import EFFECT_CHECKS, FORM_CHECKS, pieces_make_the_whole, showing

FORMS = [(effect, form) for effect in catalogue().values() for form in effect.forms]


@pytest.mark.parametrize(("effect", "form"), FORMS, ids=[f"{e.name}:{f.name}" for e, f in FORMS])
def test_a_form_keeps_its_promises(effect, form, record):
    shown = showing(record, form)
    assert {check.__name__: wrong for check in FORM_CHECKS if (wrong := check(effect, form, shown))} == {}


@pytest.mark.parametrize("effect", catalogue().values(), ids=catalogue())
def test_an_effect_keeps_its_promises(effect, record):
    assert {check.__name__: wrong for check in EFFECT_CHECKS if (wrong := check(effect, record))} == {}


@pytest.mark.parametrize("effect", catalogue().values(), ids=catalogue())
def test_an_effect_of_the_package_is_called_as_its_file(effect, root):
    home = root / "pam_ident" / "effects" / f"{effect.name}.py"
    assert home.is_file()
    assert "EFFECT = Effect(" in home.read_text(encoding="utf-8")


def test_the_effects_of_the_contract_are_there():
    wanted = (
        "coulomb_friction stribeck_friction pressure_friction viscous_damping presliding_hysteresis bladder_elasticity "
        "wall_thickness end_taper threshold_pressure length_offset series_compliance braid_extensibility force_bias "
        "force_drift pressure_lag creep mullins_softening thermal_softening bladder_elasticity_printed"
    )
    assert set(wanted.split()) <= set(catalogue())


def test_a_printed_formula_is_offered_with_a_warning_and_never_as_a_candidate():
    printed = catalogue()["bladder_elasticity_printed"]
    assert not printed.candidate and "bladder_elasticity" in printed.warning


@pytest.mark.parametrize(
    ("effect", "form"), [pytest.param(e, f, id=f"{e.name}:{f.name}") for e, f in FORMS if f.remembers]
)
def test_a_form_that_says_it_remembers_does(effect, form, record):
    """Or it would be kept from records that are read in chunks for nothing."""
    assert pieces_make_the_whole(effect, replace(form, remembers=False), record) != []


@pytest.mark.parametrize(
    ("effect", "form"), [pytest.param(e, f, id=f"{e.name}:{f.name}") for e, f in FORMS if f.same_as]
)
def test_a_form_that_is_another_effect_s_too_says_the_same(effect, form, record):
    values = {p.name: p.start for p in form.nonlinear}
    own = form.columns(record.inputs, values, record.force)
    theirs = [
        other.columns(record.inputs, values, record.force)
        for other in catalogue()[form.same_as].forms
        if {p.name for p in other.nonlinear} <= set(values)
    ]
    if not form.free:
        assert any(one.shape == own.shape and np.allclose(one, own, rtol=0.0, atol=1e-12) for one in theirs)
        return
    left = [one - own @ np.linalg.lstsq(own, one)[0] for one in theirs]
    assert min(np.linalg.norm(a) / np.linalg.norm(b) for a, b in zip(left, theirs, strict=True)) < 0.05
