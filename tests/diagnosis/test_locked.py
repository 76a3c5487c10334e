"""Isometric tests: what can be named where nobody measures how far the braid slides."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.patterns import patterns
from pam_ident.model import Model
from pam_ident.records import build_record
from pam_ident.records.isobars import nominal
from pam_ident.rig import Plan, Secret, make_record, write_case
from pam_ident.tasks.diagnose import diagnose_record
from pam_ident.tasks.setup import Setup

LAW = "modified_chou_hannaford"


def answer(folder, *hidden, protocol="locked_ramps", seed=31, **more):
    write_case(folder, make_record(Plan(seed, LAW, hidden, protocol=protocol, **more)))
    setup = Setup(LAW)
    return diagnose_record(setup.read(folder / "record.csv"), setup)


def test_friction_is_named_and_not_as_sure_as_with_a_measured_way(tmp_path):
    found = answer(tmp_path, Secret("pressure_friction", "contact_area", 2.0))
    assert found.selected == ("pressure_friction",)
    assert 0.8 < found.ranking[0].probability < 0.9


@pytest.mark.long
@pytest.mark.parametrize("name", ["viscous_damping", "pressure_lag"])
def test_what_follows_the_rate_of_the_pressure_is_one_group(name, tmp_path):
    found = answer(tmp_path, Secret(name, "textbook", 4.0))
    assert len(found.selected) == 1
    assert {"viscous_damping", "pressure_lag"} <= set(found.groups[0])


@pytest.mark.long
def test_a_bench_that_is_leaned_on_is_a_force_for_a_while(tmp_path):
    found = answer(tmp_path, unknown=Secret("rub", "leaned_on", 3.0))
    assert (found.verdict, found.pattern.kind, found.pattern.coordinate) == ("unknown_effect", "local", "time")


@pytest.mark.long
def test_two_static_effects_of_a_locked_muscle_are_two():
    """What pressure and length do is measured there as anywhere; one of them had to do for both."""
    p = np.tile(np.r_[np.linspace(0.05, 0.6, 60), np.linspace(0.6, 0.05, 60)], 8)
    e, time = np.repeat([0.02, 0.08, 0.14, 0.2], 240), 0.2 * np.arange(960) + np.repeat([0.0, 100.0, 200.0, 300.0], 240)
    muscle = Specimen("m", 200.0, 10.0, 25.0, 1.5)
    force = muscle.ideal_force(p, e - 0.008) + 6.0 + 4.0 * np.random.default_rng(0).standard_normal(960)
    found = diagnose(Model.build("chou_hannaford"), build_record("r", muscle, p, e, force, time=time), detail=False)
    assert set(found.selected) == {"length_offset", "force_bias"}, found.sentence


def test_few_lengths_show_patterns_over_time_alone_and_a_table_of_few_none(tmp_path):
    write_case(tmp_path, make_record(Plan(31, LAW, protocol="locked_stairs")))
    inputs = Setup(LAW).read(tmp_path / "record.csv").steady
    held = replace(inputs, contraction=np.round(inputs.contraction, 2))
    assert {one.name for one in patterns(held)} == {"beat", "burst", "sensor", "step", "trend"}
    assert patterns(replace(held, time=None)) == ()


def test_nothing_hidden_is_nothing_named(tmp_path):
    assert answer(tmp_path).verdict == "adequate"


@pytest.mark.long
@pytest.mark.parametrize("seed", [31, 32, 33])
def test_a_noisy_gauge_of_a_pressure_that_settles_is_no_relaxation(tmp_path, seed):
    plan = Plan(seed, LAW, protocol="locked_stairs", gauges="noisy_pressure")
    made = make_record(plan)
    write_case(tmp_path, made)
    setup = Setup(LAW)
    found = diagnose_record(setup.read(tmp_path / "record.csv"), setup)
    assert found.verdict == "adequate"
    assert found.noise_floor == pytest.approx(made.noise_rms, rel=0.05)


def test_steps_of_a_coarse_gauge_are_no_lengths(tmp_path):
    write_case(tmp_path, make_record(Plan(31, LAW, protocol="locked_stairs")))
    table = pd.read_csv(tmp_path / "record.csv")
    table["displacement_mm"] = (table["displacement_mm"] / 0.05).round() * 0.05 + 0.02
    table.to_csv(tmp_path / "record.csv", index=False)
    record = Setup(LAW).read(tmp_path / "record.csv")
    lengths = record.inputs.displacement_mm
    assert max(len(np.unique(lengths[record.inputs.segment == k])) for k in range(5)) > 1
    assert record.inputs.segment.max() + 1 == 5


def test_a_lone_reading_in_the_noise_of_a_held_pressure_is_no_isobar():
    pressure = np.r_[np.random.default_rng(1).normal(0.29, 0.003, 400), 0.2765]
    values, counts = np.unique(np.round(pressure, 6), return_counts=True)
    assert len(np.unique(nominal(values, counts))) == 1
    far = np.r_[pressure[:-1], 0.2]
    values, counts = np.unique(np.round(far, 6), return_counts=True)
    assert len(np.unique(nominal(values, counts))) == 2
