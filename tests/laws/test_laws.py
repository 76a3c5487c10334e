"""Static laws: each against figures worked out by hand, and the contract every law keeps."""

import math

import numpy as np
import pytest

from pam_ident.core import Specimen, UsageError
from pam_ident.laws import Law, catalogue, get_law

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)
LAWS = sorted(catalogue())


def force(name, p, e, specimen=MUSCLE, **values):
    law = get_law(name)
    given = {param.name: param.start for param in law.params} | values
    return law.force(np.atleast_1d(float(p)), np.atleast_1d(float(e)), specimen, given)[0]


def test_the_laws_of_the_contract_are_there():
    assert {"chou_hannaford", "modified_chou_hannaford", "exponential_law", "sarosi"} <= set(LAWS)


def test_an_unknown_law_is_refused_with_the_known_ones():
    with pytest.raises(UsageError, match=r"'hooke'.*chou_hannaford.*sarosi"):
        get_law("hooke")


# --- figures -----------------------------------------------------------------------------------------------------


def test_the_ideal_law_at_rest_is_the_figure_worked_out_by_hand():
    """At 30 degrees a = 9 and b = 4; π · 10² mm² · 0.5 MPa · (9 − 4) = 785.398 N."""
    assert force("chou_hannaford", 0.5, 0.0, Specimen("m", 200.0, 10.0, 30.0)) == pytest.approx(785.3981634, rel=1e-9)


def test_the_ideal_law_at_a_tenth_is_the_figure_worked_out_by_hand():
    """9 · 0.81 − 4 = 3.29; π · 100 · 0.3 · 3.29 = 310.075 N."""
    assert force("chou_hannaford", 0.3, 0.1, Specimen("m", 200.0, 10.0, 30.0)) == pytest.approx(310.0751949, rel=1e-9)


def test_the_ideal_law_is_the_virtual_work_of_the_pressure():
    """F = −p dV/dL with V the cylinder of a braid of constant thread length."""
    theta0, length, radius = math.radians(25.4), 200.0, 10.0
    thread = length / math.cos(theta0)
    turns = thread * math.sin(theta0) / (2.0 * math.pi * radius)

    def volume(x):
        return math.pi * (thread**2 - x**2) / (2.0 * math.pi * turns) ** 2 * x

    for e in (0.0, 0.07, 0.2):
        x = length * (1.0 - e)
        slope = (volume(x + 1e-3) - volume(x - 1e-3)) / 2e-3
        assert force("chou_hannaford", 0.4, e) == pytest.approx(-0.4 * slope, rel=1e-7)


def test_the_ideal_law_ends_at_the_neutral_angle():
    """No force where the braid stands at 54.7356 degrees: 1 − ε = cos 54.7356° / cos θ0."""
    end = 1.0 - math.cos(math.atan(math.sqrt(2.0))) / math.cos(math.radians(25.4))
    assert force("chou_hannaford", 0.6, end) == pytest.approx(0.0, abs=1e-9)
    assert force("chou_hannaford", 0.6, end - 0.01) > 0.0 > force("chou_hannaford", 0.6, end + 0.01)


@pytest.mark.parametrize(
    ("p", "e", "newton"),
    [
        # 2442·0.5 − 197.8 + 688.3·0.5 − 9.3 = 1221 − 197.8 + 344.15 − 9.3
        (0.5, 0.0, 1358.05),
        # 244.2 − 197.8 + 68.83 − 9.3
        (0.1, 0.0, 105.93),
        # 732.6 − 197.8 − (1639.2 + 1735)·0.1 + (206.49 − 9.3)·e^−4.5, e^−4.5 = 0.0111089965
        (0.3, 0.1, 199.57058),
    ],
)
def test_the_exponential_law_with_the_printed_contraction_parameters(p, e, newton):
    values = {"a0": -197.8, "a1": 2442, "b0": 1735, "b1": 5464, "c0": -9.3, "c1": 688.3, "mu": 45}
    assert force("exponential_law", p, e, **values) == pytest.approx(newton, abs=2e-5)


@pytest.mark.parametrize(
    ("p", "e", "newton"),
    [
        # 1277 − 344.5 + 449.6 + 43.24
        (0.5, 0.0, 1425.34),
        # 766.2 − 344.5 − (2529 − 43.2)·0.1 + (269.76 + 43.24)·e^−4.5
        (0.3, 0.1, 176.59712),
    ],
)
def test_the_exponential_law_with_the_printed_extension_parameters(p, e, newton):
    values = {"a0": -344.5, "a1": 2554, "b0": -43.2, "b1": 8430, "c0": 43.24, "c1": 899.2, "mu": 45}
    assert force("exponential_law", p, e, **values) == pytest.approx(newton, abs=2e-5)


def test_the_modified_law_with_a_row_of_the_papers_table():
    """Table 1, 0.5 MPa: k0 = 1.01, k1 = 1.547, k2 = 120.2, on a braid of 30 degrees at ε = 0.1.

    1 − 0.1547 = 0.8453, squared 0.71453209; 9 · that − 4 = 2.43078881; · π · 100 · 0.5 · 1.01 + 120.2 = 505.8457 N.
    """
    specimen = Specimen("m", 200.0, 10.0, 30.0)
    answer = force("modified_chou_hannaford", 0.5, 0.1, specimen, k0=1.01, k1=1.547, k2=120.2)
    assert answer == pytest.approx(505.8457, abs=1e-4)


def test_the_modified_law_without_corrections_is_the_ideal_law():
    for e in (0.0, 0.15):
        assert force("modified_chou_hannaford", 0.4, e, k0=1.0, k1=1.0, k2=0.0) == force("chou_hannaford", 0.4, e)


@pytest.mark.parametrize(("bar", "percent"), [(6.0, 0.0), (3.0, 8.0), (1.0, 20.0)])
def test_sarosis_law_takes_his_printed_coefficients_by_the_stated_factors(bar, percent):
    a1, a2, a3, a4, a5, a6 = -4.00180705, 292.4620246, -0.32930845, -9.33564098, 294.0538256, -280.498151
    by_hand = (a1 * bar + a2) * math.exp(a3 * percent) + a4 * percent * bar + a5 * bar + a6
    values = {"s1": 10 * a1, "s2": a2, "s3": 100 * a3, "s4": 1000 * a4, "s5": 10 * a5, "s6": a6}
    assert force("sarosi", bar / 10.0, percent / 100.0, **values) == pytest.approx(by_hand, rel=1e-12)
    if percent == 0.0:
        assert by_hand == pytest.approx(1752.3, abs=0.1)


# --- the contract of every law -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LAWS)
def test_a_law_is_its_fixed_part_plus_columns_times_its_linear_parameters(name):
    law: Law = get_law(name)
    rng = np.random.default_rng(4)
    p, e = rng.uniform(0.05, 0.7, 30), rng.uniform(-0.03, 0.28, 30)
    values = {q.name: q.start for q in law.shape}
    values |= {q.name: q.clip(q.start + q.scale * rng.standard_normal()) for q in law.linear}
    columns, fixed = law.columns(p, e, MUSCLE, values), law.fixed(p, e, MUSCLE, values)
    assert columns.shape == (30, len(law.linear)) and fixed.shape == (30,)
    by_hand = fixed.copy()
    for k, q in enumerate(law.linear):
        by_hand += columns[:, k] * values[q.name]
    np.testing.assert_allclose(law.force(p, e, MUSCLE, values), by_hand, rtol=1e-12)
    for k, q in enumerate(law.linear):
        more = law.force(p, e, MUSCLE, values | {q.name: values[q.name] + 1.0}) - law.force(p, e, MUSCLE, values)
        np.testing.assert_allclose(more, columns[:, k], atol=1e-9 * (1.0 + np.abs(by_hand).max()))


@pytest.mark.parametrize("name", LAWS)
def test_a_law_is_finite_at_the_corners_of_its_shapes_and_of_the_working_range(name):
    law = get_law(name)
    p, e = (np.ravel(g) for g in np.meshgrid([0.0, 0.3, 1.0], [-0.05, 0.0, 0.15, 0.35]))
    corners = [{}]
    for q in law.shape:
        corners = [c | {q.name: value} for c in corners for value in (q.lower, q.start, q.upper)]
    for corner in corners:
        assert np.isfinite(law.columns(p, e, MUSCLE, corner)).all(), corner
        assert np.isfinite(law.fixed(p, e, MUSCLE, corner)).all(), corner


@pytest.mark.parametrize("name", LAWS)
def test_the_columns_of_a_law_are_told_apart_by_as_many_pressures_as_it_says(name):
    law = get_law(name)
    if not law.linear:
        return
    shape = {q.name: q.start for q in law.shape}

    def rank(levels):
        p, e = (np.ravel(g) for g in np.meshgrid(np.linspace(0.1, 0.6, levels), np.linspace(0.0, 0.25, 20)))
        columns = law.columns(p, e, MUSCLE, shape)
        return np.linalg.matrix_rank(columns / np.linalg.norm(columns, axis=0), tol=1e-8)

    assert rank(law.min_levels) == len(law.linear)
    assert law.min_levels == 1 or rank(law.min_levels - 1) < len(law.linear)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_names_itself_its_source_and_its_parameters(name):
    law = get_law(name)
    assert law.name == name and name.isidentifier()
    assert law.title and law.formula and law.source
    assert all(q.name.isidentifier() and q.unit and q.doc for q in law.params)
    assert len({q.name for q in law.params}) == len(law.params)
