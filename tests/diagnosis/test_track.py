"""Of which samples nobody knows whether the muscle rests, or which way it slides."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import confounding, diagnose
from pam_ident.diagnosis.steady import steadied
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 1.5)


def unread(x):
    """The record of a track in mm at 10 Hz and one pressure, and its samples of unknown state."""
    t, p = 0.1 * np.arange(len(x)), np.full(len(x), 0.3)
    rng = np.random.default_rng(2)
    record = build_record("r", MUSCLE, p, (x + 0.01 * rng.standard_normal(len(x))) / 200.0, 300.0 - 4.0 * x, time=t)
    found = fit(Model.build("modified_chou_hannaford"), record)
    return record, steadied(record, found.model, found.values)[1].unread


def test_a_rest_of_few_rows_at_a_turn_may_be_the_slow_part_of_a_smooth_motion():
    once = 25.0 * (1.0 - np.cos(2.0 * np.pi * np.arange(1, 171) / 170.0))
    record, unknown = unread(np.tile(np.r_[once, np.zeros(25)], 4))
    top = ~record.inputs.moving & (record.inputs.displacement_mm > 40.0)
    assert top.sum() >= 4
    assert np.all(unknown[top])


def test_a_hold_at_a_turn_is_known_to_rest():
    up = np.linspace(0.0, 30.0, 40)
    record, unknown = unread(np.tile(np.r_[up, np.full(20, 30.0), up[::-1], np.zeros(20)], 3))
    rest = ~record.inputs.moving
    assert rest.sum() > 100
    assert unknown[rest].sum() <= 12  # the first and the last of each


@pytest.mark.parametrize(("end_mm", "rests"), [(29.5, True), (30.0, False)])
def test_a_stroke_that_ends_between_two_samples_may_rest_at_the_second(end_mm, rests):
    """By a clock that is a tenth of its step off, now and then."""
    rng, parts = np.random.default_rng(1), []
    for _ in range(12):
        way = np.minimum(3.0 * (np.arange(11) + np.r_[0.0, rng.uniform(-0.1, 0.1, 9), 0.0]), end_mm)
        parts += [way, np.full(20, end_mm), end_mm - way, np.zeros(20)]
    record, unknown = unread(np.concatenate(parts))
    moving, x = record.inputs.moving, record.inputs.displacement_mm
    ends = np.flatnonzero(moving[:-1] & ~moving[1:])
    ends = ends[np.abs(x[ends] - x[ends + 1]) < 0.05]
    assert len(ends) > 4
    assert np.mean(unknown[ends]) > 0.8 if rests else np.mean(unknown[ends]) < 0.4


def many_sines(seed, noise_mm):
    """A record of a drive of six sines at a wavering pressure, with dry friction of 8 N, noise of 3 N, and a noisy
    length."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 80.0, 0.025)
    rates, phases = rng.uniform(0.1, 0.9, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
    angle = 2.0 * np.pi * rates * time[:, None] + phases
    x, speed = 40.0 + 8.0 * np.sin(angle).sum(axis=1), np.cos(angle) @ rates
    pressure, e = 0.35 + 0.1 * np.sin(0.8 * time), x / 400.0
    force = pressure * (2400.0 - 9000.0 * e) - 100.0 - 300.0 * e - 8.0 * np.sign(speed)
    force += 3.0 * rng.standard_normal(len(x))
    long = Specimen("m", 400.0, 10.0, 25.4, 1.5)
    return build_record("rig", long, pressure, (x + noise_mm * rng.standard_normal(len(x))) / 400.0, force, time=time)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 5])
def test_friction_in_a_drive_of_many_sines_is_no_damping_because_its_short_ways_back_are_hidden(seed):
    found = diagnose(Model.build("exponential_law"), many_sines(seed, 0.8), detail=False)
    assert found.verdict == "missing_effect" and found.selected == ("coulomb_friction",)


@pytest.mark.long
def test_where_velocities_often_go_against_their_strokes_damping_is_not_told_from_friction(monkeypatch):
    record, model = many_sines(4, 2.0), Model.build("exponential_law")
    wrong = np.sign(record.inputs.velocity) != record.inputs.direction
    assert np.mean(wrong[record.inputs.moving]) > confounding.UNSURE
    found = diagnose(model, record, detail=False)
    assert set(found.groups[0]) >= {"viscous_damping", "coulomb_friction"}
    monkeypatch.setattr(confounding, "UNSURE", 1.0)
    assert not diagnose(model, record, detail=False).groups
