"""The audit of the paper's figures, against formulas written out here and the figures it is known by."""

import math

import numpy as np
import pytest

from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record

P = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
R0, L0, ANGLE = 10.0, 200.0, math.radians(25.4)
A, B = 3.0 / math.tan(ANGLE) ** 2, 1.0 / math.sin(ANGLE) ** 2
STROKES = {0.1: 0.0074, 0.2: 0.1025, 0.3: 0.1585, 0.4: 0.1987, 0.5: 0.2235}


def law_4(p, e):
    return 2442 * p - 197.8 - (5464 * p + 1735) * e + (688.3 * p - 9.3) * np.exp(-45 * e)


def law_5(p, e):
    return 2554 * p - 344.5 - (8430 * p - 43.2) * e + (899.2 * p + 43.24) * np.exp(-45 * e)


def equation_1(p, e, k0, k1, k2):
    return k0 * math.pi * R0**2 * p * (A * (1 - k1 * e) ** 2 - B) + k2


@pytest.fixture(scope="module")
def audit(paper_audit):
    return paper_audit("audit").audit_paper()


def gap(audit, branch, pressure):
    return next(g for g in audit.gaps if (g.branch, g.pressure_MPa) == (branch, pressure))


def test_the_page_is_what_the_program_says_now(audit, paper_audit, root):
    page = paper_audit("page").audit_page(audit)
    assert (root / "docs" / "paper.md").read_text(encoding="utf-8") == page


def test_the_laws_on_file_are_those_of_the_reconstructed_record(audit):
    record = read_record(dataset_record("paper_laws"))
    assert audit.strokes == pytest.approx(STROKES)
    for branch, law in (("contraction", law_4), ("extension", law_5)):
        rows = record.branch_rows(branch)
        again = law(record.inputs.pressure[rows], record.inputs.contraction[rows])
        assert record.force[rows] == pytest.approx(again, abs=1e-9)
        at_rest = [g.law_rest for g in audit.gaps if g.branch == branch]
        assert at_rest == pytest.approx([law(p, 0.0) for p in P[::-1]])


def test_one_misprint_and_its_weight(audit):
    (one,) = audit.misprints
    assert (one.branch, one.coefficient, one.equations, one.values) == ("extension", "b1", ("5", "7"), (8430, 8403))
    assert one.force == pytest.approx(27 * 0.5 * 0.2235)


def test_the_printed_bladder_force_inflates_the_modulus(audit):
    assert audit.specimen.braid_angle_deg == 25.4
    for angle, bladder in [(25.4, audit.bladder), *((a.angle_deg, a.bladder) for a in audit.angles)]:
        for e, factor in bladder.inflation.items():
            assert factor == pytest.approx(1.0 / (0.2 * math.tan(math.radians(angle)) * (1.0 - e)), rel=1e-9)
        assert min(bladder.inflation.values()) < bladder.fitted < 1.01 * max(bladder.inflation.values())
    assert 11.0 < audit.bladder.fitted < 13.0


def test_the_bladder_s_force_and_its_tangent_at_rest(audit):
    at_25 = next(a.bladder for a in audit.angles if a.angle_deg == 25.0)
    assert at_25.force[0.2] == pytest.approx(178.6, abs=0.05)
    cot = 1.0 / math.tan(math.radians(25.0))
    for e, force in at_25.linear.items():
        assert force == pytest.approx(2 * math.pi * 1.0 * 2.0 * R0 * cot**4 * e, rel=1e-7)


def test_k2_alone_is_more_than_the_law_at_low_pressure(audit):
    low = gap(audit, "contraction", 0.1)
    assert low.law_rest == pytest.approx(106, abs=0.5) and low.k2 == pytest.approx(179, abs=0.5)
    assert {(g.branch, g.pressure_MPa) for g in audit.gaps if g.k2 > g.law_rest} == {
        ("contraction", 0.1),
        ("extension", 0.1),
    }


@pytest.mark.parametrize(
    ("branch", "pressure", "row", "law"),
    [
        ("contraction", 0.3, (0.7599, 3.1, 343.7), law_4),
        ("extension", 0.1, (0.761, 11.06, 203.2), law_5),
        ("extension", 0.5, (0.8466, 1.988, 300.2), law_5),
    ],
)
def test_tables_against_laws_over_the_stroke(audit, branch, pressure, row, law):
    found = gap(audit, branch, pressure)
    e = np.round(np.linspace(0.0, STROKES[pressure], 51), 6)
    off = equation_1(pressure, e, *row) - law(pressure, e)
    assert found.rms == pytest.approx(np.sqrt(np.mean(off**2)))
    assert found.largest == pytest.approx(off[np.argmax(np.abs(off))])
    stretch = 1.0 - 1.0 / np.sqrt((3 * B - A * (1 - e) ** 2) / 3)
    bladder = 2 * A / 3 * math.pi * R0 * 2.0 * (1 - e) * stretch
    assert found.rms_with[1.0] == pytest.approx(np.sqrt(np.mean((off - bladder) ** 2)))
    slope, *_ = np.linalg.lstsq(bladder[:, None], off, rcond=None)
    assert slope[0] > 0 and found.best_modulus == pytest.approx(slope[0])
    assert found.rms_best == pytest.approx(np.sqrt(np.mean((off - slope[0] * bladder) ** 2)))


def test_the_distance_of_tables_and_laws_grows_as_the_pressure_falls_at_any_angle(audit):
    for branch in ("contraction", "extension"):
        errors = [g.rms for g in audit.gaps if g.branch == branch]
        assert errors == sorted(errors) and errors[0] > 150
    assert min(a.rms_best for a in audit.angles) > 80


def test_loops_of_the_laws_give_energy_back(audit):
    def integral(p, e):
        """∫ (law 5 − law 4) dε from 0 to e, N."""
        line = (112 * p - 146.7) * e - (2966 * p - 1778.2) * e**2 / 2
        return line + (210.9 * p + 52.54) * (1 - math.exp(-45 * e)) / 45

    assert [loop.pressure_MPa for loop in audit.law_loops] == P.tolist()
    for loop in audit.law_loops:
        e = STROKES[loop.pressure_MPa]
        assert loop.mean_gap == pytest.approx(integral(loop.pressure_MPa, e) / e, rel=5e-3)
        assert loop.energy == pytest.approx(integral(loop.pressure_MPa, e) * L0 * 1e-3, rel=5e-3)
    gaps = [loop.mean_gap for loop in audit.law_loops]
    assert (min(gaps), max(gaps)) == pytest.approx((-67, -26), abs=0.5) and gaps[2:4] == pytest.approx(
        [-26, -28], abs=0.5
    )


def test_loops_of_the_tables_give_energy_back_at_any_angle(audit):
    e = np.linspace(0.0, STROKES[0.4], 2001)
    off = equation_1(0.4, e, 0.7655, 2.433, 326.8) - equation_1(0.4, e, 0.8576, 2.183, 303.7)
    assert audit.table_loops[3].mean_gap == pytest.approx(np.trapezoid(off, e) / e[-1], rel=5e-3)
    assert all(loop.energy < 0 for loop in audit.table_loops)
    assert all(gap < 0 for a in audit.angles for gap in a.mean_gaps.values())


def test_each_isobar_s_k_are_its_parabola(audit):
    inside = [one for one in audit.isobars if not one.at_bound]
    assert {one.pressure_MPa for one in audit.isobars if one.at_bound} == {0.1} and len(inside) == 8
    for one in inside:
        e = np.round(np.linspace(0.0, STROKES[one.pressure_MPa], 51), 6)
        force = (law_4 if one.branch == "contraction" else law_5)(one.pressure_MPa, e)
        square, line, rest = np.polyfit(e, force, 2)
        k1 = -2 * square / line
        k0 = square / (math.pi * R0**2 * one.pressure_MPa * A * k1**2)
        k2 = rest - k0 * math.pi * R0**2 * one.pressure_MPa * (A - B)
        assert one.fitted == pytest.approx({"k0": k0, "k1": k1, "k2": k2}, rel=1e-5)
    for branch in ("contraction", "extension"):
        for which in ("printed", "fitted"):
            k1 = [getattr(one, which)["k1"] for one in audit.isobars if one.branch == branch]
            assert k1 == sorted(k1), "k1 climbs as the pressure falls"


def test_shared_parameters_leave_tens_of_newtons(audit):
    from scipy.optimize import curve_fit

    p = np.repeat(P, 51)
    e = np.concatenate([np.round(np.linspace(0.0, STROKES[x], 51), 6) for x in P])
    for branch, law in (("contraction", law_4), ("extension", law_5)):
        one = next(s for s in audit.shared if s.branch == branch and not s.effects)
        (k0, k1, k2), _ = curve_fit(lambda x, *k: equation_1(*x, *k), (p, e), law(p, e), (1.0, 1.4, -200.0))
        assert one.values == pytest.approx({"k0": k0, "k1": k1, "k2": k2}, rel=1e-5)
        off = equation_1(p, e, k0, k1, k2) - law(p, e)
        assert one.rmse == pytest.approx(np.sqrt(np.mean(off**2))) and one.rmse > 40
        assert one.max_error == pytest.approx(np.max(np.abs(off)), rel=1e-6)
        with_bladder = next(s for s in audit.shared if s.branch == branch and s.effects)
        assert with_bladder.rmse < one.rmse and 0.9 < with_bladder.values["k1"] < 1.1


def test_scatter_is_what_gives_the_printed_correlation(audit):
    """A line through five points with residuals of that standard deviation has the printed r and these errors."""
    from scipy.stats import linregress

    shape = np.array([1.0, -2.0, 0.0, 2.0, -1.0])  # no mean, no slope over equally spaced pressures
    for one in audit.scatter:
        residual = shape * one.scatter * math.sqrt(3.0 / float(shape @ shape))
        line = linregress(P, one.intercept + one.slope * P + residual)
        assert abs(line.rvalue) == pytest.approx(one.r, abs=1e-9)
        assert (line.slope, line.intercept) == pytest.approx((one.slope, one.intercept))
        assert line.stderr == pytest.approx(one.slope_error)
        assert line.intercept_stderr == pytest.approx(one.intercept_error)
        assert one.refitted == pytest.approx(1.0, abs=1e-9)
    loose = {(s.branch, s.coefficient) for s in audit.scatter if abs(s.intercept) < 2 * s.intercept_error}
    assert loose == {("contraction", "c"), ("extension", "b"), ("extension", "c")}
