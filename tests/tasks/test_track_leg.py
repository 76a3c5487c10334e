"""The leg's own data set comes again from its script, and wishes become the leg they ask for."""

import importlib.util
import json

import numpy as np
import pytest

from pam_ident.core import DataError, UsageError
from pam_ident.fitting import fit
from pam_ident.leg.muscle import Muscle
from pam_ident.model import Model
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_path, dataset_record
from pam_ident.rig import Plan, make_record, write_case
from pam_ident.tasks import track as track_leg
from pam_ident.tasks.track import PAPER, TrackOptions

FOLDER = dataset_path("leg_muscle")


@pytest.fixture(scope="module")
def made(root, tmp_path_factory):
    """What the data set's script says, and the folder that the rig writes by it."""
    spec = importlib.util.spec_from_file_location("make_leg_muscle", root / "datasets" / "leg_muscle" / "make.py")
    make = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make)
    folder = tmp_path_factory.mktemp("made") / "leg_muscle"
    write_case(folder, make_record(Plan(5, "exponential_law", make.SECRETS, protocol=make.PROTOCOL)))
    return make, folder


@pytest.fixture(scope="module")
def record():
    return read_record(dataset_record("leg_muscle"))


@pytest.mark.parametrize("name", ["record.csv", "specimen.toml"])
def test_the_record_is_what_its_script_writes(made, name):
    _, folder = made
    assert (folder / name).read_bytes() == (FOLDER / name).read_bytes()


def test_the_plant_is_the_fit_of_the_record(made, record):
    make, _ = made
    (plant,) = Muscle.read(FOLDER / "plant.json")
    again = fit(Model.build("exponential_law", make.PLANT), record)
    assert plant.model.labels == again.model.labels and plant.specimen == record.specimen
    for name, value in again.values.items():
        assert plant.contraction[name] == pytest.approx(value, rel=1e-6, abs=1e-6), name
    assert again.rmse == pytest.approx(2.0, rel=0.1)  # the load cell's noise


@pytest.mark.parametrize("k", [0, 3, *(pytest.param(k, marks=pytest.mark.long) for k in (1, 7))])
def test_a_rung_of_the_ladder_is_the_fit_of_its_effects(record, k):
    ladder = json.loads((FOLDER / "ladder.json").read_text(encoding="utf-8"))
    rung, muscle = ladder["rungs"][k], Muscle.read(FOLDER / "ladder.json")[k]
    again = fit(Model.build(ladder["law"], tuple(rung["effects"]), (), ladder["free_geometry"]), record)
    assert list(muscle.model.labels) == rung["effects"]
    assert again.rmse == pytest.approx(rung["rmse_N"], rel=1e-6)
    for name, value in again.values.items():
        assert muscle.contraction[name] == pytest.approx(value, rel=1e-4, abs=1e-4), name


def test_its_errors_fall_from_rung_to_rung_to_the_floor():
    ladder = json.loads((FOLDER / "ladder.json").read_text(encoding="utf-8"))
    errors = [rung["rmse_N"] for rung in ladder["rungs"]]
    assert np.all(np.diff(errors) < 0.0) and errors[0] > 200.0
    assert errors[-1] == pytest.approx(ladder["noise_floor_N"], rel=0.1) and ladder["verdict"] == "adequate"


@pytest.fixture
def asked(monkeypatch):
    """What the layer below is asked to run."""
    seen = {}

    def stand_in(loop, controllers, course, gains, prototype, off, ground):
        seen.update(loop=loop, controllers=controllers, course=course, gains=gains, prototype=prototype)
        seen.update(off=off, ground=ground)

    monkeypatch.setattr(track_leg, "track", stand_in)
    return seen


def test_without_files_the_embedded_ladder_runs_on_the_embedded_plant(asked):
    track_leg.track_leg(TrackOptions())
    assert asked["loop"].pair.muscle.model.law.name == "exponential_law" and len(asked["controllers"]) == 8
    assert asked["course"].gait.cadence_Hz == 1.0 and asked["course"].window is None and asked["gains"] is None
    assert len(asked["course"].time) == 400 and asked["course"].judged == slice(200, 400)


def test_wishes_are_heard(asked):
    ladder = str(FOLDER / "ladder.json")
    wishes = TrackOptions(
        controller=ladder, gait="children", cadence_Hz=0.8, paper=True, gains=(1.0, 2.0, 0.3), supply_MPa=0.5, load_kg=2
    )
    track_leg.track_leg(wishes)
    pair = asked["loop"].pair
    assert pair.supply.pressure_Pa == 0.5e6 + 101325.0 and pair.leg.load_mass_kg == 2.0
    assert pair.muscle.model.labels == asked["controllers"][-1].model.labels  # the plant is the ladder's last rung
    assert asked["gains"] == (1.0, 2.0, 0.3) and asked["course"].window == PAPER
    assert asked["course"].gait.name == "knee_mean_sd" and asked["course"].gait.cadence_Hz == 0.8
    first = asked["course"].time[asked["course"].judged][0]
    assert first == pytest.approx(1.0 / 0.8 + 0.6) and asked["course"].judged.stop == len(asked["course"].time)


def test_a_leg_of_a_file_is_heard_and_what_is_said_besides_goes_before_it(asked, tmp_path):
    (tmp_path / "fit.json").write_bytes((FOLDER / "plant.json").read_bytes())
    (tmp_path / "leg.toml").write_text(
        '[muscles]\nplant = "fit.json"\n[sprocket]\nradius_m = 0.04\n[supply]\npressure_MPa = 0.65\n'
        '[load]\nmass_kg = 1\n[off]\nforce = [1.05, 0.95]\nmass = 1.2\nunknown = "creep"\nsize = 2.0\n'
    )
    track_leg.track_leg(TrackOptions(leg=str(tmp_path / "leg.toml"), load_kg=2.0, ageing=1.0))
    pair, off = asked["loop"].pair, asked["off"]
    assert pair.leg.sprocket_radius_m == 0.04 and pair.leg.load_mass_kg == 2.0
    assert pair.supply.pressure_Pa == 0.65e6 + 101325.0 and asked["ground"] is None
    assert len(asked["controllers"]) == 1  # the plant's own fit, as where --plant is given alone
    assert (off.force, off.mass, off.ageing, off.unknown.label, off.size) == ((1.05, 0.95), 1.2, 0.01, "creep", 2.0)


def test_a_plant_that_is_off_a_ground_and_lessons_are_heard(asked):
    track_leg.track_leg(TrackOptions(off=(-10.0, 10.0), unknown="creep", ground=True, prototype=True, learn=4))
    assert asked["off"].force == pytest.approx((0.9, 1.1)) and asked["off"].unknown.effect.name == "creep"
    assert asked["ground"].below_hip_m == 0.913 and asked["course"].lessons == 4
    assert len(asked["course"].time) == 1200 and asked["course"].judged == slice(1000, 1200)


def test_a_knee_that_does_not_close_is_bad_data_of_its_file(tmp_path):
    (tmp_path / "leg.toml").write_text("[knee]\nrocker_shank_m = [0.008, 0.19]\n")
    with pytest.raises(DataError, match=r"leg\.toml: \[knee\] the four-bar knee cannot close"):
        track_leg.track_leg(TrackOptions(leg=str(tmp_path / "leg.toml")))


@pytest.mark.parametrize("wrong", [{"gains": (1.0, None, None)}, {"supply_MPa": 0.0}, {"load_kg": -1.0}])
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(UsageError):
        TrackOptions(**wrong)
