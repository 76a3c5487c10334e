"""What every effect in the catalogue promises, form by form. A new file in effects/ is tested here unnamed.

Recovery from data that the same model generated shows that the fit can find its own parameters. It is a test of
self-consistency and no proof that the formula is right; formulas are held against independent figures in
test_physics.py.
"""

import re
from dataclasses import replace
from itertools import islice, product

import numpy as np
import pytest

from pam_ident.effects import catalogue
from pam_ident.fitting import fit
from pam_ident.fitting.solve import jacobian
from pam_ident.laws import get_law
from pam_ident.model import Model, Term

FORMS = [(effect, form) for effect in catalogue().values() for form in effect.forms]
EACH_FORM = pytest.mark.parametrize(("effect", "form"), FORMS, ids=[f"{e.name}:{f.name}" for e, f in FORMS])
EACH_EFFECT = pytest.mark.parametrize("effect", catalogue().values(), ids=catalogue())
UNITS = {"1", "N", "kN", "MPa", "mm", "s", "m", "min", "K", "deg"}
NEEDS = {"branch", "motion", "time", "cycle", "temperature"}
LEVERS = {"speed", "pressure", "hold", "reversal", "temperature", "cycles"}
LAW_VALUES = {"a0": -190.0, "a1": 2400.0, "b0": 1600.0, "b1": 5500.0, "c0": -9.0, "c1": 650.0, "mu": 40.0}


def model_of(effect, form, law="chou_hannaford"):
    return Model(get_law(law), (Term(effect, form),))


def plausible(effect, form, share=1.0):
    """Parameter values by qualified name: sizes a typical magnitude off neutral, shapes a little off their start."""
    values = {}
    for k, p in enumerate(form.sizes):
        values[f"{effect.name}.{p.name}"] = p.clip(p.neutral + share * p.scale * (1.0, 0.7, 0.4)[k % 3])
    for p in form.shapes:
        values[f"{effect.name}.{p.name}"] = p.clip(1.15 * p.start if p.start else 0.1 * p.scale)
    return values


def corners(form, most=64):
    ends = [
        [x if np.isfinite(x) else np.sign(x) * 1e3 * p.scale for x in (p.lower, p.start, p.upper)] for p in form.shapes
    ]
    return [dict(zip([p.name for p in form.shapes], c, strict=True)) for c in islice(product(*ends), most)]


@EACH_FORM
def test_columns_are_finite_at_the_corners_of_the_shapes(effect, form, record):
    inputs = record.inputs
    force = get_law("exponential_law").force(inputs.pressure, inputs.contraction, inputs.specimen, LAW_VALUES)
    for corner in corners(form):
        columns = form.columns(inputs, corner, force)
        assert columns.shape == (len(inputs), len(form.sizes))
        assert np.isfinite(columns).all(), corner


@EACH_FORM
def test_columns_survive_the_edges_of_a_record(effect, form, record):
    """No pressure, vacuum, stretched muscle, a wall that is not given, a single sample."""
    inputs = record.inputs
    odd = replace(
        inputs,
        pressure=np.linspace(-0.02, 1.0, len(inputs)),
        contraction=np.linspace(-0.05, 0.34, len(inputs)),
        specimen=replace(inputs.specimen, wall_thickness_mm=None),
    )
    fields = ("pressure", "contraction", "direction", "time", "velocity", "stroke_speed", "moving", "cycle")
    one = replace(inputs, **{k: getattr(inputs, k)[:1] for k in (*fields, "temperature", "segment")})
    shape = {p.name: p.start for p in form.shapes}
    assert np.isfinite(form.columns(odd, shape, np.full(len(odd), 500.0))).all()
    assert form.columns(one, shape, np.full(1, 500.0)).shape == (1, len(form.sizes))


@EACH_FORM
def test_the_model_is_finite_at_plausible_sizes_and_at_the_corners_of_the_bounds(effect, form, record):
    model = model_of(effect, form)
    assert np.isfinite(model.force(record.inputs, plausible(effect, form))).all()
    ends = [[x if np.isfinite(x) else np.sign(x) * 1e3 * p.scale for x in (p.lower, p.upper)] for p in form.params]
    for corner in islice(product(*ends), 32):
        values = {f"{effect.name}.{p.name}": x for p, x in zip(form.params, corner, strict=True)}
        assert np.isfinite(model.force(record.inputs, values)).all(), values


@EACH_FORM
@pytest.mark.parametrize("law", ["chou_hannaford", "exponential_law"])
def test_a_neutral_size_is_the_law_alone(effect, form, law, record):
    """For every shape, and where a pressure sensor reads a little below zero."""
    lowest = record.inputs.pressure - record.inputs.pressure.min() - 0.002
    for inputs in (record.inputs, replace(record.inputs, pressure=lowest)):
        base = get_law(law)
        given = LAW_VALUES if base.params else {}
        alone = base.force(inputs.pressure, inputs.contraction, inputs.specimen, given)
        for corner in corners(form, most=9):
            values = dict(given) | {f"{effect.name}.{k}": v for k, v in corner.items()}
            values |= {f"{effect.name}.{p.name}": p.neutral for p in form.sizes}
            with_effect = model_of(effect, form, law).force(inputs, values)
            np.testing.assert_allclose(with_effect, alone, rtol=1e-12, atol=1e-10)


@EACH_FORM
def test_the_start_of_a_fit_is_neutral(effect, form, record):
    start = model_of(effect, form).neutral(record.inputs)
    assert all(start[f"{effect.name}.{p.name}"] == p.neutral for p in form.sizes)
    assert all(p.lower <= p.neutral <= p.upper for p in form.sizes)
    assert all(p.lower <= x <= p.upper for p in form.shapes for x in p.grid)


@EACH_FORM
def test_a_plausible_size_changes_the_force_where_the_record_excites_it(effect, form, record):
    alone = get_law("chou_hannaford").force(
        record.inputs.pressure, record.inputs.contraction, record.inputs.specimen, {}
    )
    change = model_of(effect, form).force(record.inputs, plausible(effect, form)) - alone
    assert 0.02 < np.sqrt(np.mean(change**2)) < 5e3


@EACH_FORM
def test_the_jacobian_is_that_of_finite_differences(effect, form, record):
    """Richardson's extrapolation of central differences, with steps of another size than the program's."""
    model = model_of(effect, form, "exponential_law")
    values = LAW_VALUES | plausible(effect, form)
    inputs = record.inputs
    force = model.force(inputs, values)
    matrix = jacobian(model, inputs, values, force)
    assert matrix.shape == (len(inputs), len(model.params))
    for column, p in zip(matrix.T, model.params, strict=True):
        step = 2e-4 * max(abs(values[p.name]), 1e-2 * p.scale if p.scale != 1.0 else 1e-2)

        def slope(h, name=p.name):
            up, down = (model.force(inputs, values | {name: values[name] + s}) for s in (h, -h))
            return (up - down) / (2.0 * h)

        expected = (4.0 * slope(step / 2.0) - slope(step)) / 3.0
        scale = np.abs(expected).max() + 1e-9
        off = np.abs(column - expected) / scale
        kinks = 0.01 if effect.stateful else 0.002  # a slipping element or a clipped pressure has a few
        assert np.mean(off > 2e-4) <= kinks, p.name


@EACH_FORM
def test_a_model_that_depends_on_its_own_force_solves_for_it(effect, form, record):
    if not form.uses_force:
        return
    for share in (0.3, 1.0, 3.0):
        model = model_of(effect, form, "exponential_law")
        values = LAW_VALUES | plausible(effect, form, share)
        force = model.force(record.inputs, values)
        columns, fixed = model.design(record.inputs, values, force)
        again = fixed + columns @ [values[p.name] for p in model.linear]
        np.testing.assert_allclose(again, force, atol=1e-6)


@EACH_FORM
def test_a_fit_finds_the_size_that_made_clean_data(effect, form, record):
    """Self-consistency on the ideal law, from the start values every fit has."""
    model = model_of(effect, form)
    truth = plausible(effect, form)
    made = replace(record, force=model.force(record.inputs, truth))
    found = fit(model, made)
    span = np.sqrt(np.mean((made.force - get_law("chou_hannaford").force(*_state(record), {})) ** 2))
    assert found.converged, found.message
    assert found.rmse < 1e-3 * span
    for estimate in found.estimates:
        if estimate.identified:
            assert estimate.value == pytest.approx(truth[estimate.name], rel=0.02, abs=1e-9), estimate.name
    sizes = {f"{effect.name}.{p.name}" for p in form.sizes}
    assert all(e.identified for e in found.estimates if e.name in sizes)


def _state(record):
    return record.inputs.pressure, record.inputs.contraction, record.inputs.specimen


@EACH_FORM
def test_units_can_be_read(effect, form):
    for p in form.params:
        symbols = [s for s in re.split(r"[·/*()]", re.sub(r"⁻¹|\^\d", "", p.unit)) if s]
        assert symbols and set(symbols) <= UNITS, f"{p.name}: {p.unit!r}"


@EACH_FORM
def test_a_form_says_what_it_is(effect, form):
    assert form.name.isidentifier() and form.formula
    assert form.sizes, "without a size nothing can be added"
    names = [p.name for p in form.params]
    assert len(set(names)) == len(names) and all(name.isidentifier() for name in names)
    assert all(p.doc for p in form.params)


@EACH_EFFECT
def test_an_effect_names_itself_its_source_and_its_test(effect):
    assert effect.name.isidentifier() and effect.title and effect.source.strip() and effect.test.strip()
    assert set(effect.needs) <= NEEDS and effect.levers and set(effect.levers) <= LEVERS
    assert len({form.name for form in effect.forms}) == len(effect.forms)
    assert effect.special_case_of in {"", *catalogue()} - {effect.name}


@EACH_EFFECT
def test_an_effect_of_the_package_is_called_as_its_file(effect, root):
    home = root / "pam_ident" / "effects" / f"{effect.name}.py"
    assert home.is_file()
    assert "EFFECT = Effect(" in home.read_text(encoding="utf-8")


@EACH_EFFECT
def test_an_effect_asks_for_all_it_needs(effect, record):
    """With only what `needs` names, every form can be computed; without it, `missing` says what lacks."""
    keep = {
        "motion": ("velocity", "stroke_speed", "moving"),
        "time": ("time", "segment"),
        "cycle": ("cycle",),
        "temperature": ("temperature",),
    }
    bare = replace(record.inputs, **dict.fromkeys((f for fields in keep.values() for f in fields), None))
    bare = replace(bare, direction=np.zeros(len(bare)))
    assert effect.missing(bare) == list(effect.needs)
    given = {f: getattr(record.inputs, f) for need in effect.needs if need != "branch" for f in keep[need]}
    if "branch" in effect.needs:
        given["direction"] = record.inputs.direction
    enough = replace(bare, **given)
    assert effect.missing(enough) == []
    for form in effect.forms:
        columns = form.columns(enough, {p.name: p.start for p in form.shapes}, np.full(len(enough), 300.0))
        assert np.isfinite(columns).all()


def test_the_effects_of_the_contract_are_there():
    wanted = (
        "coulomb_friction stribeck_friction pressure_friction viscous_damping presliding_hysteresis bladder_elasticity "
        "wall_thickness end_taper threshold_pressure length_offset series_compliance braid_extensibility force_bias "
        "force_drift pressure_lag creep mullins_softening thermal_softening bladder_elasticity_printed"
    )
    assert set(wanted.split()) <= set(catalogue())


def test_a_printed_formula_is_offered_with_a_warning_and_never_as_a_suspect():
    printed = catalogue()["bladder_elasticity_printed"]
    assert not printed.candidate and "bladder_elasticity" in printed.warning
