"""Whether a force builds up by the cycle, by the time since the muscle was pressurised, by the clock, or at once."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
from pam_ident.records import Record, build_record, read_record
from pam_ident.rig import Plan, Secret, make_record, write_case

CHOU = "modified_chou_hannaford"


def rig_record(folder, *secrets: Secret) -> Record:
    write_case(folder, make_record(Plan(71, CHOU, secrets)))
    return read_record(folder / "record.csv")


@pytest.mark.long
def test_what_creeps_since_it_was_pressurised_is_creep(tmp_path):
    """It was Mullins softening with 0.985 and more, alone, where no form of creep began with the pressure."""
    record = rig_record(tmp_path)
    since = record.inputs.time - np.array([record.inputs.time[record.level == p].min() for p in record.level])
    crept = replace(record, force=record.force + 15.0 * record.inputs.pressure * np.log1p((since + 5.0) / 4.0))
    found = diagnose(Model.build(CHOU), crept)
    assert found.verdict == "missing_effect" and found.selected == ("creep",)


@pytest.mark.long
def test_softening_by_the_cycle_is_told_from_creep(tmp_path):
    found = diagnose(Model.build(CHOU), rig_record(tmp_path, Secret("mullins_softening", "textbook", 3.0)))
    assert found.selected == ("mullins_softening",) and found.groups == ()


@pytest.mark.parametrize(("size_N", "tau_s"), [(7.0, 43.0), (1.5, 2.0)])
def test_a_drift_that_slows_down_in_a_short_record_is_no_slow_noise(size_N, tau_s):
    """Against the noise that the law alone leaves nothing earns its place; each in its own, the drift does."""
    rise = np.linspace(0.0, 1.0, 34)[1:]
    e = 0.22 * np.tile(np.r_[rise, rise[-2::-1], 0.0], 9)
    time = np.cumsum(np.tile(np.repeat([1.0, 0.5, 0.25], 66), 3)) + np.repeat([0.0, 30.0, 60.0], 198)
    p, noise = np.repeat([0.2, 0.35, 0.5], 198), 0.9 * np.random.default_rng(1).standard_normal(594)
    force = p * (2400.0 - 9000.0 * e) - 150.0 - 600.0 * e + size_N * np.log1p(time / tau_s) + noise
    record = build_record("short", Specimen("m", 200.0, 10.0, 25.0, 1.5), p, e, force, time=time)
    found = diagnose(Model.build("exponential_law"), record, detail=False)
    assert (found.verdict, found.selected) == ("missing_effect", ("force_drift",)), found.sentence


def test_a_step_that_no_slow_noise_takes_at_once_is_no_noise():
    """A plug that loses 10 N twice, for 24 s: noise that forgets in 10 s has such values, but does not leap to them."""
    rng, rise = np.random.default_rng(0), np.linspace(0.0, 1.0, 60)[1:]
    e = 0.22 * np.tile(np.r_[rise, rise[-2::-1], 0.0], 12)
    rows, p = np.arange(len(e)), np.repeat([0.2, 0.35, 0.5], len(e) // 3)
    time, slow, kept = (
        0.4 * rows + np.repeat([0.0, 30.0, 60.0], len(e) // 3),
        rng.standard_normal(len(e)),
        np.exp(-0.04),
    )
    for k in rows[1:]:
        slow[k] = kept * slow[k - 1] + np.sqrt(1.0 - kept**2) * slow[k]
    lost = 10.0 * (((rows > 250) & (rows < 310)) | ((rows > 900) & (rows < 960)))
    force = p * (2400.0 - 9000.0 * e) - 150.0 - 600.0 * e + 1.5 * slow + 0.5 * rng.standard_normal(len(e)) - lost
    record = build_record("plug", Specimen("m", 200.0, 10.0, 25.0, 1.5), p, e, force, time=time)
    found = diagnose(Model.build("exponential_law"), record, detail=False)
    assert (found.verdict, found.selected) == ("unknown_effect", ()) and "jumps" in found.sentence, found.sentence


def test_the_noise_of_a_short_dynamic_record_is_what_the_likeliest_drivers_leave():
    """Of 400 rows surfaces over all drivers leave too few, and the law alone left slow noise."""
    muscle, t = Specimen("m", 200.0, 10.0, 25.0, 1.5), 0.05 * np.arange(400)
    e = 0.1 - 0.08 * np.cos(2.0 * np.pi * t / 7.0) * np.cos(2.0 * np.pi * t / 31.0)
    p = 0.3 + 0.12 * np.sin(2.0 * np.pi * t / 4.3 + 1.0) + 0.06 * np.sin(2.0 * np.pi * t / 11.0)
    force = muscle.ideal_force(p - 0.012, e) - 18.0 * (t / t[-1]) ** 1.5
    record = build_record("t", muscle, p, e, force + np.random.default_rng(2).standard_normal(400), time=t)
    found = diagnose(Model.build("chou_hannaford"), record)
    assert set(found.selected) == {"threshold_pressure", "force_drift"}
    assert found.noise_floor == pytest.approx(1.0, rel=0.15)
