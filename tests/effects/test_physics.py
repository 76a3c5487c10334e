"""The formulas of the effects against figures and derivations that do not come from the effects."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Inputs, Specimen
from pam_ident.effects import get_effect
from pam_ident.laws import get_law
from pam_ident.model import Model

L0, R0, T = 200.0, 10.0, 2.0
MUSCLE = Specimen("m", L0, R0, 25.0, T)
EPS = np.array([0.0, 0.03, 0.1, 0.2, 0.26])


def inputs(e=EPS, p=0.4, specimen=MUSCLE, **more):
    e = np.atleast_1d(np.asarray(e, float))
    more = {key: np.broadcast_to(np.asarray(value, float), e.shape) for key, value in more.items()}
    if "moving" in more:
        more["moving"] = more["moving"].astype(bool)
    direction = more.pop("direction", np.zeros(len(e)))
    return Inputs(np.broadcast_to(np.asarray(p, float), e.shape), e, specimen, direction, **more)


def columns(name, given, force=None, **shape):
    _, form = get_effect(name)
    return form.columns(given, shape, np.zeros(len(given)) if force is None else np.asarray(force, float))


def radius(e, theta0=MUSCLE.braid_angle_deg, r0=R0, length=L0):
    """r of a braid whose threads keep their length and their number of turns."""
    thread = length / math.cos(math.radians(theta0))
    turns = thread * math.sin(math.radians(theta0)) / (2.0 * math.pi * r0)
    return np.sqrt(thread**2 - (length * (1.0 - np.asarray(e))) ** 2) / (2.0 * math.pi * turns)


def pull(energy, e):
    """Force of a stored energy U(ε) in N·mm by virtual work, −dU/dx with x = L0 ε, by central differences."""
    h = 1e-5
    return -(energy(e + h) - energy(e - h)) / (2.0 * h) / L0


# --- bladder -----------------------------------------------------------------------------------------------------


def test_the_hoop_force_is_the_known_figure():
    """E = 1 MPa, t = 2 mm, ε = 0.2, θ0 = 25°, r0 = 10 mm: 178.6 N against the pull, whatever the length."""
    assert columns("bladder_elasticity", inputs(0.2))[0, 0] == pytest.approx(-178.6, abs=0.05)
    longer = inputs(0.2, specimen=replace(MUSCLE, initial_length_mm=500.0))
    assert columns("bladder_elasticity", longer)[0, 0] == pytest.approx(-178.6, abs=0.05)


def test_the_hoop_force_is_the_virtual_work_of_the_hoop_energy():
    def energy(e):
        return 0.5 * ((radius(e) - R0) / R0) ** 2 * 2.0 * math.pi * R0 * L0 * T

    np.testing.assert_allclose(columns("bladder_elasticity", inputs())[:, 0], pull(energy, EPS), rtol=1e-6, atol=1e-6)


def test_the_hoop_force_starts_with_the_slope_of_small_contractions():
    slope = -2.0 * math.pi * T * R0 / math.tan(math.radians(25.0)) ** 4
    assert columns("bladder_elasticity", inputs(1e-6))[0, 0] == pytest.approx(1e-6 * slope, rel=1e-4)


def invariants(e):
    """I1 and I2 of an incompressible thin tube, principal stretches 1−ε, r/r0 and the thickness that is left."""
    squares = [(1.0 - e) ** 2, (radius(e) / R0) ** 2]
    squares.append(1.0 / (squares[0] * squares[1]))
    return sum(squares), sum(1.0 / s for s in squares)


@pytest.mark.parametrize(("which", "column"), [("C1", 0), ("C2", 1)])
def test_mooney_rivlin_is_the_virtual_work_of_its_strain_energy(which, column):
    def energy(e):
        i1, i2 = invariants(e)
        return (i1 - 3.0 if which == "C1" else i2 - 3.0) * 2.0 * math.pi * R0 * T * L0

    got = columns("bladder_elasticity:mooney_rivlin", inputs())[:, column]
    np.testing.assert_allclose(got, pull(energy, EPS), rtol=1e-6, atol=1e-4)


@pytest.mark.parametrize("limit", [2.0, 5.0, 50.0])
def test_gent_is_the_virtual_work_of_its_strain_energy(limit):
    def energy(e):
        return -0.5 * limit * np.log(1.0 - (invariants(e)[0] - 3.0) / limit) * 2.0 * math.pi * R0 * T * L0

    got = columns("bladder_elasticity:gent", inputs(), J_m=limit)[:, 0]
    np.testing.assert_allclose(got, pull(energy, EPS), rtol=1e-6, atol=1e-4)


def test_gent_without_a_limit_is_the_neo_hookean_half_of_mooney_rivlin():
    gent = columns("bladder_elasticity:gent", inputs(), J_m=1e9)[:, 0]
    np.testing.assert_allclose(gent, 0.5 * columns("bladder_elasticity:mooney_rivlin", inputs())[:, 0], rtol=1e-6)


@pytest.mark.parametrize(("power", "size"), [(1, "C10"), (2, "C20"), (3, "C30")])
def test_yeoh_is_the_virtual_work_of_its_strain_energy(power, size):
    def energy(e):
        return (invariants(e)[0] - 3.0) ** power * 2.0 * math.pi * R0 * T * L0

    got = columns("bladder_elasticity:yeoh", inputs())[:, power - 1]
    np.testing.assert_allclose(got, pull(energy, EPS), rtol=1e-6, atol=1e-4, err_msg=size)


def test_yeoh_is_the_figure_worked_out_by_hand():
    """θ0 = 45°, 1 − ε = √½: λ_z² = 1/2, λ_θ² = 3/2, I1 − 3 = 1/2 + 3/2 + 4/3 − 3 = 1/3; their slopes −√2 and √2 cancel.

    What is left is that of 1/(λ_z² λ_θ²): dI1/dε = √2/(3/4)² = 16√2/9. 2π r0 t = 40π mm², so C10 costs 640√2 π/9 =
    315.938 N per MPa, C20 2/3 and C30 1/3 of it.
    """
    given = inputs(1.0 - math.sqrt(0.5), specimen=replace(MUSCLE, braid_angle_deg=45.0))
    got = columns("bladder_elasticity:yeoh", given)[0]
    np.testing.assert_allclose(got, [-315.938342, -210.625561, -105.312781], rtol=1e-8)


def test_the_printed_form_inflates_the_modulus_eleven_to_thirteen_times_in_metres():
    """The factor between the two is cot θ0 / (L0 (1 − ε)), L0 in metres; θ0 = 25.4° and 200 mm."""
    given = inputs([0.02, 0.1, 0.18], specimen=replace(MUSCLE, braid_angle_deg=25.4))
    ratio = columns("bladder_elasticity", given) / (columns("bladder_elasticity_printed", given) * 1e-3)
    e = given.contraction
    np.testing.assert_allclose(ratio[:, 0], 1.0 / (math.tan(math.radians(25.4)) * 0.2 * (1.0 - e)), rtol=1e-9)
    assert np.all((ratio > 10.5) & (ratio < 13.2))


# --- geometry and pressure ---------------------------------------------------------------------------------------


def test_extensible_threads_follow_from_the_equilibrium_of_one_braid():
    """Threads b that stretch under T = p (∂V/∂b): F = −p ∂V/∂L at the stretched length, to first order in 1/EA."""
    theta0, p, inv_ea = math.radians(25.0), 0.5, 1e-6  # 1/N
    b0 = L0 / math.cos(theta0)
    turns = b0 * math.sin(theta0) / (2.0 * math.pi * R0)

    def volume(b, x):
        return math.pi * (b**2 - x**2) / (2.0 * math.pi * turns) ** 2 * x

    for e in (0.0, 0.1, 0.2):
        x, h = L0 * (1.0 - e), 1e-2

        def tension(b, x=x, h=h):
            return p * (volume(b + h, x) - volume(b - h, x)) / (2.0 * h)

        def force(b, x=x, h=h):
            return -p * (volume(b, x + h) - volume(b, x - h)) / (2.0 * h)

        stretched = b0 * (1.0 + tension(b0) * inv_ea)
        loss = (force(stretched) - force(b0)) / inv_ea * 1e-3  # per 1/kN
        assert columns("braid_extensibility", inputs(e, p))[0, 0] == pytest.approx(loss, rel=5e-3), f"at ε = {e}"


def test_extensible_threads_cost_force_with_the_square_of_pressure():
    low, high = (columns("braid_extensibility", inputs(0.1, p))[0, 0] for p in (0.2, 0.6))
    assert high == pytest.approx(9.0 * low) and high < 0.0


def test_a_thick_wall_is_the_figure_worked_out_by_hand():
    """θ0 = 30°, ε = 0: D90 = 40 mm, 2 sin θ − 1/sin θ = −1; π · 0.5 · (40 · 2 · (−1) − 4) = −131.947 N."""
    given = inputs(0.0, 0.5, replace(MUSCLE, braid_angle_deg=30.0))
    assert columns("wall_thickness", given)[0, 0] == pytest.approx(-131.9468915, rel=1e-9)
    parts = columns("wall_thickness:parts", given)[0]  # π · 0.5 · 40 · 2 · (−1) and −π · 0.5 · 4
    np.testing.assert_allclose(parts, [-125.6637061, -6.283185307], rtol=1e-9)


def force_with(name, value, given, law="chou_hannaford", **law_values):
    model = Model.build(law, (name,))
    values = law_values | {f"{name.partition(':')[0]}.{key}": x for key, x in value.items()}
    return model.force(given, values)


def ideal(e, p, specimen=MUSCLE):
    e, p = np.broadcast_arrays(np.atleast_1d(np.asarray(e, float)), np.asarray(p, float))
    return get_law("chou_hannaford").force(p, e, specimen, {})


def test_end_taper_and_length_offset_shift_the_contraction_the_law_sees():
    np.testing.assert_allclose(force_with("end_taper", {"k1": 1.3}, inputs()), ideal(1.3 * EPS, 0.4), rtol=1e-12)
    np.testing.assert_allclose(force_with("length_offset", {"e_off": 0.01}, inputs()), ideal(EPS - 0.01, 0.4))
    longer = MUSCLE.initial_length_mm * 1.01  # e_off is the share by which the length was taken too short
    read = 1.0 - longer * (1.0 - EPS) / MUSCLE.initial_length_mm
    np.testing.assert_allclose(
        force_with("length_offset:rest_length", {"e_off": -0.01 / 1.01}, inputs(read)), ideal(EPS, 0.4)
    )
    tapered = force_with("end_taper:saturating", {"k1": 1.5, "e_s": 0.1}, inputs())
    np.testing.assert_allclose(tapered, ideal(EPS + 0.05 * (1.0 - np.exp(-EPS / 0.1)), 0.4), rtol=1e-12)


def test_a_threshold_takes_pressure_away_and_never_leaves_less_than_none():
    p = np.array([0.005, 0.02, 0.1, 0.5])
    given = inputs(np.full(4, 0.05), p)
    got = force_with("threshold_pressure", {"p_th": 0.02}, given)
    np.testing.assert_allclose(got, ideal(np.full(4, 0.05), np.maximum(p - 0.02, 0.0)), atol=1e-12)
    soft = force_with("threshold_pressure:soft", {"p_th": 0.02, "w": 0.1}, given)
    np.testing.assert_allclose(soft, ideal(np.full(4, 0.05), p - 0.02 * (1.0 - np.exp(-p / 0.1))), rtol=1e-12)


@pytest.mark.parametrize("mm_per_kn", [0.2, 1.0, 5.0])
def test_a_compliant_fixture_shortens_the_muscle_by_its_own_force(mm_per_kn):
    """Against bisection on F = law(ε + F/(K L0))."""
    got = force_with("series_compliance", {"compliance": mm_per_kn}, inputs())
    for e, force in zip(EPS, got, strict=True):
        low, high = -2000.0, 4000.0
        for _ in range(80):
            middle = 0.5 * (low + high)
            too_low = ideal(e + middle * 1e-3 * mm_per_kn / L0, 0.4)[0] > middle
            low, high = (middle, high) if too_low else (low, middle)
        assert force == pytest.approx(low, abs=1e-5)


def test_a_fixture_that_stiffens_gives_half_as_much_at_its_half_force():
    soft = columns("series_compliance", inputs(0.1), [400.0])[0, 0]
    assert soft == pytest.approx(0.4 / L0)
    assert columns("series_compliance:stiffening", inputs(0.1), [400.0], F_1=400.0)[0, 0] == pytest.approx(soft / 2.0)


def test_pressure_lags_by_the_rate_of_volume():
    """p − T_p (p + p_atm) d ln V/dt, V from the braid; a contracting muscle draws air and has less pressure."""
    v = 20.0
    given = inputs(0.1, 0.4, velocity=v, direction=1.0, time=0.0, moving=1.0)
    volume = [math.log(radius(e) ** 2 * (1.0 - e)) for e in (0.1 - 1e-6, 0.1 + 1e-6)]
    rate = (volume[1] - volume[0]) / 2e-6 * v / L0
    got = columns("pressure_lag", given)[0, 0]
    assert got == pytest.approx(-(0.4 + 0.101325) * rate, rel=1e-6) and got < 0.0
    power = columns("pressure_lag:orifice", given, n=2.0)[0, 0]
    assert power == pytest.approx(-10.0 * got**2, rel=1e-9)
    flow = columns("pressure_lag:mass_flow", given)[0, 0]
    assert flow == pytest.approx(got * (radius(0.1) / radius(0.0)) ** 2 * 0.9, rel=1e-9)


@pytest.mark.parametrize("form", ["conductance", "lagging"])
@pytest.mark.parametrize("locked", [True, False])
def test_a_driven_pressure_is_lost_as_gas_flows_and_comes_back(form, locked):
    """q̇ = p V̇/V + ṗ − q/τ in steps of Euler, p absolute or, in the form that leaves that open, above atmosphere."""
    time = np.linspace(0.0, 4.0, 40001)
    p = 0.3 + 0.25 * np.sin(2.0 * time) ** 3
    e = np.full(len(time), 0.1) if locked else 0.1 + 0.08 * np.sin(3.0 * time)
    given = inputs(e, p, time=time, segment=0, pressure_rate=np.gradient(p, time), velocity=1.0, direction=1.0)
    given = replace(given, locked=locked)
    log_volume = 2.0 * np.log(radius(e) / radius(0.0)) + np.log1p(-e)
    absolute, tau = (p + 0.101325, 0.3 * np.exp(log_volume)) if form == "conductance" else (p, np.full(len(p), 0.3))
    lost = np.zeros(len(time))
    for k, (step, rise) in enumerate(zip(np.diff(time), np.diff(p), strict=True)):
        lost[k + 1] = lost[k] + absolute[k] * (log_volume[k + 1] - log_volume[k]) + rise - lost[k] / tau[k] * step
    got = columns(f"pressure_lag:{form}", given, tau=0.3)[:, 0]
    np.testing.assert_allclose(-got, lost, atol=2e-3 * np.ptp(lost))


# --- friction and damping ----------------------------------------------------------------------------------------

MOTION = {
    "direction": [1.0, 1.0, -1.0, -1.0],
    "velocity": [8.0, 0.0, -2.0, 0.0],
    "moving": [1.0, 0.0, 1.0, 0.0],
}


def moved(**more):
    return inputs([0.1, 0.2, 0.1, 0.0], 0.5, **MOTION, **more)


@pytest.mark.parametrize(("new", "begun"), [(1.0, 0.4), (0.0, 0.2 * math.exp(-1.2) + 0.2 * math.exp(-0.2))])
def test_what_the_pressure_strains_relaxes_from_none_or_from_the_isobar_before(new, begun):
    """Isobars of 0.2 and 0.4 MPa, with 2 s between them: a rig goes to its next start at once, and rests there."""
    time, p = np.array([0.0, 5.0, 10.0, 12.0, 17.0]), np.array([0.2, 0.2, 0.2, 0.4, 0.4])
    given = inputs(np.full(5, 0.1), p, time=time, segment=[0, 0, 0, 1, 1])
    state = -columns("creep:free_pressurised", given, tau=10.0, new=new)[:, 2]  # of the middle time, at ε⁰
    expected = [*(0.2 * np.exp(-time[:3] / 10.0)), begun, begun * math.exp(-0.5)]
    np.testing.assert_allclose(state, expected, rtol=1e-12)


def test_coulomb_friction_opposes_the_motion_and_may_keep_another_value_in_holds():
    np.testing.assert_allclose(columns("coulomb_friction", moved())[:, 0], [-1.0, 0.0, 1.0, 0.0])
    held = columns("coulomb_friction:held", moved()) @ [20.0, 5.0]
    np.testing.assert_allclose(held, [-20.0, -5.0, 20.0, 5.0])
    smooth = columns("coulomb_friction:smooth", moved(), v_0=4.0) @ [20.0, 0.0]
    np.testing.assert_allclose(smooth, [-20.0 * math.tanh(2.0), 0.0, 20.0 * math.tanh(0.5), 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "shape"),
    [("coulomb_friction", {"tau_h": 1e3}), ("pressure_friction", {"p_0": 0.2}), ("stribeck_friction", {"v_s": 4.0})],
)
def test_free_friction_resists_and_keeps_no_more_than_it_had(name, shape):
    """Of a stroke and the hold after it at one state, whatever its coefficients are."""
    _, form = get_effect(f"{name}:free")
    assert all(p.lower == 0.0 for p in form.linear)
    given = moved(time=[0.0, 1.0, 2.0, 3.0], stroke_speed=[8.0, 8.0, 2.0, 2.0])
    given = replace(given, contraction=np.array([0.1, 0.1, 0.03, 0.03]))
    found = form.columns(given, shape, np.zeros(4))
    for sign, stroke, hold in ((-1.0, 0, 1), (1.0, 2, 3)):
        assert np.all(sign * found[stroke] >= 0.0) and np.all(sign * found[hold] >= -1e-12)
        assert np.all(np.abs(found[hold]) <= np.abs(found[stroke]) + 1e-12) and np.any(found[hold] != 0.0)


@pytest.mark.parametrize("name", ["stribeck_friction", "coulomb_friction:stribeck"])
def test_stribeck_friction_falls_from_breakaway_to_sliding(name):
    got = columns(name, moved(stroke_speed=[8.0, 8.0, 2.0, 2.0]), v_s=4.0) @ [20.0, 10.0, 5.0, 3.0]
    fast, slow = math.exp(-4.0), math.exp(-0.25)
    expected = [-(20.0 + 10.0 * fast), -(5.0 + 3.0 * fast), 20.0 + 10.0 * slow, 5.0 + 3.0 * slow]
    np.testing.assert_allclose(got, expected)


def test_friction_of_pressure_grows_with_pressure_and_the_area_of_contact():
    np.testing.assert_allclose(columns("pressure_friction", moved())[:, 0], [-0.5, 0.0, 0.5, 0.0])
    np.testing.assert_allclose(columns("pressure_friction:held", moved())[:, 1], [0.0, -0.5, 0.0, 0.5])
    area = radius(0.1) / R0 * 0.9
    got = columns("pressure_friction:contact_area", moved(), growth=2.0)[:, 0]
    np.testing.assert_allclose(got, [-0.5 * area**2, 0.0, 0.5 * area**2, 0.0])
    preloaded = columns("pressure_friction:preloaded", moved(), p_0=0.2) @ [10.0, 4.0]
    np.testing.assert_allclose(preloaded, [-7.0, -2.8, 7.0, 2.8])


@pytest.mark.parametrize(
    ("form", "sizes"), [("pressure_friction:bending", [0.3, 1.0]), ("coulomb_friction:stuck", [0.8])]
)
def test_a_contact_bends_before_it_slides_the_other_way(form, sizes):
    """What it lacks of sliding falls by e over each x_s of the way, here 0.04 mm a sample."""
    way = np.r_[0.1, 0.105, 0.105 - 2e-4 * np.arange(1, 7)]  # of 200 mm
    sign = np.r_[[1.0] * 2, [-1.0] * 6]
    motion = {"direction": sign, "velocity": sign, "moving": [True] * 8, "stroke_speed": [1.0] * 8}
    moved = inputs(way, 0.5, time=np.arange(8.0), **motion)
    bent = columns(form, moved, x_s=0.1) @ sizes
    expected = 0.8 * (1.0 - 2.0 * np.exp(-0.4 * np.arange(7)))
    np.testing.assert_allclose(bent[1:], expected, atol=1e-3)


def test_friction_of_a_static_table_follows_its_branch():
    table = inputs([0.1, 0.1, 0.1], direction=[1.0, -1.0, 0.0])
    np.testing.assert_allclose(columns("coulomb_friction", table)[:, 0], [-1.0, 1.0, 0.0])


def test_viscous_damping_is_newtons_per_metre_a_second():
    """1000 N·s/m at 8 mm/s is 8 N; the power law has the same force at 10 mm/s."""
    np.testing.assert_allclose(columns("viscous_damping", moved())[:, 0] * 1000.0, [-8.0, 0.0, 2.0, 0.0])
    power = columns("viscous_damping:power", moved(), n=0.5)[:, 0] * 1000.0
    np.testing.assert_allclose(power, [-10.0 * 0.8**0.5, 0.0, 10.0 * 0.2**0.5, 0.0])
    thinning = columns("viscous_damping:thinning", moved(), v_1=8.0)[:, 0] * 1000.0
    np.testing.assert_allclose(thinning, [-4.0, 0.0, 1.6, 0.0])
    pressure = columns("viscous_damping:pressure", moved(), n=0.5) @ [1000.0, 400.0]
    np.testing.assert_allclose(pressure, power * 1.2)


# --- time, cycles, temperature -----------------------------------------------------------------------------------


def test_drift_is_counted_from_the_first_sample():
    given = inputs([0.1, 0.1, 0.1], time=[100.0, 130.0, 220.0])
    np.testing.assert_allclose(columns("force_drift", given)[:, 0], [0.0, 0.5, 2.0])
    settling = columns("force_drift:settling", given, tau=60.0)[:, 0]
    np.testing.assert_allclose(settling, [0.0, 1.0 - math.exp(-0.5), 1.0 - math.exp(-2.0)])
    logarithmic = columns("force_drift:logarithmic", given, tau=60.0)[:, 0]
    np.testing.assert_allclose(logarithmic, [0.0, math.log(1.5), math.log(3.0)])
    both = columns("force_drift:settling_on", given, tau=60.0)
    np.testing.assert_array_equal(both, np.column_stack([settling, [0.0, 0.5, 2.0]]))
    swinging = columns("force_drift:swinging", given, T=240.0)  # an eighth of a turn, then a half
    np.testing.assert_allclose(swinging, [[0.0, 0.0], [0.5**0.5, 1.0 - 0.5**0.5], [0.0, 2.0]], atol=1e-12)


def test_the_bias_of_a_load_cell_is_a_constant():
    np.testing.assert_array_equal(columns("force_bias", inputs())[:, 0], 1.0)


def test_mullins_softening_fades_with_the_number_of_the_cycle():
    given = inputs([0.1, 0.1, 0.1], cycle=[1.0, 2.0, 4.0])
    fading = np.exp([0.0, -0.5, -1.5])
    np.testing.assert_allclose(columns("mullins_softening", given, n_0=2.0)[:, 0], fading)
    got = force_with("mullins_softening", {"s": 0.1, "n_0": 2.0}, given)
    np.testing.assert_allclose(got, ideal(0.1, 0.4) * (1.0 + 0.1 * fading), rtol=1e-12)
    np.testing.assert_allclose(columns("mullins_softening:linear", given, n_0=2.0)[:, 1], -0.1 * fading)
    power = columns("mullins_softening:power", given, q=0.5)
    np.testing.assert_allclose(power, np.outer([1.0, 0.5**0.5, 0.5], [1.0, -0.1]))
    lost = columns("mullins_softening:logarithmic", given)
    np.testing.assert_allclose(lost, np.outer([0.0, -math.log(2.0), -math.log(4.0)], [1.0, -0.1]), atol=1e-15)
    stiffer = columns("mullins_softening:elastic", given, n_0=2.0)[:, 0]
    np.testing.assert_allclose(stiffer, columns("bladder_elasticity", given)[:, 0] * fading)


def test_thermal_softening_follows_the_warming_since_the_start():
    given = inputs([0.1, 0.1, 0.1], temperature=[20.0, 25.0, 18.0])
    got = force_with("thermal_softening", {"alpha": 0.01}, given)
    np.testing.assert_allclose(got, ideal(0.1, 0.4) * np.array([1.0, 0.95, 1.02]), rtol=1e-12)
    colder = force_with("thermal_softening:from_cold", {"alpha": 0.01, "T_c": 4.0}, given)
    np.testing.assert_allclose(colder, ideal(0.1, 0.4) * np.array([0.96, 0.91, 0.98]), rtol=1e-12)
    np.testing.assert_allclose(columns("thermal_softening:linear", given)[:, 0], [0.0, 0.5, -0.2])
    loss = columns("thermal_softening:elastic", given)[:, 0]
    np.testing.assert_allclose(loss, -columns("bladder_elasticity", given)[:, 0] * [0.0, 5.0, -2.0])
