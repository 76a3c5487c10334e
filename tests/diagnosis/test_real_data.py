"""The ladder on measured muscles: what docs/validation.md tells of them, against fits made here without the program."""

import math
import re
import runpy

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import least_squares

from pam_ident.diagnosis import diagnose, heldout_rmse
from pam_ident.diagnosis.heldout import in_best_forms
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import read_record, thinned
from pam_ident.records.datasets import dataset_record

pytestmark = pytest.mark.long

WALL = 2.0
"""Wall of the map's specimen in mm, as assumed with it."""


@pytest.fixture(scope="module")
def bench(root):
    """The functions of the benchmark that climbs the measurements."""
    return runpy.run_path(str(root / "benchmarks" / "ladders_on_real_data.py"))


@pytest.fixture(scope="module")
def measured_map():
    return read_record(dataset_record("dmsp20_300"))


@pytest.fixture(scope="module")
def ladder(measured_map, bench):
    return bench["ladder_of"](measured_map)


@pytest.fixture(scope="module")
def table(root):
    """Pressure in MPa, contraction and force of the map's 60 active points, read without the program."""
    rows = pd.read_csv(root / "datasets" / "dmsp20_300" / "record.csv")
    rows = rows[rows["slack"] == 0]
    return rows["pressure_kPa"].to_numpy() / 1e3, 1.0 - rows["length_mm"].to_numpy() / 300.0, rows["force_N"].to_numpy()


def braid_in_rubber(p, e, force, rows, x):
    """Ideal braid with ends that saturate, and the virtual work of Yeoh's energy by differences; force in N.

    x: radius, angle, k1 and e_s; Yeoh's constants are those that fit `rows` best.
    """
    r0, theta0, k1, span = x
    angle = math.radians(theta0)

    def radius(e):
        return np.sqrt(1.0 - ((1.0 - e) * math.cos(angle)) ** 2) / math.sin(angle)

    def volume(e):
        return math.pi * r0**2 * radius(e) ** 2 * (1.0 - e)

    def energies(e):
        squares = (1.0 - e) ** 2, radius(e) ** 2
        i1 = squares[0] + squares[1] + 1.0 / (squares[0] * squares[1]) - 3.0
        return 2.0 * math.pi * r0 * WALL * np.column_stack([i1, i1**2, i1**3])

    h = 1e-5
    inner = e + (k1 - 1.0) * span * (1.0 - np.exp(-e / span))
    pull = p * (volume(inner + h) - volume(inner - h)) / (2.0 * h)
    rubber = (energies(e - h) - energies(e + h)) / (2.0 * h)
    return pull + rubber @ np.linalg.lstsq(rubber[rows], (force - pull)[rows], rcond=None)[0]


def by_scipy(p, e, force, rows):
    """Force in N at all samples by the best fit to `rows`."""
    found = least_squares(
        lambda x: (braid_in_rubber(p, e, force, rows, x) - force)[rows],
        [10.5, 26.0, 1.3, 0.04],
        jac="3-point",
        bounds=([8.5, 20.0, 0.2, 0.02], [11.5, 35.0, 20.0, 1.0]),
        x_scale=[1.0, 1.0, 0.1, 0.01],
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
        max_nfev=1000,
    )
    return braid_in_rubber(p, e, force, rows, found.x)


def rms(residual):
    return float(np.sqrt(np.mean(np.square(residual))))


def test_the_map_falls_below_7_N_with_named_effects_and_eight_parameters(ladder):
    errors = [rung.fit.rmse for rung in ladder.rungs]
    heldout = [rung.heldout_rmse for rung in ladder.rungs]
    last = ladder.rungs[-1].fit
    assert errors[0] > 140.0 and errors[-1] <= 7.0
    assert len(last.model.params) <= 8 and {"r0", "theta0"} <= set(last.values)
    assert errors == sorted(errors, reverse=True) and heldout == sorted(heldout, reverse=True)


def test_the_last_rung_on_the_map_is_the_fit_that_scipy_makes(ladder, table):
    p, e, force = table
    last = ladder.rungs[-1]
    assert last.effects == ("bladder_elasticity:yeoh", "end_taper:saturating")
    assert last.fit.rmse == pytest.approx(rms(by_scipy(p, e, force, np.ones(60, bool)) - force), rel=1e-4)
    outside = np.empty(60)
    for length in np.unique(e):
        here = e == length
        outside[here] = (by_scipy(p, e, force, ~here) - force)[here]
    assert last.heldout_rmse == pytest.approx(rms(outside), rel=0.01)


def test_the_map_is_predicted_better_than_by_laws_that_only_describe(ladder, measured_map, bench):
    others = [heldout_rmse(Model.build(law), measured_map) for law in bench["BESIDE"]]
    assert ladder.rungs[-1].heldout_rmse < 0.8 * min(others)


def test_the_bladder_of_the_map_is_a_rubber(ladder):
    """A shear modulus 2 C10 of 0.3 to 3 MPa, and the signs that Yeoh 1993 gives for filled rubber: + − +."""
    values = {e.name.rpartition(".")[2]: e for e in ladder.rungs[-1].fit.estimates}
    assert 0.15 < values["C10"].value < 1.5
    assert values["C20"].high < 0.0 < values["C30"].low


def test_what_stays_above_the_floor_of_the_map_is_said(ladder, table):
    """The floor is a free parabola over pressure at each length, its degrees of freedom counted."""
    p, e, force = table
    left = [force[e == x] - np.polyval(np.polyfit(p[e == x], force[e == x], 2), p[e == x]) for x in np.unique(e)]
    floor = math.sqrt(sum(float(r @ r) for r in left) / (60 - 15))
    assert ladder.noise_floor == pytest.approx(floor, rel=0.02)
    assert ladder.verdict == "unknown_effect" and ladder.last.pattern is not None
    told = float(re.search(r"about ([\d.]+) N rms", ladder.last.pattern.text)[1])
    assert told == pytest.approx(math.sqrt(ladder.rungs[-1].fit.rmse ** 2 - ladder.noise_floor**2), abs=0.05)


def test_in_a_table_the_form_is_the_one_that_predicts(measured_map):
    """With the nominal geometry saturating ends fit better than tapered ones, and predict worse."""
    names = ("bladder_elasticity:yeoh", "length_offset", "end_taper:saturating")
    richer = Model.build("chou_hannaford", names)
    base = fit(Model.build("chou_hannaford"), measured_map)
    best = base.model.adding(*in_best_forms(base, richer.terms))
    assert "end_taper" in best.labels
    assert fit(richer, measured_map).rmse < fit(best, measured_map).rmse < 7.0
    assert heldout_rmse(best, measured_map) < 0.6 * heldout_rmse(richer, measured_map)


def test_the_page_tells_the_ladder_on_the_map(root, bench, measured_map):
    page = (root / "docs" / "validation.md").read_text(encoding="utf-8")
    part = page.split("**DMSP-20-300**")[1].split("\n\n**")[0]
    figures = r"\| (\d+) \| ([\d.]+) \| ([\d.]+) \|"
    told, now = (
        [[float(x) for x in row] for row in re.findall(figures, text)]
        for text in (part, "\n".join(bench["table_of"](measured_map)))
    )
    assert len(told) >= 6
    np.testing.assert_allclose(np.array(told), np.array(now), rtol=0.01, atol=0.06)


@pytest.mark.parametrize("cut_length", [12, 23, 30])
def test_muscles_at_three_or_four_lengths_are_predicted_better_than_by_laws_that_only_describe(
    bench, realdata, cut_length
):
    record = bench["slices"](realdata, cut_length)
    found = bench["ladder_of"](record)
    heldout = [rung.heldout_rmse for rung in found.rungs]
    assert heldout == sorted(heldout, reverse=True)
    assert found.rungs[1].effects[0].startswith("bladder_elasticity")
    assert heldout[-1] < 0.5 * min(heldout_rmse(Model.build(law), record) for law in bench["BESIDE"])


def test_a_large_rest_is_not_adequate_because_no_name_predicts_it(bench, realdata):
    """With the hoop's force given, no further effect helps to predict a third length; 20 N are left all the same."""
    answer = diagnose(
        Model.build("chou_hannaford", ("bladder_elasticity",), free_geometry=True), bench["slices"](realdata, 12)
    )
    assert answer.best.rmse > 2.0 * answer.noise_floor and answer.verdict == "unknown_effect"


def test_the_bladder_alone_explains_the_plateaus_of_a_hand_made_muscle(bench, realdata):
    found = bench["ladder_of"](bench["plateaus"](realdata))
    assert found.rungs[1].effects == ("bladder_elasticity:yeoh",)
    assert found.rungs[0].fit.rmse > 70.0 and found.rungs[1].fit.rmse < 4.0 and found.rungs[1].heldout_rmse < 4.0
    assert found.rungs[-1].heldout_rmse < found.rungs[1].heldout_rmse


FRICTION = {"coulomb_friction", "pressure_friction", "presliding_hysteresis", "stribeck_friction"}


def test_a_cylinders_seal_rubs_with_a_part_that_grows_with_pressure(realdata):
    """Known beforehand: an area of 519 mm² by calliper, and a seal's friction that grows with pressure. Each pressure
    was driven at one speed each way, so that no record of it can tell friction from damping."""
    home = realdata / "cylinder_oring"
    record = thinned(read_record(str(home / "*.csv"), home / "specimen.toml"), 5_000)
    found = diagnose(Model.build("polynomial"), record)
    assert found.verdict == "unknown_effect"  # no form reaches the sensor's noise
    assert found.selected
    for name in found.selected:
        assert not FRICTION.isdisjoint({name}.union(*(group for group in found.groups if name in group)))
    assert any("pressure_friction" in {name, *group} for name in found.selected for group in found.groups or ((),))
    assert any("viscous_damping" in group for group in found.groups)
    assert not found.best.impossible
    assert found.best.rmse < 0.2 * found.base.rmse
    assert found.best.values["a0"] == pytest.approx(519.0, rel=0.01)
    assert 0.3 < found.noise_floor < 0.5  # 0.38 N between repeated strokes
