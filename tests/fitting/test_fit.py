"""A fit gives the parameters of the data, true errors, and says what the data do not determine."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit, lsq_linear

from pam_ident.core import DataError, FitError, Inputs, Param, Specimen
from pam_ident.fitting import fit, fit_branches, fit_isobars, loop_energies
from pam_ident.fitting.problem import within_bounds
from pam_ident.fitting.solve import whole
from pam_ident.model import Model
from pam_ident.records import build_record, read_record
from pam_ident.records.datasets import dataset_record

PAPER = {
    "contraction": {"a0": -197.8, "a1": 2442.0, "b0": 1735.0, "b1": 5464.0, "c0": -9.3, "c1": 688.3, "mu": 45.0},
    "extension": {"a0": -344.5, "a1": 2554.0, "b0": -43.2, "b1": 8430.0, "c0": 43.24, "c1": 899.2, "mu": 45.0},
}
SPECIMEN = Specimen("bench", 200.0, 10.0, 25.4, 1.5)


def table(force, seed=1, sigma=0.0, pressures=(0.1, 0.2, 0.3, 0.4, 0.5)):
    """A static table of a force function over a measured grid, with white noise."""
    e, p = (v.ravel() for v in np.meshgrid(np.linspace(0.0, 0.2, 60), pressures))
    noise = sigma * np.random.default_rng(seed).standard_normal(len(e))
    return build_record("bench", SPECIMEN, p, e, force(p, e) + noise)


def chou(p, e, k0, k1, k2):
    theta = math.radians(25.4)
    a, b = 3.0 / math.tan(theta) ** 2, 1.0 / math.sin(theta) ** 2
    return k0 * math.pi * 100.0 * p * (a * (1.0 - k1 * e) ** 2 - b) + k2


@pytest.mark.parametrize("branch", ["contraction", "extension"])
def test_the_laws_of_the_paper_come_back_from_their_curves_to_six_digits(branch):
    record = read_record(dataset_record("paper_laws"))
    values = fit_branches(Model.build("exponential_law"), record, "separate")[branch].values
    for name, truth in PAPER[branch].items():
        assert values[name] == pytest.approx(truth, rel=1e-6)


def test_the_printed_pair_of_laws_gives_energy_back_on_every_isobar():
    record = read_record(dataset_record("paper_laws"))
    energies = loop_energies(record, record.force)
    assert len(energies) == 5 and all(e < 0.0 for e in energies.values())


def test_values_and_errors_agree_with_an_independent_least_squares():
    record = table(lambda p, e: chou(p, e, 0.93, 1.2, 17.0), sigma=3.0)
    ours = fit(Model.build("modified_chou_hannaford"), record)
    x = np.array([record.inputs.pressure, record.inputs.contraction])
    popt, pcov = curve_fit(lambda v, a, b, c: chou(*v, a, b, c), x, record.force, p0=[1.0, 1.0, 0.0])
    for name, value, error in zip(("k0", "k1", "k2"), popt, np.sqrt(np.diag(pcov)), strict=True):
        mine = next(e for e in ours.estimates if e.name == name)
        assert mine.value == pytest.approx(value, rel=1e-5)
        assert mine.stderr == pytest.approx(error, rel=1e-3)
    assert ours.valid and ours.rmse == pytest.approx(3.0, rel=0.1)


def test_bounded_least_squares_agrees_with_scipy():
    rng = np.random.default_rng(7)
    params = [
        Param(f"p{k}", "1", "", lower=low, upper=high) for k, (low, high) in enumerate([(0, 9), (-1, 0.5), (-9, 9)])
    ]
    hit = 0
    for _ in range(40):
        matrix, goal = rng.standard_normal((30, 3)), 3.0 * rng.standard_normal(30)
        bounds = ([p.lower for p in params], [p.upper for p in params])
        expected = lsq_linear(matrix, goal, bounds, tol=1e-14).x
        hit += bool(np.any(np.abs(expected) < 1e-12))
        triangle = np.linalg.qr(np.column_stack([matrix, goal]), mode="r")
        np.testing.assert_allclose(within_bounds(triangle, *map(np.array, bounds)), expected, atol=1e-6)
    assert hit > 5


def test_what_one_pressure_does_not_tell_is_held_at_0():
    record = table(lambda p, e: 1000.0 * p - 500.0 * e + 40.0 * np.exp(-45.0 * e), pressures=(0.3,))
    one = fit(Model.build("exponential_law"), record)
    assert one.held == {"a0": 0.0, "b0": 0.0, "c0": 0.0} and one.rmse < 1e-6 and one.valid
    assert one.values["a1"] == pytest.approx(1000.0) and one.values["mu"] == pytest.approx(45.0)
    several = table(lambda p, e: 1000.0 * p - 500.0 * e + 40.0 * np.exp(-45.0 * e))
    here = fit(Model.build("exponential_law"), several, several.level == several.levels[0])
    assert set(here.held) == {"a0", "b0", "c0"} and here.rmse < 1e-6
    assert not fit(Model.build("exponential_law"), several).held
    slack = table(lambda p, e: -500.0 * e, pressures=(0.0,))
    assert fit(Model.build("polynomial"), slack).values["a1"] == 0.0, "no pressure tells nothing of what grows with it"


def test_fewer_samples_than_parameters_is_refused():
    record = table(lambda p, e: chou(p, e, 1.0, 1.0, 0.0))
    rows = np.zeros(len(record), bool)
    rows[:3] = True
    with pytest.raises(FitError, match="3 samples for 3 parameters"):
        fit(Model.build("modified_chou_hannaford"), record, rows)


def test_two_constants_are_not_identified_and_carry_no_error():
    record = table(lambda p, e: chou(p, e, 1.0, 1.1, 5.0), sigma=1.0)
    doubtful = fit(Model.build("modified_chou_hannaford", ("force_bias",)), record)
    marks = {e.name: (e.identified, math.isnan(e.stderr)) for e in doubtful.estimates}
    assert marks["k2"] == marks["force_bias.F_b"] == (False, True)
    assert marks["k0"] == marks["k1"] == (True, False)
    assert not doubtful.valid and "k2" in doubtful.problems[0]


def test_an_effect_without_its_column_is_refused():
    record = table(lambda p, e: chou(p, e, 1.0, 1.1, 5.0))
    with pytest.raises(DataError, match="thermal_softening needs temperature"):
        fit(Model.build("modified_chou_hannaford", ("thermal_softening",)), record)


def test_free_geometry_is_found_and_counted():
    truth = replace(SPECIMEN, initial_radius_mm=10.8, braid_angle_deg=27.0)
    factor = math.pi * truth.initial_radius_mm**2
    record = table(lambda p, e: factor * p * (truth.a * (1.0 - e) ** 2 - truth.b), sigma=0.5)
    found = fit(Model.build("chou_hannaford", free_geometry=True), record)
    assert [e.name for e in found.estimates] == ["r0", "theta0"]
    assert found.values["r0"] == pytest.approx(10.8, abs=0.05)
    assert found.values["theta0"] == pytest.approx(27.0, abs=0.1)


def test_a_radius_that_wants_to_leave_its_bounds_is_marked():
    factor = math.pi * 13.0**2
    record = table(lambda p, e: factor * p * (SPECIMEN.a * (1.0 - e) ** 2 - SPECIMEN.b), sigma=0.5)
    marks = {e.name: e.at_bound for e in fit(Model.build("chou_hannaford", free_geometry=True), record).estimates}
    assert marks == {"r0": True, "theta0": False}


def test_series_compliance_is_solved_for_the_force():
    record = table(lambda p, e: chou(p, e, 1.0, 1.1, 5.0))
    model = Model.build("modified_chou_hannaford", ("series_compliance",))
    values = {"k0": 1.0, "k1": 1.1, "k2": 5.0, "series_compliance.compliance": 8.0}
    force = model.force(record.inputs, values)
    moved = record.inputs.contraction + 8.0e-3 * force / 200.0
    np.testing.assert_allclose(force, chou(record.inputs.pressure, moved, 1.0, 1.1, 5.0), rtol=1e-8, atol=1e-6)
    for near in (0.9 * force, force + 50.0):
        np.testing.assert_allclose(model.force(record.inputs, values, near), force, rtol=1e-9, atol=1e-8)


@pytest.mark.parametrize("form", ["textbook", "stiffening", "free"])
def test_slopes_of_a_force_that_acts_back_on_itself_are_those_by_differences(form):
    hidden = Model.build("exponential_law", (f"series_compliance:{form}",))
    record = table(lambda p, e: 400.0 + 2500.0 * p - (900.0 + 5500.0 * p) * e)
    size = {p.name: 3.0 if p.unit == "mm/kN" else p.start for p in hidden.nonlinear}
    values = {**PAPER["contraction"], **size}
    problem = whole(hidden, record.inputs, record.force, values)
    by_differences = replace(problem, slopes=None).jacobian(values)
    unit = np.abs(by_differences).max(axis=0)
    np.testing.assert_allclose(problem.jacobian(values) / unit, by_differences / unit, atol=1e-6)


def test_series_compliance_is_recovered():
    hidden = Model.build("modified_chou_hannaford", ("series_compliance",))
    values = {"k0": 1.0, "k1": 1.1, "k2": 5.0, "series_compliance.compliance": 8.0}
    clean = table(lambda p, e: chou(p, e, 1.0, 1.1, 5.0))
    noise = np.random.default_rng(3).standard_normal(len(clean))
    record = replace(clean, force=hidden.force(clean.inputs, values) + noise)
    found = fit(hidden, record)
    error = next(e.stderr for e in found.estimates if e.name.endswith("compliance"))
    assert abs(found.values["series_compliance.compliance"] - 8.0) < 4.0 * error
    assert found.rmse == pytest.approx(1.0, rel=0.12)


def test_what_grows_with_pressure_is_not_told_from_what_does_not_on_one_isobar():
    """The pressure sensor's noise is no other pressure."""
    record = read_record(dataset_record("hidden_effect"))
    rows = fit_isobars(Model.build("hildebrandt"), record, ("together",)).rows
    assert len(rows) == 5
    for row in rows:
        assert [e.name for e in row.estimates if e.identified] == ["b3"]
        assert not any(math.isfinite(e.stderr) for e in row.estimates if e.name != "b3")


def test_two_stage_is_a_line_through_the_isobars():
    record = table(lambda p, e: (90 + 2000 * p) - (800 + 4000 * p) * e + (10 + 500 * p) * np.exp(-45 * e), sigma=1.0)
    tables = fit_isobars(Model.build("exponential_law"), record, ("together",), {"mu": 45.0})
    levels, a = [], []
    for level in (0.1, 0.2, 0.3, 0.4, 0.5):
        here = record.level == level
        e = record.inputs.contraction[here]
        matrix = np.column_stack([np.ones_like(e), -e, np.exp(-45 * e)])
        levels.append(level)
        a.append(np.linalg.lstsq(matrix, record.force[here], rcond=None)[0][0])
    slope, intercept = np.polyfit(levels, a, 1)
    assert tables.two_stage["together"]["a1"] == pytest.approx(slope, rel=1e-6)
    assert tables.two_stage["together"]["a0"] == pytest.approx(intercept, rel=1e-5)
    assert tables.correlation["together"]["a"] == pytest.approx(np.corrcoef(levels, a)[0, 1], abs=1e-9)
    assert [row.pressure_MPa for row in tables.rows] == levels


def test_the_loop_of_a_friction_dissipates_twice_its_force_times_the_stroke():
    time = np.linspace(0.0, 40.0, 4001)
    x = 20.0 - 20.0 * np.cos(2.0 * np.pi * time / 20.0)
    friction = -15.0 * np.sign(np.sin(2.0 * np.pi * time / 20.0))
    record = build_record("loop", SPECIMEN, np.full(4001, 0.3), x / 200.0, 400.0 - 5.0 * x + friction, time=time)
    energy = loop_energies(record, record.force)[0.3]
    assert energy == pytest.approx(2.0 * 15.0 * 40.0e-3, rel=0.03)
    assert loop_energies(record, record.force - 2.0 * friction)[0.3] == pytest.approx(-energy, rel=0.03)


def test_a_pressure_below_zero_never_raises_the_force_by_an_effect_at_rest():
    inputs = Inputs(np.array([-0.002, 0.2]), np.array([0.1, 0.1]), SPECIMEN, np.zeros(2))
    plain, with_effect = Model.build("chou_hannaford"), Model.build("chou_hannaford", ("threshold_pressure",))
    np.testing.assert_array_equal(plain.force(inputs, {}), with_effect.force(inputs, {"threshold_pressure.p_th": 0.0}))
