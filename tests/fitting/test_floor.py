"""The noise between repeated strokes, white or not, and the test whether a fit leaves more than that."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.fitting import fit, lack_of_fit, repeat_noise
from pam_ident.model import Model, as_term
from pam_ident.records import build_record
from pam_ident.records.datasets import dataset_record
from pam_ident.records.load import read_record
from pam_ident.rig import Plan, Secret, make_record, write_case

LAW = Model.build("exponential_law")


@pytest.mark.parametrize(("rho", "memory"), [(0.0, 1.0), (0.7, (1 + 0.7) / (1 - 0.7))])
def test_the_floor_is_the_noise_whatever_its_colour(rho, memory, record):
    one = fit(LAW, record(n=20_000, rho=rho))
    floor = repeat_noise(one)
    assert floor.sigma == pytest.approx(2.0, rel=0.06) and floor.strokes == 30 and floor.groups == 10
    assert floor.memory == pytest.approx(memory, rel=0.25)


def test_the_floor_does_not_count_what_the_law_gets_wrong(record):
    one = fit(Model.build("modified_chou_hannaford"), record(n=5000))
    assert one.rmse > 10.0 and repeat_noise(one).sigma == pytest.approx(2.0, rel=0.06)


def test_a_table_has_no_repeats():
    one = fit(LAW, read_record(dataset_record("dmsp20_300")))
    assert repeat_noise(one) is None and lack_of_fit(one) is None


@pytest.mark.long
@pytest.mark.parametrize("rho", [0.0, 0.7])
def test_the_right_law_passes_as_often_as_the_level_says(rho, record):
    p = np.array([lack_of_fit(fit(LAW, record(seed=100 + s, rho=rho), detail=True)).p_value for s in range(60)])
    assert np.mean(p < 0.05) < 0.15 and 0.25 < np.mean(p) < 0.7


def test_a_wrong_law_is_found_out(record):
    found = lack_of_fit(fit(Model.build("modified_chou_hannaford"), record()))
    assert found.p_value < 1e-6 and not found.adequate


def test_friction_of_half_the_noise_is_found_out_in_coloured_noise(record):
    clean = record(n=5000, rho=0.7)
    shifted = build_record(
        "bench",
        Specimen("bench", 200.0, 10.0, 25.4, 1.5),
        clean.inputs.pressure,
        clean.inputs.contraction,
        clean.force - 1.0 * clean.inputs.direction,
        time=clean.inputs.time,
        level=clean.level,
    )
    assert lack_of_fit(fit(LAW, clean)).adequate
    assert not lack_of_fit(fit(LAW, shifted)).adequate


def test_a_force_in_the_holds_alone_is_found_out(tmp_path):
    """Friction that is written for motion alone, where a muscle at rest keeps two thirds of it."""
    write_case(tmp_path, make_record(Plan(5, secrets=(Secret("coulomb_friction"),))))
    one = read_record(tmp_path / "record.csv")
    moving = replace(one, force=np.where(one.inputs.moving, one.force, one.force - 4.0 * one.inputs.direction))
    model = LAW.adding(as_term("coulomb_friction:held"))
    assert lack_of_fit(fit(model, moving)).adequate
    assert not lack_of_fit(fit(LAW.adding(as_term("coulomb_friction")), moving)).adequate
