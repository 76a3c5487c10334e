"""Hidden effects of the virtual rig, whose physics is written apart from the effects, are named; others are not."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from pam_ident.core import Param
from pam_ident.diagnosis import climb, diagnose, heldout_rmse
from pam_ident.effects import AddsForce, Effect
from pam_ident.fitting import fit
from pam_ident.model import Model, as_term
from pam_ident.records import Record, build_record, read_record
from pam_ident.records.datasets import dataset_record
from pam_ident.rig import Plan, Protocol, Secret, make_record, write_case

LONG = pytest.mark.long
EXPONENTIAL, CHOU = "exponential_law", "modified_chou_hannaford"


def rig_record(folder, **plan) -> Record:
    write_case(folder, make_record(Plan(**plan)))
    return read_record(folder / "record.csv")


def hidden(law, secret):
    """A case of one hidden effect."""
    return pytest.param(law, secret, id=f"{law}-{secret.name}-{secret.form}")


@LONG
@pytest.mark.parametrize(
    ("law", "secret"),
    [
        hidden(EXPONENTIAL, Secret("coulomb_friction", "tanh", 1.5)),
        hidden(EXPONENTIAL, Secret("pressure_friction", "textbook", 2.0)),
        hidden(CHOU, Secret("viscous_damping", "thinning", 3.0)),
        hidden(EXPONENTIAL, Secret("pressure_lag", "first_order", 2.0)),
        hidden(EXPONENTIAL, Secret("pressure_lag", "two_ways", 4.0)),
        hidden(EXPONENTIAL, Secret("mullins_softening", "rested", 3.0)),
        hidden(CHOU, Secret("threshold_pressure", "stretching", 3.0)),
        hidden(EXPONENTIAL, Secret("creep", "log_time", 2.0)),
        hidden(CHOU, Secret("force_drift", "settling", 1.5)),
        hidden(CHOU, Secret("bladder_elasticity", "textbook", 1.5)),
        hidden(CHOU, Secret("series_compliance", "textbook", 2.0)),
    ],
)
def test_one_hidden_effect_is_named_alone_and_its_error_removed(tmp_path, law, secret):
    record = rig_record(tmp_path, seed=41, law=law, secrets=(secret,))
    answer = diagnose(Model.build(law), record)
    assert answer.verdict == "missing_effect" and answer.selected == (secret.name,)
    assert answer.best.rmse < 1.1 * 2.1 and answer.heldout_rmse_after < 0.95 * answer.heldout_rmse
    assert answer.ranking[0].effect == answer.selected[0] and answer.ranking[0].probability > 0.8


@pytest.mark.long
@pytest.mark.parametrize(
    "secret", [None, Secret("viscous_damping", "textbook", 3.0), Secret("mullins_softening", "rested", 3.0)]
)
def test_at_one_pressure_the_law_has_fewer_parameters_and_the_effect_its_name(tmp_path, secret):
    one = Protocol(pressures_MPa=(0.3,), cycles_per_speed=4)
    record = rig_record(tmp_path, seed=47, law=EXPONENTIAL, secrets=(secret,) if secret else (), protocol=one)
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert answer.selected == ((secret.name,) if secret else ())
    held = [e.name for e in answer.base.estimates if e.verdict.kind == "held"]
    assert held == ["a0", "b0", "c0"] == list(answer.best.model.law.pinned)
    assert all(answer.base.values[name] == 0.0 for name in held)


@LONG
def test_a_contact_that_bends_and_weakens_with_speed_is_presliding(tmp_path):
    secret = Secret("presliding_hysteresis", "lugre", 4.0)
    record = rig_record(tmp_path, seed=61, law=EXPONENTIAL, secrets=(secret,))
    assert diagnose(Model.build(EXPONENTIAL), record).selected == ("presliding_hysteresis",)


@LONG
@pytest.mark.parametrize(("weakening", "travel_mm"), [(0.6, 0.8), (1.5, 2.0)])
def test_where_its_travel_is_that_of_either_or_it_weakens_too_it_has_two_names(tmp_path, weakening, travel_mm):
    record = rig_record(tmp_path, seed=61, law=CHOU)
    level = 8.0 * (1.0 + weakening * np.exp(-((np.abs(record.inputs.velocity) / 4.0) ** 2)))
    friction = np.zeros(len(record))
    for k, dx in enumerate(np.diff(record.inputs.displacement_mm), 1):
        end = np.sign(dx) * level[k]
        friction[k] = end + (friction[k - 1] - end) * np.exp(-8.0 * abs(dx) / (travel_mm * level[k]))
    answer = diagnose(Model.build(CHOU), with_force(record, -friction))
    assert len(answer.selected) == 1
    assert {"presliding_hysteresis", "stribeck_friction"} in [set(group) for group in answer.groups]


@LONG
def test_presliding_that_rests_between_isobars_is_presliding_alone(tmp_path):
    record = rig_record(tmp_path, seed=62, law=EXPONENTIAL, sigma_N=1.0)
    widths, z, total = np.array([1.0, 2.5, 4.0, 5.5]), np.zeros(4), np.zeros(len(record))
    new = np.diff(record.inputs.segment, prepend=-1) != 0
    for k, dx in enumerate(np.diff(record.inputs.displacement_mm, prepend=0.0)):
        z = np.zeros(4) if new[k] else np.clip(z + dx / widths, -1.0, 1.0)
        total[k] = 1.8 * z.sum()
    answer = diagnose(Model.build(EXPONENTIAL), with_force(record, -total))
    assert answer.selected == ("presliding_hysteresis",) and answer.best.rmse < 1.2


@LONG
def test_a_pair_is_found_as_a_pair(tmp_path):
    secrets = (Secret("coulomb_friction", "textbook", 2.0), Secret("force_drift", "textbook", 1.5))
    record = rig_record(tmp_path, seed=42, law=EXPONENTIAL, secrets=secrets)
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert set(answer.selected) == {"coulomb_friction", "force_drift"}


@pytest.mark.parametrize(
    ("noise", "seed"),
    [("white", 43), *(pytest.param(*case, marks=LONG) for case in (("ar1", 43), ("ou", 43), ("ou", 53), ("ou", 64)))],
)
def test_nothing_is_proposed_when_the_rest_is_noise(tmp_path, noise, seed):
    """In the last two the position at the corners of the motion stands far out of a noise that hardly changes there."""
    record = rig_record(tmp_path, seed=seed, law=EXPONENTIAL, noise=noise)
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert answer.verdict == "adequate" and answer.selected == () and answer.pattern is None


@LONG
@pytest.mark.parametrize(
    ("seed", "protocol", "sigma"),
    [
        *((seed, "standard", 2.0) for seed in (48, 81, 85)),
        (82100054, "four_pressures", 1.0),
    ],
)
def test_a_wander_over_minutes_is_noise(tmp_path, seed, protocol, sigma):
    """It fits itself into the law, and what is left of it into a drift, or a braid that gives way."""
    record = rig_record(tmp_path, seed=seed, law=EXPONENTIAL, noise="slow", protocol=protocol, sigma_N=sigma)
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert answer.verdict == "adequate" and answer.selected == () and answer.pattern is None


@LONG
def test_a_drift_is_still_one_beside_a_wander(tmp_path):
    record = rig_record(
        tmp_path, seed=48, law=EXPONENTIAL, noise="slow", secrets=(Secret("force_drift", "settling", 2.0),)
    )
    assert diagnose(Model.build(EXPONENTIAL), record).selected == ("force_drift",)


@LONG
@pytest.mark.parametrize("seed", [2, 6])
def test_the_slow_end_of_1_over_f_noise_is_no_drift(tmp_path, seed):
    secret = Secret("pressure_friction", "textbook", 4.0)
    record = rig_record(tmp_path, seed=43, law=EXPONENTIAL, secrets=(secret,))
    frequency = np.fft.rfftfreq(len(record))
    white = np.fft.rfft(np.random.default_rng(seed).standard_normal(len(record)))
    pink = np.fft.irfft(np.r_[0.0, white[1:] / np.sqrt(frequency[1:])], len(record))
    noisy = replace(record, force=record.force + 6.0 * pink / np.std(pink))
    answer = diagnose(Model.build(EXPONENTIAL), noisy)
    assert answer.selected == ("pressure_friction",)


@LONG
@pytest.mark.parametrize(("noise", "named"), [("white", True), ("ar1", False)])
def test_a_faint_effect_is_not_named_where_noise_is_coloured(tmp_path, noise, named):
    """A tenth of the noise's variance: significant in both, but no noise has the colour that it is given exactly."""
    secret = Secret("coulomb_friction", "textbook", 0.3)
    record = rig_record(tmp_path, seed=43, law=EXPONENTIAL, noise=noise, secrets=(secret,))
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert ("coulomb_friction" in answer.selected) == named
    assert answer.verdict == ("missing_effect" if named else "adequate")


@LONG
@pytest.mark.parametrize(
    ("unknown", "form", "kind"),
    [
        ("rub", "fold", "local"),
        ("screw_ripple", "textbook", "periodic"),  # in test_experiment.py, too
        ("screw_ripple", "hum", "periodic"),
        ("rub", "textbook", "local"),
        ("rub", "leaned_on", "local"),
        ("rub", "two_places", "other"),
        ("mount_slip", "textbook", "step"),
        ("mount_slip", "gauge", "step"),
        ("wandering_sensor", "length", "trend"),
        ("wandering_sensor", "textbook", "trend"),
        ("wandering_sensor", "gain", "trend"),
        ("wandering_sensor", "cell", "trend"),
        ("wandering_sensor", "tiring", "trend"),
    ],
)
def test_what_no_known_effect_explains_is_described_not_named(tmp_path, unknown, form, kind):
    secret = Secret(unknown, form, 2.0)
    record = rig_record(tmp_path, seed=44, law=EXPONENTIAL, unknown=secret)
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert answer.verdict == "unknown_effect" and answer.pattern is not None
    assert answer.pattern.kind == kind and answer.selected == ()
    assert answer.next_experiment is not None and "minutes in all" in answer.next_experiment.text


@LONG
def test_a_name_that_explains_little_does_not_hide_what_is_left(tmp_path):
    """A spring that rings after each reversal: a little of it looks like damping."""
    record = rig_record(tmp_path, seed=48, law=EXPONENTIAL)
    inputs = record.inputs
    begins = np.r_[True, np.diff(inputs.direction) != 0]
    since = inputs.time - inputs.time[np.maximum.accumulate(np.where(begins, np.arange(len(record)), 0))]
    ringing = 6.0 * np.exp(-since / 1.5) * np.cos(2.0 * np.pi * since / 0.9) * inputs.moving
    answer = diagnose(Model.build(EXPONENTIAL), with_force(record, ringing))
    assert answer.verdict == "unknown_effect"


@LONG
def test_a_position_that_is_unsure_in_some_strokes_alone_is_no_effect(tmp_path):
    """Noise of the position is large where strokes cannot be smoothed, and does most where the force is steep."""
    record = rig_record(tmp_path, seed=49, law=EXPONENTIAL)
    inputs = record.inputs
    wrong = 0.06 * np.random.default_rng(3).standard_normal(len(record))
    length = inputs.specimen.initial_length_mm
    again = build_record(
        "unsure", inputs.specimen, inputs.pressure, inputs.contraction + wrong / length, record.force, time=inputs.time
    )
    answer = diagnose(Model.build(EXPONENTIAL), again)
    assert answer.verdict == "adequate" and answer.pattern is None


def with_force(record: Record, added) -> Record:
    """The record with a force in N (n,) added."""
    return replace(record, force=record.force + added)


@LONG
@pytest.mark.parametrize(("radius", "verdict"), [(0.97, "unknown_effect"), (0.0, "adequate")])
def test_a_swing_whose_phase_wanders_is_no_noise_and_slow_noise_of_its_size_is(tmp_path, radius, verdict):
    """A process of the second order that swings in 5.5 samples, beside one of the first."""
    record = rig_record(tmp_path, seed=54, law=EXPONENTIAL, sigma_N=1.0)
    steps = np.random.default_rng(11).standard_normal(len(record))
    memory = [1.0, -2.0 * radius * np.cos(2.0 * np.pi / 5.5), radius**2] if radius else [1.0, -0.9]
    swing = lfilter([1.0], memory, steps)
    answer = diagnose(Model.build(EXPONENTIAL), with_force(record, 2.0 * swing / swing.std()))
    assert answer.verdict == verdict and answer.selected == ()
    told = re.findall(r"it swings with a period of about (\S+) s", answer.pattern.text if answer.pattern else "")
    period = 5.5 * np.median(np.diff(record.inputs.time))
    assert [float(one) for one in told] == pytest.approx([period] if radius else [], rel=0.05)


@LONG
def test_bursts_over_the_noise_are_no_noise(tmp_path):
    record = rig_record(tmp_path, seed=45, law=CHOU, noise="ar1")
    time = record.inputs.time
    begins = np.random.default_rng(8).uniform(time[0], time[-1], 9)
    bursts = sum(40.0 * np.exp(-np.maximum(time - t, 0.0) / 2.0) * (time > t) for t in begins)
    answer = diagnose(Model.build(CHOU), with_force(record, bursts))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert answer.pattern is not None and answer.pattern.coordinate == "time"
    assert min(abs(begins - answer.pattern.value)) < 5.0


@LONG
def test_a_step_of_scale_is_a_step_though_the_temperature_follows_it_nearly(tmp_path):
    record = rig_record(tmp_path, seed=46, law=CHOU)
    time = record.inputs.time
    moment = time[0] + 0.45 * np.ptp(time)
    answer = diagnose(Model.build(CHOU), with_force(record, 0.01 * record.force * (time > moment)))
    assert answer.verdict == "unknown_effect" and answer.pattern is not None and answer.pattern.kind == "step"
    assert answer.pattern.value == pytest.approx(moment, abs=30.0)


def passed(record: Record):
    """Share of the record's time that has passed, (n,)."""
    time = record.inputs.time
    return (time - time[0]) / np.ptp(time)


@LONG
def test_a_stiffness_that_falls_all_the_while_is_no_softening_of_first_cycles(tmp_path):
    record = rig_record(tmp_path, seed=51, law=EXPONENTIAL, sigma_N=1.0)
    answer = diagnose(Model.build(EXPONENTIAL), with_force(record, -50.0 * passed(record) * record.inputs.contraction))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert answer.pattern is not None and answer.pattern.kind == "trend"


@LONG
def test_a_force_that_grows_as_it_warms_is_no_softening(tmp_path):
    record = rig_record(tmp_path, seed=52, law=CHOU, warming=True)
    answer = diagnose(Model.build(CHOU), with_force(record, 0.05 * passed(record) * record.force))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert answer.pattern is not None and answer.pattern.kind == "trend"


@LONG
def test_two_slips_of_the_gauge_are_steps(tmp_path):
    record = rig_record(tmp_path, seed=53, law=EXPONENTIAL, sigma_N=1.0)
    slips = 4.0 * (passed(record) > 0.3) - 6.5 * (passed(record) > 0.7)
    answer = diagnose(Model.build(EXPONENTIAL), with_force(record, slips))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert answer.pattern is not None and answer.pattern.kind == "step"
    assert answer.pattern.value == pytest.approx(record.inputs.time[np.argmax(passed(record) > 0.3)], abs=1.0)


@LONG
def test_what_loses_by_a_hair_is_heard_against_the_noise_that_it_leaves(tmp_path):
    """A softening in a few cycles beside friction: the wander that friction alone would leave explains it nearly.

    It fades by the way gone in strokes, which differ from isobar to isobar: the time since they began fits as well."""
    secrets = (Secret("coulomb_friction", "tanh", 2.93), Secret("mullins_softening", "travel", 0.96))
    plan = {"sigma_N": 1.0, "tier": 2, "protocol": "six_pressures"}
    record = rig_record(tmp_path, seed=208, law=EXPONENTIAL, secrets=secrets, **plan)
    found = diagnose(Model.build(EXPONENTIAL), record)
    assert len(found.selected) == 2 and "mullins_softening" in {*found.selected, *sum(found.groups, ())}


@LONG
@pytest.mark.parametrize(
    ("seed", "friction", "times"),
    [
        (320, Secret("presliding_hysteresis", "textbook", 7.6), 2.2),
        (332, Secret("pressure_friction", "radius", 6.0), 2.0),
    ],
)
def test_a_softening_over_the_way_beside_friction_has_its_name(tmp_path, seed, friction, times):
    """What friction leaves of it follows the clock as well, or passes for noise, three times as large as there is."""
    secrets = (friction, Secret("mullins_softening", "travel", times))
    record = rig_record(tmp_path, seed=seed, law=EXPONENTIAL, secrets=secrets, sigma_N=1.0)
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert set(answer.selected) == {friction.name, "mullins_softening"} and answer.noise_floor < 1.5


@LONG
def test_a_stop_hit_hard_is_no_stiffening_bladder(tmp_path):
    """A bladder follows all but 2 % of it, which is more than twice the noise."""
    record = rig_record(tmp_path, seed=63, law=EXPONENTIAL, sigma_N=4.0)
    x = record.inputs.displacement_mm
    stop = 0.8 * x.max()
    answer = diagnose(Model.build(EXPONENTIAL), with_force(record, -5.0 * np.maximum(x - stop, 0.0) ** 1.5))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert answer.pattern is not None and answer.pattern.kind == "local"
    assert answer.pattern.value == pytest.approx(stop, abs=1.5)


@LONG
def test_a_rub_on_one_branch_is_one_pattern(tmp_path):
    record = rig_record(tmp_path, seed=47, law=EXPONENTIAL)
    x = record.inputs.displacement_mm
    rub = 12.0 * np.exp(-0.5 * ((x - 20.0) / 2.0) ** 2) * (record.inputs.direction > 0)
    answer = diagnose(Model.build(EXPONENTIAL), with_force(record, rub))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert answer.pattern is not None and answer.pattern.kind == "local"
    assert answer.pattern.value == pytest.approx(20.0, abs=1.0)


@LONG
@pytest.mark.parametrize("effect", ["coulomb_friction", "viscous_damping"])
def test_one_speed_cannot_tell_friction_from_damping(tmp_path, effect):
    secret = Secret(effect, "textbook", 1.5)
    record = rig_record(tmp_path, seed=45, law=CHOU, secrets=(secret,), protocol="blunt")
    answer = diagnose(Model.build(CHOU), record)
    assert any({"coulomb_friction", "viscous_damping"} <= set(group) for group in answer.groups)
    assert answer.next_experiment is not None and "speed" in answer.next_experiment.vary


@LONG
def test_what_the_law_absorbs_and_what_the_record_lacks_is_marked(tmp_path):
    record = rig_record(tmp_path, seed=43, law=EXPONENTIAL)
    status = {s.effect: s.status for s in diagnose(Model.build(EXPONENTIAL), record).ranking}
    assert status["force_bias"] == "absorbed_by_law" and status["coulomb_friction"] == "candidate"
    table = read_record(dataset_record("dmsp20_300"))
    status = {s.effect: s.status for s in diagnose(Model.build("sarosi"), table).ranking}
    assert status["viscous_damping"] == status["creep"] == "not_excited"


def test_the_embedded_record_names_its_effect_and_its_twin_is_adequate():
    hidden = read_record(dataset_record("hidden_effect"))
    answer = diagnose(Model.build(EXPONENTIAL), hidden)
    twin = diagnose(Model.build(EXPONENTIAL), read_record(dataset_record("nothing_hidden")))
    assert answer.selected == ("pressure_friction",)
    assert answer.best.rmse < 1.1 * twin.base.rmse < 0.5 * answer.base.rmse
    assert twin.verdict == "adequate"


@LONG
def test_what_stands_beside_a_candidate_is_what_adding_it_leaves():
    record = read_record(dataset_record("hidden_effect"))
    model = Model.build(EXPONENTIAL)
    answer = diagnose(model, record, only=("pressure_friction", "viscous_damping", "pressure_lag", "thermal_softening"))
    first, *others = (one for one in answer.ranking if one.status == "candidate")
    assert (first.label, first.rmse_after) == (answer.labels[0], pytest.approx(answer.best.rmse, rel=1e-4))
    assert first.heldout_rmse_after == pytest.approx(answer.heldout_rmse_after, rel=1e-3)
    for one in others:
        added = fit(model.adding(as_term(one.label)), record)
        assert one.rmse_after == pytest.approx(added.rmse, rel=1e-3)
        assert one.heldout_rmse_after == pytest.approx(heldout_rmse(added.model, record, added), rel=0.01)


@pytest.mark.long
def test_a_user_s_own_effect_is_a_candidate(tmp_path):
    plain = rig_record(tmp_path, seed=44, law=EXPONENTIAL)
    wave = 2.0 * np.pi / 5.0
    record = with_force(plain, 6.0 * np.sin(wave * plain.inputs.displacement_mm + 0.7))

    def columns(inputs, shape, force):
        return np.column_stack([np.cos(wave * inputs.displacement_mm), np.sin(wave * inputs.displacement_mm)])

    coefficients = (Param("cosine", "N", "", scale=10.0), Param("sine", "N", "", scale=10.0))
    mine = Effect(
        "ball_screw",
        "Ripple of the ball screw",
        "this test",
        (AddsForce("textbook", "ripple", coefficients, columns),),
        "-",
    )
    answer = diagnose(Model.build(EXPONENTIAL), record, (mine,))
    assert answer.selected == ("ball_screw",) and answer.verdict == "missing_effect"


@LONG
def test_the_ladder_on_the_measured_map_falls_below_15_N_with_named_effects():
    record = read_record(dataset_record("dmsp20_300"))
    ladder = climb(Model.build("chou_hannaford", free_geometry=True), record)
    errors = [rung.fit.rmse for rung in ladder.rungs]
    heldout = [rung.heldout_rmse for rung in ladder.rungs]
    assert errors == sorted(errors, reverse=True) and heldout == sorted(heldout, reverse=True)
    assert errors[0] > 100.0 and errors[-1] <= 15.0
    assert len(ladder.rungs[-1].fit.model.params) <= 8
    assert ladder.rungs[-1].effects[0].startswith("bladder_elasticity")


@LONG
def test_no_larger_noise_is_told_than_was_before():
    model, hidden_effect = Model.build(EXPONENTIAL), read_record(dataset_record("hidden_effect"))
    first = diagnose(model, hidden_effect, detail=False)
    again = diagnose(model, hidden_effect, detail=False, noise_N=1.0)
    assert again.noise_floor == 1.0 < first.noise_floor and "the noise is about 1.00 N" in again.sentence
    assert "beyond noise" not in first.sentence and "What is left beyond noise lies in" in again.sentence


@LONG
def test_the_same_record_gives_the_same_answer_twice(tmp_path):
    record = rig_record(tmp_path, seed=41, law=EXPONENTIAL, secrets=(Secret("creep", "prony_2", 2.0),))
    first, second = (diagnose(Model.build(EXPONENTIAL), record) for _ in range(2))
    assert first.best.values == second.best.values and first.ranking == second.ranking


def test_a_record_of_fewer_samples_than_foretell_one_has_an_answer():
    """A ladder of twenty samples, cut into folds, ended in an internal error."""
    whole = read_record(dataset_record("hidden_effect"))
    few = whole.take(np.arange(0, len(whole), 300))
    assert len(few) == 16 and diagnose(Model.build("chou_hannaford"), few).verdict in ("adequate", "unknown_effect")
