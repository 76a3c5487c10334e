"""What a record does not determine is said by name."""

import math

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record

SPECIMEN = Specimen("bench", 200.0, 10.0, 25.4, 1.5)
LOOSE = {"flat", "dead", "held", "at_bound"}


def isobars(k1=1.05, theta=26.5, radius=10.3, sigma=0.5, seed=4, offset=0.0, pressures=(0.1, 0.2, 0.3, 0.4, 0.5)):
    """Five isobars of a braid, written out by hand."""
    e, p = (v.ravel() for v in np.meshgrid(np.linspace(0.0, 0.22, 50), pressures))
    angle = math.radians(theta)
    a, b = 3.0 / math.tan(angle) ** 2, 1.0 / math.sin(angle) ** 2
    force = math.pi * radius**2 * p * (a * (1.0 - k1 * e) ** 2 - b) + offset
    noise = sigma * np.random.default_rng(seed).standard_normal(len(e))
    return build_record("bench", SPECIMEN, p, e, force + noise)


def twins(one):
    found = {}
    for s in one.stand_ins:
        found.setdefault(s.calibration, []).append(set(s.parameters))
    return found


def verdict(one, name):
    return next(e.verdict for e in one.estimates if e.name == name)


def test_load_scale_pressure_scale_and_radius_are_one_and_the_same():
    one = fit(Model.build("chou_hannaford", free_geometry=True), isobars(k1=1.0))
    found = twins(one)
    assert found["force_scale"] == [{"r0"}] and found["pressure_scale"] == [{"r0"}]
    assert "displacement_scale" not in found and "pressure_bias" not in found


def test_k0_and_the_radius_are_a_flat_direction_and_neither_gets_an_error():
    one = fit(Model.build("modified_chou_hannaford", free_geometry=True), isobars())
    assert verdict(one, "k0").kind == verdict(one, "r0").kind == "flat"
    assert verdict(one, "k0").partners == ("r0",) and "r0" in verdict(one, "k0").text
    for e in one.estimates:
        assert math.isnan(e.stderr) == (e.verdict.kind in LOOSE), e.name
    assert not one.valid and "k0" in one.problems[0]


def test_k1_displacement_scale_and_length_offset_stand_in_for_each_other_when_the_geometry_is_free():
    one = fit(Model.build("modified_chou_hannaford", free_geometry=True), isobars())
    found = twins(one)
    assert {"k1"} in found["displacement_scale"]
    assert any("k1" in names for names in found["length_offset"])
    bound = twins(fit(Model.build("modified_chou_hannaford"), isobars(theta=25.4, radius=10.0)))
    assert "length_offset" not in bound


def test_a_length_offset_beside_k1_and_a_free_geometry_is_flat():
    one = fit(Model.build("modified_chou_hannaford", ("length_offset",), free_geometry=True), isobars())
    assert verdict(one, "length_offset.e_off").kind == "flat"
    assert "k1" in verdict(one, "length_offset.e_off").partners


def test_a_threshold_pressure_is_the_bias_of_the_gauge():
    model = Model.build("chou_hannaford", ("threshold_pressure",))
    assert twins(fit(model, isobars()))["pressure_bias"] == [{"threshold_pressure.p_th"}]


def test_a_parameter_on_which_nothing_depends_is_dead():
    record = isobars()
    still = build_record("still", SPECIMEN, record.inputs.pressure, np.zeros(len(record)), record.force)
    one = fit(Model.build("modified_chou_hannaford"), still)
    assert verdict(one, "k1").kind == "dead" and math.isnan(next(e for e in one.estimates if e.name == "k1").stderr)


def test_what_is_held_is_said_to_be_held_and_has_no_error():
    one = fit(Model.build("modified_chou_hannaford"), isobars(), held={"k1": 1.05})
    e = next(e for e in one.estimates if e.name == "k1")
    assert (e.value, e.verdict.kind) == (1.05, "held") and math.isnan(e.stderr)
    assert one.valid


def test_two_nearly_alike_pressures_trade_slope_against_offset():
    record = isobars(pressures=(0.300, 0.303), sigma=2.0, offset=15.0)
    one = fit(Model.build("modified_chou_hannaford"), record)
    assert verdict(one, "k2").kind == "traded" and verdict(one, "k2").partners == ("k0",)
    wide = fit(Model.build("modified_chou_hannaford"), isobars(sigma=2.0, offset=15.0))
    assert {e.verdict.kind for e in wide.estimates} == {"pinned"}


def test_an_interval_wider_than_the_value_is_called_loose():
    record = isobars(sigma=200.0)
    one = fit(Model.build("modified_chou_hannaford", ("end_taper",)), record)
    assert any(e.verdict.kind in ("loose", "traded", "flat") for e in one.estimates)


def test_a_value_that_is_all_error_is_not_determined():
    """An initial peak that the record does not reach."""
    e, p = (v.ravel() for v in np.meshgrid(np.linspace(0.1, 0.25, 25), (0.2, 0.3, 0.4, 0.5)))
    force = 100.0 + 2000.0 * p - (500.0 + 6000.0 * p) * e + np.random.default_rng(2).normal(0.0, 3.0, len(e))
    one = fit(Model.build("exponential_law"), build_record("bench", SPECIMEN, p, e, force))
    assert verdict(one, "c0").kind == "flat" and verdict(one, "c0").text.startswith("not determined: its 95 % interval")
    assert not one.valid and "c0" in one.problems[0]
    wide = [e for e in one.estimates if e.verdict.kind == "traded" and e.high - e.low > 2.0 * abs(e.value)]
    assert wide and all("and not pinned" in e.verdict.text for e in wide)


@pytest.mark.parametrize("seed", range(3))
def test_verdicts_of_a_good_record_are_all_pinned(seed):
    one = fit(Model.build("modified_chou_hannaford"), isobars(seed=seed))
    assert all(e.verdict.kind == "pinned" and e.low < e.value < e.high for e in one.estimates)
