"""The virtual rig: physics against closed forms, records against the contract, sizes against orders."""

import json
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.rig import (
    PROTOCOLS,
    Plan,
    Protocol,
    Secret,
    demo_plans,
    make_challenge,
    make_record,
    write_case,
)
from pam_ident.rig.challenge import SHARES, VISIBLE, quotas
from pam_ident.rig.friction import FORMS as FRICTION
from pam_ident.rig.friction import maxwell_slip
from pam_ident.rig.hidden import EFFECTS, UNKNOWNS
from pam_ident.rig.integrate import follow
from pam_ident.rig.memory import FORMS as MEMORY
from pam_ident.rig.muscle import ChouHannaford, Exponential, RigMuscle, RigSpecimen
from pam_ident.rig.record import COLUMNS
from pam_ident.rig.sensors import COLOURS, FAULTS, RigSensors, ornstein_uhlenbeck
from pam_ident.rig.statics import bladder_hoop, elastic_force

SPECIMEN = RigSpecimen()
EXPONENTIAL = RigMuscle(SPECIMEN, Exponential())
CHOU = RigMuscle(SPECIMEN, ChouHannaford(SPECIMEN))
KEYS = ["case", "law", "truth", "unknown", "tier", "blunt", "sigma", "noise_rms", "rmse_base", "n"]
SMALL = Protocol(pressures_MPa=(0.2, 0.4), cycles_per_speed=1)


def rng(seed=0):
    return np.random.default_rng(seed)


@pytest.fixture(scope="module")
def course():
    return SMALL.run(CHOU, rng())


def loop_work(course, force):
    """Work (N per unit contraction) taken from the drive over all closed cycles: -sum F d(eps)."""
    logged = course.count > 0
    step = np.diff(course.eps, prepend=course.eps[0])
    step[~logged] = 0.0
    middle = 0.5 * (force + np.concatenate([force[:1], force[:-1]]))
    return -np.sum(middle * step)


def test_zero_force_ends_the_stroke():
    reach = EXPONENTIAL.stroke_mm(0.3) / 200.0
    assert EXPONENTIAL.force(np.array([0.3]), np.array([reach]))[0] == pytest.approx(0.0, abs=1e-6)
    assert CHOU.stroke_mm(0.5) == pytest.approx(56.0)


def test_braid_keeps_its_thread_length():
    eps = np.linspace(0, 0.3, 7)
    radius, length = SPECIMEN.radius(eps), SPECIMEN.initial_length_mm * (1 - eps)
    theta0 = np.radians(25.4)
    turns = SPECIMEN.initial_length_mm * np.tan(theta0) / (2 * np.pi * SPECIMEN.initial_radius_mm)
    thread = np.hypot(length, 2 * np.pi * radius * turns)
    np.testing.assert_allclose(thread, thread[0], rtol=1e-12)
    slope = np.gradient(np.log(SPECIMEN.volume(np.linspace(0, 0.3, 3001))), 1e-4)
    np.testing.assert_allclose(SPECIMEN.log_volume_slope(eps)[1:-1], slope[[500, 1000, 1500, 2000, 2500]], rtol=1e-5)


def test_course_is_what_the_protocol_says(course):
    rows = course.rows
    assert len(rows) == 2 * 3 * 2 * 52
    for name, count in (("standard", 4680), ("blunt", 1200)):
        assert len(PROTOCOLS[name].run(CHOU, rng()).rows) == count
    assert np.all(np.diff(course.time) > 0)
    assert course.time[rows[0]] == pytest.approx(20.0)
    np.testing.assert_array_equal(np.unique(course.cycle[rows]), [1, 2, 3])
    moving = course.moving != 0
    inside = moving[1:] & moving[:-1] & (course.moving[1:] == course.moving[:-1])
    rise = np.diff(course.eps)[inside]
    area = (0.5 * (course.rate[1:] + course.rate[:-1]) * np.diff(course.time))[inside]
    np.testing.assert_allclose(area, rise, atol=2e-6)
    assert np.abs(course.rate[moving]).max() * 200 == pytest.approx(40 * 1.14, rel=1e-3)


def test_pressures_come_in_random_order():
    orders = {tuple(np.round(Protocol(substeps=1).run(CHOU, rng(s)).pressure[::5000], 2)) for s in range(6)}
    assert len(orders) > 3


@pytest.mark.parametrize("name", list(FRICTION))
def test_friction_takes_energy_out(course, name):
    for form in FRICTION[name].values():
        _, force = form(course, CHOU, rng(1))
        assert loop_work(course, force(1.0)) > 0, form.__doc__
        np.testing.assert_allclose(force(3.0), 3 * force(1.0))


@pytest.mark.parametrize("form", ["textbook", "first_order", "orifice"])
def test_lagging_pressure_takes_energy_out(course, form):
    """Squeezed gas pushes back: a lag can only widen the loop in the passive sense."""
    _, force = MEMORY["pressure_lag"][form](course, CHOU, rng(1))
    assert loop_work(course, force(0.01)) > 0


def test_fast_valve_makes_gas_balance_quasi_steady(course):
    """For a short time constant the gas balance goes over into p - T p_abs V'/V eps' V/V0."""
    settings, force = MEMORY["pressure_lag"]["first_order"](course, CHOU, rng(1))
    size, n = 1e-4, settings["polytropic"]
    share = SPECIMEN.volume(course.eps) / SPECIMEN.volume(course.eps[:1])
    drop = size * n * share * (course.pressure + 0.1013) * SPECIMEN.log_volume_slope(course.eps) * course.rate
    expected = -drop * CHOU.pressure_slope(course.pressure, course.eps)
    steady = (np.abs(course.moving) > 0) & (np.abs(np.roll(course.moving, 40)) > 0) & (course.count > 0)
    np.testing.assert_allclose(force(size)[steady], expected[steady], atol=0.02 * np.abs(expected).max())


def test_choked_valve_does_not_overshoot():
    """Between isobars the gas is far from the valve's pressure; whatever the step, it may not run past it."""
    course = SMALL.run(CHOU, rng())
    for size in (1e-3, 1e-2, 0.1):
        _, force = MEMORY["pressure_lag"]["orifice"](course, CHOU, rng(1))
        still = (course.moving == 0) & (course.rate == 0) & (course.count > 0) & (course.since_stop() > 2)
        assert np.abs(force(size)[still]).max() < 1e-3


@pytest.mark.parametrize("form", ["pressure_lag/orifice", "pressure_lag/first_order", "creep/prony_2"])
def test_grid_is_fine_enough(form):
    name, kind = form.split("/")
    runs = [replace(SMALL, substeps=k).run(CHOU, rng()) for k in (8, 32)]
    coarse, fine = (EFFECTS[name][kind](c, CHOU, rng(1))[1](0.2)[c.rows] for c in runs)
    assert np.abs(coarse - fine).max() < 0.01 * np.abs(fine).max()


def test_maxwell_slip_closes_its_loop():
    x = np.concatenate([np.linspace(0, 1, 301), np.linspace(1, 0, 301), np.linspace(0, 1, 301)])
    force = maxwell_slip(x, np.array([0.05, 0.2]), np.array([0.6, 0.4]))
    assert force[300] == pytest.approx(1.0) and force[601] == pytest.approx(-1.0)
    assert force[-1] == pytest.approx(force[300], abs=1e-12)
    # Back and forth over a stroke of 1 an element slides all but 2 reaches each way: area 2 w (1 - 2 reach).
    area = np.sum(0.5 * (force[301:] + force[300:-1]) * np.diff(x[300:]))
    assert area == pytest.approx(2 * (0.6 * (1 - 2 * 0.05) + 0.4 * (1 - 2 * 0.2)), rel=1e-3)


def test_arm_relaxes_with_its_time_constant():
    time = np.concatenate([np.linspace(0, 1, 21), np.linspace(1.3, 9, 12)])
    drive = np.minimum(time, 1.0)
    behind = drive - follow(time, drive, 2.5)
    np.testing.assert_allclose(behind[:21], 2.5 * -np.expm1(-time[:21] / 2.5), rtol=1e-12)
    np.testing.assert_allclose(behind[20:], behind[20] * np.exp(-(time[20:] - 1) / 2.5), rtol=1e-10)


def hoop_energy(hoop, axial):
    return 0.5 * (hoop - 1) ** 2


def test_numerical_energy_equals_hoop_formula(course):
    _, force = bladder_hoop(course, CHOU, rng())
    numerical = -1.3 * elastic_force(SPECIMEN, hoop_energy, course.eps)
    np.testing.assert_allclose(numerical, force(1.3), atol=1e-6)
    thick = replace(SPECIMEN, wall_thickness_mm=2.0, braid_angle_deg=25.0)
    assert elastic_force(thick, hoop_energy, np.array([0.2]))[0] == pytest.approx(178.6, abs=0.1)


@pytest.mark.parametrize("form", ["mooney_rivlin", "gent"])
def test_rubber_is_at_ease_at_rest_and_pulls_less_when_blown_up(course, form):
    _, force = EFFECTS["bladder_elasticity"][form](course, CHOU, rng())
    at = np.argsort(course.eps)
    change = force(1.0)[at]
    assert change[0] == pytest.approx(0.0, abs=1e-4)
    assert np.all(np.diff(change) < 1e-6) and change[-1] < -20


def test_fixture_gives_way(course):
    _, force = EFFECTS["series_compliance"]["textbook"](course, CHOU, rng())
    total = CHOU.force(course.pressure, course.eps) + force(2.0)
    inside = course.eps + total / (500.0 * 200.0)
    np.testing.assert_allclose(CHOU.force(course.pressure, inside), total, rtol=1e-8)


def test_null_leaves_the_noise():
    record = make_record(Plan(4, law="modified_chou_hannaford", sigma_N=2.0))
    assert record.noise_rms == pytest.approx(2.0, rel=0.06)
    assert record.rmse_base == pytest.approx(record.noise_rms, rel=0.003)


@pytest.mark.long
@pytest.mark.parametrize("law", list(VISIBLE))
def test_every_form_can_be_sized(law):
    for i, name in enumerate(VISIBLE[law]):
        for j, form in enumerate(EFFECTS[name]):
            secret = Secret(name, form, 2.0)
            record = make_record(Plan(100 * i + j, law, (secret,), sigma_N=2.0, warming=True))
            assert record.hidden[0].left_N == pytest.approx(4.0, rel=0.4), (name, form)
            asked = np.sqrt(record.noise_rms**2 + record.hidden[0].left_N ** 2)
            assert record.rmse_base == pytest.approx(asked, rel=0.05), (name, form)


def test_textbook_sizes_are_as_ordered():
    for ratio in (0.7, 5.0):
        plan = Plan(9, "exponential_law", (Secret("coulomb_friction", "textbook", ratio),), sigma_N=1.0)
        assert make_record(plan).hidden[0].left_N == pytest.approx(ratio, rel=0.011)


@pytest.mark.long
def test_every_unknown_can_be_drawn():
    for name, forms in UNKNOWNS.items():
        for j, form in enumerate(forms):
            record = make_record(Plan(300 + j, unknown=Secret(name, form, 2.0)))
            assert record.rmse_base > 1.5 * record.noise_rms, (name, form)


def test_effect_and_twin_share_run_and_noise():
    with_effect, without = (make_record(p) for p in demo_plans())
    for name in COLUMNS:
        same = np.array_equal(with_effect.column(name), without.column(name))
        assert same == (name != "force_N"), name
    gap = with_effect.column("force_N") - without.column("force_N")
    np.testing.assert_allclose(gap, with_effect.hidden[0].force[_rows(with_effect)], atol=2e-3)
    assert with_effect.rmse_base == pytest.approx(np.hypot(without.rmse_base, 6.0), rel=0.03)


def _rows(record):
    """Logged rows of the fine grid of a standard run (the grid is the same for every muscle)."""
    return PROTOCOLS[record.plan.protocol].run(record.muscle, np.random.default_rng([record.plan.seed, 2])).rows


@pytest.mark.parametrize("colour", COLOURS)
def test_noise_has_its_rms(colour):
    time, pressure = np.arange(20000) * 0.1, np.repeat([0.1, 0.5], 10000)
    noise = RigSensors(3.0, colour).force_noise(time, pressure, rng(2))
    assert np.std(noise) == pytest.approx(3.0, rel=0.12)
    neighbour = np.corrcoef(noise[1:], noise[:-1])[0, 1]
    assert (abs(neighbour) < 0.03) == (colour in ("white", "heavy", "growing"))
    low, high = np.std(noise[:10000]), np.std(noise[10000:])
    assert (high > 4.0 * low) == (colour == "growing")


def test_faults_spoil_what_they_say_and_nothing_else():
    table = make_record(Plan(5)).table

    def spoilt(name):
        out = table.copy()
        FAULTS[name](out, rng(4))
        return out

    for name in FAULTS:
        changed = ~np.isclose(spoilt(name), table, rtol=0.0, atol=0.0)
        columns = set(np.flatnonzero(changed.any(axis=0)).tolist())
        assert (
            columns
            == {
                "spikes": {5},
                "empty_cells": {3, 4, 5},
                "lost_rows": {0},
                "jitter": {0},
                "coarse": {3, 4, 5},
                "clipped": {5},
            }[name]
        )
    assert np.isnan(spoilt("lost_rows")[:, 0]).mean() == pytest.approx(0.05, abs=0.001)
    assert np.all(np.diff(spoilt("jitter")[:, 0]) > 0.0)


def test_a_regulator_that_does_not_keep_up_lets_the_pressure_fall_while_the_muscle_shortens():
    record = make_record(Plan(6, protocol="breathing"))
    steps, off = (
        np.diff(record.column("displacement_mm")),
        record.column("pressure_MPa") - record.column("pressure_set_MPa"),
    )
    off = off[1:] / record.column("pressure_set_MPa")[1:]
    assert off[steps > 1.0].mean() < -0.003 and off[steps < -1.0].mean() > 0.003 and np.abs(off).max() < 0.03


def test_ornstein_uhlenbeck_forgets_with_its_time():
    noise = ornstein_uhlenbeck(np.arange(100000) * 0.5, 2.0, rng(3))
    for lag in (1, 4):
        expected = np.exp(-lag * 0.5 / 2.0)
        assert np.corrcoef(noise[lag:], noise[:-lag])[0, 1] == pytest.approx(expected, abs=0.02)


def test_challenge_follows_contract_and_seed(tmp_path):
    truth = make_challenge(tmp_path / "a", n=14, seed=3)
    again = make_challenge(tmp_path / "b", n=14, seed=3)
    assert truth == again == json.loads((tmp_path / "a" / "truth.json").read_text())
    for case in truth:
        here = (tmp_path / "a" / str(case["case"]) / "record.csv").read_text()
        assert here == (tmp_path / "b" / str(case["case"]) / "record.csv").read_text()
        assert here.splitlines()[0] == ",".join(COLUMNS) and len(here.splitlines()) == case["n"] + 1
        assert list(case)[:10] == [
            "case",
            "law",
            "truth",
            "unknown",
            "tier",
            "blunt",
            "sigma",
            "noise_rms",
            "rmse_base",
            "n",
        ]
        assert {"forms", "noise", "size_ratio"} <= set(case)
        assert set(case["truth"]) <= set(VISIBLE[case["law"]])
        assert not (case["truth"] and case["unknown"])
    assert make_challenge(tmp_path / "c", n=1, seed=4)[0]["rmse_base"] != truth[0]["rmse_base"]


def test_specimen_file_is_read_back(tmp_path):
    import tomllib

    record = make_record(Plan(8, other_specimen=True, protocol="blunt"))
    write_case(tmp_path / "x", record)
    table = tomllib.loads((tmp_path / "x" / "specimen.toml").read_text())["specimen"]
    assert table.pop("name") == "x"
    assert RigSpecimen(**table) == record.muscle.specimen != SPECIMEN


def test_quotas_add_up():
    for n in (1, 7, 60, 200):
        assert len(quotas(n)) == n
    assert [quotas(200).count(k) for k in SHARES] == [50, 50, 20, 30, 20, 16, 14]
    assert quotas(3, "pair") == ["pair"] * 3


@pytest.mark.parametrize(
    "nonsense",
    [
        lambda: RigSpecimen(initial_radius_mm=0.0),
        lambda: RigSpecimen(braid_angle_deg=60.0),
        lambda: Protocol(pressures_MPa=()),
        lambda: Protocol(speeds_mm_s=(0.0,)),
        lambda: Protocol(hold_s=0.0),
        lambda: Plan(1, protocol="none"),
        lambda: Plan(1, sigma_N=0.0),
        lambda: RigSensors(colour="mauve"),
        lambda: Plan(1, fault="fire"),
        lambda: Plan(1, gauges="none"),
        lambda: make_record(Plan(1, law="cubic")),
        lambda: make_record(Plan(1, secrets=(Secret("gravity"),))),
        lambda: make_record(Plan(1, secrets=(Secret("creep", "none"),))),
        lambda: make_record(Plan(1, secrets=(Secret("creep", ratio=-1.0),))),
        lambda: make_record(Plan(1, secrets=(Secret("force_bias"),))),
        lambda: EXPONENTIAL.stroke_mm(0.05),
        lambda: quotas(0),
        lambda: quotas(4, "tier9"),
        lambda: make_challenge("nowhere", 1, protocols="round"),
    ],
)
def test_nonsense_is_refused(nonsense):
    with pytest.raises(ValueError):
        nonsense()
