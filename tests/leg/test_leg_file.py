"""The file of a leg: the leg's own numbers come out of it, another's lie over them, and what cannot be is refused."""

import numpy as np
import pytest

from pam_ident.core import DataError, Specimen
from pam_ident.leg.leg_file import DEFAULT, default_file, read_leg
from pam_ident.leg.muscle import Muscle
from pam_ident.leg.pair import pair_of
from pam_ident.model import Model


@pytest.fixture
def write(tmp_path):
    def written(text):
        (tmp_path / "leg.toml").write_text(text, encoding="utf-8")
        return tmp_path / "leg.toml"

    return written


@pytest.fixture(scope="module")
def muscle():
    specimen = Specimen("made", 200.0, 10.0, 25.4, 1.5)
    return Muscle(Model.build("chou_hannaford"), specimen, {}, {})


def test_a_copy_of_the_own_file_is_the_own_leg(write):
    assert read_leg(write(default_file().read_text(encoding="utf-8"))) == DEFAULT


def test_numbers_of_a_file_lie_over_the_own_and_reach_the_pair(write, muscle):
    text = """
    [sprocket]
    radius_m = 0.05
    [knee]
    stops_deg = [-4, 70]
    rocker_shank_m = [0.0081, -0.0243]
    [supply]
    pressure_MPa = 0.65
    [muscles]
    rest_contraction = [0.03, 0.21]
    dead_volume_m3 = 2e-5
    [load]
    torque_N_m = -3
    [body]
    mass_kg = 80
    """
    own, pair = pair_of(muscle), pair_of(muscle, read_leg(write(text)))
    assert pair.leg.sprocket_radius_m == 0.05 and pair.leg.rest_contraction == (0.03, 0.21)
    assert np.degrees(pair.leg.stops_rad) == pytest.approx([-4.0, 70.0])
    assert pair.leg.knee.rocker_shank == 0.0081 - 0.0243j and pair.leg.knee.crank_shank == own.leg.knee.crank_shank
    assert pair.supply.pressure_Pa == pytest.approx(751325.0) and pair.dead_volume_m3 == 2e-5
    assert pair.leg.load_torque_N_m == -3.0
    assert pair.leg.shank.mass_kg == pytest.approx(own.leg.shank.mass_kg * 80.0 / 70.0)
    assert pair.valve == own.valve and pair.mean_MPa == own.mean_MPa


def test_muscles_are_looked_for_beside_the_file(write):
    path = write('[muscles]\nplant = "deep/fit.json"\n')
    assert read_leg(path)["muscles"]["plant"] == str(path.parent / "deep" / "fit.json")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[sproket]\nradius_m = 0.04", ("sproket", "did you mean sprocket")),
        ("radius_m = 0.04", ("unknown table 'radius_m'",)),
        ("[sprocket]\nradius = 0.04", ("[sprocket]", "'radius'", "radius_m")),
        ("[sprocket]\nradius_m = 42", ("[sprocket] radius_m = 42", "0.00042 to 4.2")),
        ("[sprocket]\nradius_m = -0.042", ("[sprocket] radius_m",)),
        ("[sprocket]\nradius_m = nan", ("[sprocket] radius_m",)),
        ("[sprocket]\nradius_m = true", ("[sprocket] radius_m", "a number")),
        ('[sprocket]\nradius_m = "0.042"', ("[sprocket] radius_m", "a number")),
        ("[knee]\ncrank_thigh_m = 0.004", ("[knee] crank_thigh_m", "a pair")),
        ("[knee]\ncrank_thigh_m = [3.8, -7.2]", ("[knee] crank_thigh_m", "-0.2 to 0.2")),
        ("[knee]\nstops_deg = [1, 2, 3]", ("[knee] stops_deg", "a pair")),
        ("[knee]\nstops_deg = [70, -5]", ("[knee] stops_deg must rise",)),
        ("[supply]\npressure_MPa = 700", ("[supply] pressure_MPa = 700", "0.1 to 2")),
        ("[load]\nmass_kg = -1", ("[load] mass_kg",)),
        ("[valve]\ncritical_ratio = 1.2", ("[valve] critical_ratio",)),
        ("[muscles]\nmean_MPa = 0.7", ("[muscles] mean_MPa must lie between",)),
        ("[muscles]\nplant = 3", ("[muscles] plant", "in quotes")),
        ("[off]\nforce = [1.0, 9.0]", ("[off] force", "0.2 to 5")),
        ("[off]\nageing = 2", ("[off] ageing",)),
        ("[knee", ("not a readable TOML",)),
    ],
)
def test_what_cannot_be_is_refused_in_a_line_that_names_file_and_key(write, text, told):
    with pytest.raises(DataError) as caught:
        read_leg(write(text))
    message = str(caught.value)
    assert "leg.toml" in message and "\n" not in message
    for word in told:
        assert word in message


def test_every_number_of_the_own_file_is_within_its_own_range():
    """And is read: a key that nobody knows would be refused."""
    assert read_leg(default_file()) == DEFAULT
