"""Static laws, each against figures worked out by hand."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from pam_ident.core import Specimen, UsageError
from pam_ident.fitting import fit
from pam_ident.laws import catalogue, get_law
from pam_ident.model import Model
from pam_ident.records import build_record

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)


def force(name, p, e, specimen=MUSCLE, **values):
    law = get_law(name)
    given = {param.name: param.start for param in law.params} | values
    return law.force(np.atleast_1d(float(p)), np.atleast_1d(float(e)), specimen, given)[0]


def test_the_laws_of_the_contract_are_there():
    assert {"chou_hannaford", "modified_chou_hannaford", "exponential_law", "sarosi"} <= set(catalogue())


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


def test_the_exponential_law_follows_a_braid_that_makes_a_parabola():
    """With a rate of 3 it leaves three times as much, a curve over the contraction that looked like tapered ends."""
    e, p = (one.ravel() for one in np.meshgrid(np.linspace(0.0, 0.25, 26), (0.1, 0.2, 0.3, 0.4, 0.5)))
    record = build_record("ideal", MUSCLE, p, e, MUSCLE.ideal_force(p, e))
    assert fit(Model.build("exponential_law"), record).rmse < 2e-4 * record.force.max()


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


def test_the_polynomial_with_figures_worked_out_by_hand():
    """0.4·(2000 − 700 + 30) + 10 − 40 + 3 − 2 = 503 N at ε = 0.1."""
    values = {"a0": 2000, "a1": -7000, "a2": 3000, "b0": 10, "b1": -400, "b2": 300, "b3": -2000}
    assert force("polynomial", 0.4, 0.1, **values) == pytest.approx(503.0, rel=1e-12)


@pytest.mark.parametrize(
    ("e", "newton"),
    [
        # 0.4·(2000 − 56 + 0.064) − (5 − 3.2 + 0.0064 + 200·0.04), since 0.008^(2/3) = 0.04
        (0.008, 767.8192),
        # 0.4·(2000 + 56 + 0.064) − (5 + 3.2 + 0.0064 − 200·0.04): a stretched membrane pulls
        (-0.008, 822.2192),
    ],
)
def test_hildebrandts_law_with_figures_worked_out_by_hand(e, newton):
    values = {"a0": 2000, "a1": -7000, "a2": 1000, "b0": 5, "b1": -400, "b2": 100, "b3": 200}
    assert force("hildebrandt", 0.4, e, **values) == pytest.approx(newton, rel=1e-12)


def test_the_spring_law_with_figures_worked_out_by_hand():
    """40 mm of stretch at 0.5 MPa: K = 8·0.25 + 0.1·0.5·40 + 0.001·1600 + 2 = 7.6 N/mm, 304 N."""
    values = {"c0": 2.0, "c1": 1e-3, "c2": 0.1, "c3": 8.0, "e_free": 0.3}
    assert force("wickramatunge_leephakpreeda", 0.5, 0.1, **values) == pytest.approx(304.0, rel=1e-12)
    assert force("wickramatunge_leephakpreeda", 0.5, 0.3, **values) == 0.0


def test_the_braid_in_rubber_with_figures_worked_out_by_hand():
    """At 30 degrees and ε = 0.1: 9·0.81 − 4 = 3.29 and r/r0 = √(4 − 3·0.81) = 1.2529964.

    300·0.3·3.29 − 100·9·0.9·(1 − 1/1.2529964) − (10 + 500·0.1 + 1000·0.01) = 296.1 − 163.5496 − 70 N.
    """
    values = {"A": 300.0, "H": 100.0, "X0": 10.0, "X1": 500.0, "X2": 1000.0, "theta": 30.0}
    assert force("martens_boblan", 0.3, 0.1, **values) == pytest.approx(62.5504, abs=1e-4)


def test_the_braid_in_rubber_without_rubber_is_the_ideal_law_and_its_hoop_the_known_figure():
    """π r0² for A; E = 1 MPa, t = 2 mm, r0 = 10 mm at 25 degrees and ε = 0.2: 178.6 N against the pull."""
    bare = {"A": math.pi * 100.0, "H": 0.0, "X0": 0.0, "X1": 0.0, "X2": 0.0, "theta": 25.4}
    for e in (0.0, 0.15):
        assert force("martens_boblan", 0.4, e, **bare) == pytest.approx(force("chou_hannaford", 0.4, e), rel=1e-12)
    hoop = bare | {"H": 2.0 * math.pi / 3.0 * 10.0 * 2.0 * 1.0, "theta": 25.0}
    assert force("martens_boblan", 0.0, 0.2, **hoop) == pytest.approx(-178.6, abs=0.05)


def test_conical_ends_cost_the_virtual_work_of_the_volume_they_lack():
    """The volume by quadrature of the outline; cones of the length m (r − r0) at both ends of the braid."""
    theta0, length, radius, m = math.radians(25.4), 200.0, 10.0, 1.7
    thread = length / math.cos(theta0)
    turns = thread * math.sin(theta0) / (2.0 * math.pi * radius)

    def volume(x):
        r = math.sqrt(thread**2 - x**2) / (2.0 * math.pi * turns)
        end = m * (r - radius)
        cone, _ = quad(lambda s: math.pi * (radius + s / m) ** 2, 0.0, end, epsabs=1e-9)
        return 2.0 * cone + math.pi * r**2 * (x - 2.0 * end)

    for e in (0.0, 0.07, 0.2):
        x = length * (1.0 - e)
        slope = (volume(x + 1e-3) - volume(x - 1e-3)) / 2e-3
        assert force("tsagarakis_caldwell", 0.4, e, m=m) == pytest.approx(-0.4 * slope, rel=1e-7)


def test_the_bladder_between_conical_ends_is_the_known_figure():
    """E t = 2 N/mm, r0 = 10 mm, 25 degrees, ε = 0.2: 178.6 N against the pull."""
    specimen = Specimen("m", 200.0, 10.0, 25.0)
    assert force("tsagarakis_caldwell", 0.0, 0.2, specimen, H=2.0) == pytest.approx(-178.6, abs=0.05)
