"""Air against closed forms: adiabats, energy, a chamber that fills, the virtual work of the braid."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pam_ident.core import DataError, Specimen
from pam_ident.laws import get_law
from pam_ident.leg.arrays import jax, jnp
from pam_ident.leg.pneumatics import (
    ATMOSPHERE,
    GAS,
    KAPPA,
    LAMINAR,
    Supply,
    Valve,
    braid_volume,
    flow,
    gas_temperature,
    pressure_rate,
    valve_flow,
)

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)
SUPPLY = Supply(7e5, 293.15)
VALVE = Valve(1e-6, 0.3, 0.003)
RATE = jax.jit(pressure_rate)
VALVE_FLOW = jax.jit(valve_flow, static_argnums=(3, 4))


def stroke(t):
    """Contraction 0.02 to 0.22 and back within 0.4 s, and its rate."""
    w = 2.0 * math.pi / 0.4
    return 0.12 - 0.1 * math.cos(w * t), 0.1 * w * math.sin(w * t)


def integrate(opening, y0, t_end=0.4, volume=None):
    """Pressure and mass of a muscle that is moved along `stroke` (or of a fixed volume), with the enthalpy that came in
    and went out and the work done by the gas: (p, m, H, W)."""

    def rate(t, y):
        p, m = y[:2]
        if volume is None:
            e, e_dot = stroke(t)
            v, slope = (float(x) for x in braid_volume(MUSCLE, e))
            v_dot = slope * e_dot
        else:
            v, v_dot = volume, 0.0
        temperature = float(gas_temperature(p, m, v))
        q_in, q_out = (float(q) for q in VALVE_FLOW(opening, p, temperature, SUPPLY, VALVE))
        p_dot, m_dot = (float(x) for x in RATE(p, m, v, v_dot, q_in, q_out, SUPPLY.temperature_K))
        cp = KAPPA / (KAPPA - 1.0) * GAS
        return p_dot, m_dot, cp * (SUPPLY.temperature_K * q_in - temperature * q_out), p * v_dot

    return solve_ivp(rate, (0.0, t_end), y0, method="DOP853", rtol=1e-10, atol=1e-12, max_step=0.02)


def test_closed_air_follows_the_adiabat():
    v0 = float(braid_volume(MUSCLE, stroke(0.0)[0])[0])
    p0 = 4e5
    m0 = p0 * v0 / (GAS * 300.0)
    run = integrate(0.0, (p0, m0, 0.0, 0.0))
    volume = np.array([float(braid_volume(MUSCLE, stroke(t)[0])[0]) for t in run.t])
    np.testing.assert_allclose(run.y[0] * volume**KAPPA, p0 * v0**KAPPA, rtol=1e-6)
    assert np.all(run.y[1] == m0) and run.y[0].min() < 0.55 * p0


@pytest.mark.parametrize("opening", [0.3, -0.3])
def test_energy_and_mass_balance_with_flow(opening):
    """d(pV/(κ−1)) = enthalpy in less enthalpy out less work: the first law, from quantities summed up apart."""
    v0 = float(braid_volume(MUSCLE, stroke(0.0)[0])[0])
    p0 = 3e5
    run = integrate(opening, (p0, p0 * v0 / (GAS * 293.15), 0.0, 0.0))
    p, m, enthalpy, work = run.y[:, -1]
    v = float(braid_volume(MUSCLE, stroke(run.t[-1])[0])[0])
    before, after = p0 * v0 / (KAPPA - 1.0), p * v / (KAPPA - 1.0)
    assert after - before == pytest.approx(enthalpy - work, abs=1e-8 * abs(before))
    assert abs(enthalpy) > 0.2 * before
    assert abs(m / run.y[1, 0] - 1.0) > 0.1 and (m > run.y[1, 0]) == (opening > 0)


def test_air_that_flows_in_adiabatically_ends_hotter_than_its_source():
    """A vessel filled from nothing: T = κ T_s, whatever the valve; here from 1 % of the end pressure."""
    v, p0 = 5e-5, 2e3
    m0 = p0 * v / (GAS * 293.15)
    run = integrate(1.0, (p0, m0, 0.0, 0.0), t_end=0.05, volume=v)
    p, m = run.y[:2, -1]
    energy = (p - p0) * v / (KAPPA - 1.0)
    assert energy == pytest.approx(KAPPA / (KAPPA - 1.0) * GAS * SUPPLY.temperature_K * (m - m0), rel=1e-9)
    assert p * v / (m * GAS) == pytest.approx(KAPPA * SUPPLY.temperature_K, rel=0.01)


def test_a_fixed_volume_fills_along_the_analytic_curve():
    """With q of (10) in (9) at V̇ = 0: σ̇ = ω(σ)/τ, τ = V/(κ A √((1−b) R T_s)). Choked, σ grows in a straight line to b;
    then ∫dσ/√(1 − ((σ−b)/(1−b))²) = (1−b) asin((σ−b)/(1−b)) gives σ = b + (1−b) sin((t − t_b)/((1−b) τ))."""
    v, b, p_s = 5e-5, VALVE.critical_ratio, SUPPLY.pressure_Pa
    tau = v / (KAPPA * VALVE.area_m2 * math.sqrt((1.0 - b) * GAS * SUPPLY.temperature_K))
    start = ATMOSPHERE / p_s
    t_b = (b - start) * tau
    assert t_b > 0.0
    t_line = t_b + (1.0 - b) * tau * math.asin((LAMINAR - b) / (1.0 - b))
    first = (ATMOSPHERE, ATMOSPHERE * v / (GAS * 293.15), 0.0, 0.0)

    def rate(t, y):
        q = float(flow(p_s, SUPPLY.temperature_K, y[0], VALVE.area_m2, b))
        return [float(x) for x in RATE(y[0], y[1], v, 0.0, q, 0.0, SUPPLY.temperature_K)]

    times = np.linspace(0.0, t_line, 60)
    run = solve_ivp(rate, (0.0, t_line), first[:2], method="DOP853", rtol=1e-11, atol=1e-12, t_eval=times)
    angle = np.clip((times - t_b) / ((1.0 - b) * tau), 0.0, math.pi / 2)
    curve = np.where(times < t_b, start + times / tau, b + (1.0 - b) * np.sin(angle))
    np.testing.assert_allclose(run.y[0] / p_s, curve, rtol=1e-6)
    assert run.y[0, -1] / p_s == pytest.approx(LAMINAR, rel=1e-6)


def test_the_flow_is_choked_falls_along_the_ellipse_and_ends_in_a_line():
    ratio = np.array([0.0, 0.2, 0.3, 0.65, 0.9995, 1.0, 1.3])
    got = np.asarray(flow(6e5, 300.0, 6e5 * ratio, 2e-6, 0.3))
    full = 2e-6 * 6e5 * math.sqrt(0.7) / math.sqrt(287.0 * 300.0)
    edge = math.sqrt(1.0 - ((0.999 - 0.3) / 0.7) ** 2)
    expected = [1.0, 1.0, 1.0, math.sqrt(0.75), 0.5 * edge, 0.0, 0.0]
    np.testing.assert_allclose(got, full * np.array(expected), rtol=1e-9, atol=1e-15)


def test_the_choked_flow_is_near_that_of_an_ideal_nozzle():
    """√(1−b) stands for √κ (2/(κ+1))^((κ+1)/(2(κ−1))) = 0.6847 at the nozzle's own ratio 0.528."""
    nozzle = math.sqrt(KAPPA) * (2.0 / (KAPPA + 1.0)) ** ((KAPPA + 1.0) / (2.0 * (KAPPA - 1.0)))
    ours = float(flow(6e5, 300.0, 1e5, 1e-6, 0.528)) / (1e-6 * 6e5 / math.sqrt(GAS * 300.0))
    assert ours == pytest.approx(nozzle, rel=0.005)


def test_the_valve_opens_to_one_side_at_a_time_and_no_further_than_full():
    def asked(opening, p=4e5):
        return tuple(float(q) for q in valve_flow(opening, p, 300.0, SUPPLY, VALVE))

    assert asked(0.0) == (0.0, 0.0)
    assert asked(0.5)[0] == pytest.approx(0.5 * asked(1.0)[0], rel=1e-12) and asked(0.5)[1] == 0.0
    assert asked(-0.5)[1] == pytest.approx(0.5 * asked(-1.0)[1], rel=1e-12) and asked(-0.5)[0] == 0.0
    assert asked(1.0)[0] > 0.0 and asked(7.0) == asked(1.0) and asked(-7.0) == asked(-1.0)
    assert asked(1.0, p=8e5)[0] == 0.0 and asked(-1.0, p=1e5)[1] == 0.0


@pytest.mark.parametrize("e", [-0.02, 0.0, 0.1, 0.25])
def test_the_volume_gives_the_ideal_force_by_virtual_work(e):
    p_MPa = 0.4
    volume, slope = braid_volume(MUSCLE, jnp.asarray(e), 2e-6)
    force = p_MPa * 1e6 * float(slope) / 0.2
    ideal = get_law("chou_hannaford").force(np.array([p_MPa]), np.array([e]), MUSCLE, {})
    assert force == pytest.approx(float(ideal[0]), rel=1e-12)
    cylinder = math.pi * (0.01 * float(MUSCLE.radius_ratio(np.array(e)))) ** 2 * 0.2 * (1.0 - e)
    assert float(volume) == pytest.approx(cylinder + 2e-6, rel=1e-12)
    h = 1e-6
    by_steps = float(braid_volume(MUSCLE, e + h)[0] - braid_volume(MUSCLE, e - h)[0]) / (2.0 * h)
    assert float(slope) == pytest.approx(by_steps, rel=1e-7)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Supply(1e5, 293.0), "above the exhaust"),
        (lambda: Supply(7e5, -20.0), "in K"),
        (lambda: Valve(0.0, 0.3, 0.0), "area"),
        (lambda: Valve(1e-6, 1.0, 0.0), "ratio"),
        (lambda: Valve(1e-6, 0.3, -1.0), "lag"),
    ],
)
def test_air_that_cannot_be_is_refused(make, told):
    with pytest.raises(DataError, match=told):
        make()
