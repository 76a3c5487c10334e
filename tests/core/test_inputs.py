"""Specimen geometry, parameters, errors and numbers on their way out."""

import math

import numpy as np
import pytest

from pam_ident.core import DataError, FitError, Inputs, PamError, Param, Specimen, UsageError, blank_nan

STEP = 1e-6


def braid_radius(specimen, e):
    """r from the length of a thread and its turns, both constant: b = L/cosθ, 2π n r = b sinθ."""
    theta = math.radians(specimen.braid_angle_deg)
    thread = specimen.initial_length_mm / math.cos(theta)
    turns = thread * math.sin(theta) / (2.0 * math.pi * specimen.initial_radius_mm)
    return math.sqrt(thread**2 - (specimen.initial_length_mm * (1.0 - e)) ** 2) / (2.0 * math.pi * turns)


@pytest.mark.parametrize("angle", [18.0, 25.4, 33.0])
def test_radius_and_volume_follow_from_threads_of_constant_length(angle):
    specimen = Specimen("s", 180.0, 9.0, angle)
    for e in (-0.03, 0.0, 0.1, 0.24):
        assert specimen.radius_ratio(np.array(e)) == pytest.approx(braid_radius(specimen, e) / 9.0, rel=1e-12)
        volume = [math.log(braid_radius(specimen, x) ** 2 * (1.0 - x)) for x in (e - STEP, e + STEP)]
        slope = (volume[1] - volume[0]) / (2.0 * STEP)
        assert specimen.log_volume_slope(np.array(e)) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("initial_length_mm", 0.0),
        ("initial_length_mm", -1.0),
        ("initial_radius_mm", math.nan),
        ("wall_thickness_mm", 0.0),
        ("wall_thickness_mm", 0.0015),
        ("wall_thickness_mm", 15.0),
        ("braid_angle_deg", 0.4),
        ("braid_angle_deg", 60.0),
        ("braid_angle_deg", math.nan),
    ],
)
def test_an_impossible_specimen_is_refused_by_the_name_of_the_field(field, value):
    with pytest.raises(DataError, match=f"muscle 7: {field} = "):
        Specimen(**{"name": "muscle 7", field: value})


def test_inputs_say_what_a_record_holds():
    empty = Inputs(np.ones(3), np.zeros(3), Specimen(), np.zeros(3))
    assert not any(empty.has(need) for need in ("branch", "motion", "time", "cycle", "temperature"))
    full = Inputs(*(np.ones(3), np.zeros(3)), Specimen(), np.ones(3), *(np.ones(3),) * 7)
    assert all(full.has(need) for need in ("branch", "motion", "time", "cycle", "temperature"))
    assert full.with_geometry(8.0, 30.0).specimen == Specimen(initial_radius_mm=8.0, braid_angle_deg=30.0)
    assert full.specimen == Specimen()


@pytest.mark.parametrize(("lower", "upper", "start"), [(0.0, 1.0, 2.0), (0.0, 1.0, -1.0), (2.0, 1.0, 1.5)])
def test_a_parameter_that_starts_outside_its_bounds_is_refused(lower, upper, start):
    with pytest.raises(UsageError, match="parameter k"):
        Param("k", "1", "", lower, upper, start)


def test_a_parameter_whose_bounds_are_one_value_is_held():
    assert Param("k", "1", "", 1.0, 1.0, 1.0).clip(5.0) == 1.0


def test_a_parameter_clips_to_its_bounds():
    param = Param("k", "1", "", -1.0, 2.0)
    assert [param.clip(x) for x in (-3.0, 0.5, 9.0)] == [-1.0, 0.5, 2.0]


def test_exit_codes_are_those_of_the_contract():
    assert [kind.exit_code for kind in (UsageError, FitError, DataError)] == [2, 3, 4]
    assert all(issubclass(kind, PamError) for kind in (UsageError, FitError, DataError))


def test_json_never_holds_nan_nor_numpy():
    given = {"a": math.nan, 1: [np.float64(2.5), math.inf], "b": np.array([1.0, np.nan]), "c": (True, None, "x")}
    answer = blank_nan(given)
    assert answer == {"a": None, "1": [2.5, None], "b": [1.0, None], "c": [True, None, "x"]}
    assert type(answer["1"][0]) is float
