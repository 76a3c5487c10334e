"""The reduced joint against equations of motion that autodiff makes from energies and a root finder's linkage."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pam_ident.leg import gait as gaits
from pam_ident.leg.anatomy import LEG
from pam_ident.leg.arrays import jax, jnp
from pam_ident.leg.gait import LegAngles, Swing
from pam_ident.leg.joint import acceleration, inverse, passive_torque

GAIT = gaits.winter()
LOADED = replace(LEG, load_mass_kg=1.5, load_torque_N_m=2.0)
OILED = replace(LEG, damping_N_m_s=4.0)
"""Enough damping that a torque given in advance keeps the knee between its stops."""
REST = LegAngles(*[Swing(0.0, 0.0, 0.0)] * 3)


def turned(angle, point):
    return (jnp.cos(angle) + 1j * jnp.sin(angle)) * point


def shank_origin(flexion):
    """Newton's method on the lengths of both links, from a straight line through the path; complex.

    From the root, one step is exact in the first derivative and a second one up to the third.
    """
    pairs = ((LEG.knee.crank_thigh, LEG.knee.crank_shank), (LEG.knee.rocker_thigh, LEG.knee.rocker_shank))

    def newton(q, flexion):
        ends = [q[0] + 1j * q[1] + turned(-flexion, shank) - thigh for thigh, shank in pairs]
        gaps = [z.real**2 + z.imag**2 - abs(shank - thigh) ** 2 for z, (thigh, shank) in zip(ends, pairs, strict=True)]
        (a, b), (c, d) = ((2.0 * z.real, 2.0 * z.imag) for z in ends)
        return q - jnp.array([d * gaps[0] - b * gaps[1], a * gaps[1] - c * gaps[0]]) / (a * d - b * c)

    still = jax.lax.stop_gradient(flexion)
    root = jax.lax.fori_loop(0, 8, lambda _, q: newton(q, still), jnp.array([0.008, -0.011]) * still)
    q = newton(newton(root, flexion), flexion)
    return q[0] + 1j * q[1]


def angle_of(z):
    return jnp.arctan2(z.imag, z.real)


def places(leg, flexion, hip, ankle):
    """Mass centres in the world (4,), complex, and orientations (4,) of shank, foot, crank, rocker."""
    beta = hip - flexion
    knee = turned(hip, -1j * leg.thigh.length_m)
    origin = knee + turned(hip, shank_origin(flexion))
    foot = origin + turned(beta, -1j * leg.shank.length_m) + turned(beta + ankle, leg.foot.centre_m)
    centres, angles = [origin + turned(beta, leg.shank.centre_m), foot], [beta, beta + ankle]
    for thigh, shank in ((leg.knee.crank_thigh, leg.knee.crank_shank), (leg.knee.rocker_thigh, leg.knee.rocker_shank)):
        pivot, end = knee + turned(hip, thigh), origin + turned(beta, shank)
        centres.append(0.5 * (pivot + end))
        angles.append(angle_of(end - pivot))
    return jnp.array(centres), jnp.array(angles)


def energies(leg, gait, flexion, rate, time):
    """Kinetic and potential energy of all that moves with φ, J."""
    long, _, short, _ = leg.knee.lengths
    crank = leg.crank_mass_kg * long**2 / 12.0 + leg.sprocket_inertia_kg_m2
    rocker = leg.rocker_mass_kg * short**2 / 12.0
    masses = jnp.array([leg.shank.mass_kg, leg.foot.mass_kg + leg.load_mass_kg, leg.crank_mass_kg, leg.rocker_mass_kg])
    inertias = jnp.array([leg.shank.inertia_kg_m2, leg.foot.inertia_kg_m2, crank, rocker])

    def state(x, t):
        motion = gait.at(t) if gait else REST
        return places(leg, x, motion.hip.angle, motion.ankle.angle)

    (centres, _), (velocities, spins) = jax.jvp(state, (flexion, time), (rate, jnp.ones_like(rate)))
    kinetic = 0.5 * jnp.sum(masses * (velocities.real**2 + velocities.imag**2) + inertias * spins**2)
    return kinetic, 9.81 * jnp.sum(masses * centres.imag)


def energy(leg, path):
    """Kinetic energy and the sum of both along states (n, 2) while the hip rests, J; (n,) each."""
    one = jax.jit(jax.vmap(lambda y: jnp.stack(energies(leg, None, y[0], y[1], jnp.asarray(0.0)))))
    kinetic, potential = np.transpose(one(jnp.asarray(path)))
    return kinetic, kinetic + potential


def lagrange(gait, torque):
    """Slope (t, y, load mass, load torque) of y = (φ, φ̇) from a Lagrangian L and the force Q by virtual work:
    φ̈ = (Q + ∂L/∂φ − ∂²L/∂φ̇∂φ φ̇ − ∂²L/∂φ̇∂t) / (∂²L/∂φ̇²), derivatives by autodiff."""

    def crank_angle(x):
        return angle_of(shank_origin(x) + turned(-x, LEG.knee.crank_shank) - LEG.knee.crank_thigh)

    @jax.jit
    def slope(t, y, mass, load):
        leg = replace(OILED, load_mass_kg=mass, load_torque_N_m=load)

        def action(at):
            kinetic, potential = energies(leg, gait, *at)
            return kinetic - potential

        def slopes(at):
            found = jax.jacfwd(action)(at)
            return found, found

        curved, (along, *_) = jax.jacfwd(slopes, has_aux=True)(jnp.array([*y, t]))
        mixed, inertia, drift = curved[1]
        force = -torque(t) * jax.jacfwd(crank_angle)(y[0]) + passive_torque(leg, *y)
        return jnp.array([y[1], (force + along - mixed * y[1] - drift) / inertia])

    return slope


def torque_of(t):
    return 8.0 + 6.0 * jnp.sin(2.0 * jnp.pi * t) + 3.0 * jnp.sin(6.0 * jnp.pi * t + 1.0)


def rk4(slope, start, step, n):
    """The plant's own way to step: fixed Runge–Kutta in a scan; states (n + 1, 2)."""

    def advance(y, t):
        a = slope(t, y)
        b = slope(t + step / 2, y + step / 2 * a)
        c = slope(t + step / 2, y + step / 2 * b)
        d = slope(t + step, y + step * c)
        new = y + step / 6 * (a + 2 * b + 2 * c + d)
        return new, new

    _, path = jax.lax.scan(advance, jnp.asarray(start), step * jnp.arange(n))
    return np.vstack([start, path])


@pytest.fixture(scope="module")
def other_slope():
    return lagrange(GAIT, torque_of)


@pytest.mark.long
@pytest.mark.parametrize(("mass", "load"), [(0.0, 0.0), (1.5, 2.0)], ids=["bare", "loaded"])
def test_a_second_of_gait_agrees_with_lagrange_by_autodiff(other_slope, mass, load):
    leg, start = replace(OILED, load_mass_kg=mass, load_torque_N_m=load), np.array([0.2, 0.0])

    def others(t, y):
        return np.asarray(other_slope(np.float64(t), y, mass, load))

    def mine(t, y):
        return jnp.array([y[1], acceleration(leg, y[0], y[1], torque_of(t), GAIT.at(t))])

    other = solve_ivp(others, (0.0, 1.0), start, "DOP853", rtol=1e-10, atol=1e-12)
    path = rk4(mine, start, 5e-4, 2000)
    assert np.ptp(path[:, 0]) > 0.3
    assert np.degrees(path[:, 0]).min() > -9.0 and np.degrees(path[:, 0]).max() < 80.0
    assert path[-1, 0] == pytest.approx(other.y[0, -1], abs=1e-6)
    assert path[-1, 1] == pytest.approx(other.y[1, -1], abs=1e-5)


@pytest.mark.long
def test_energy_is_kept_without_damping_while_the_hip_rests():
    free = replace(LEG, damping_N_m_s=0.0, stop_stiffness_N_m=0.0)

    def slope(t, y):
        return jnp.array([y[1], acceleration(free, y[0], y[1], 0.0, REST)])

    path = rk4(slope, np.array([np.radians(70.0), 0.0]), 5e-4, 700)
    kinetic, total = energy(free, path[::50])
    assert kinetic.max() > 3.0
    assert np.ptp(total) < 1e-7 * kinetic.max()


@pytest.mark.long
def test_damping_takes_what_it_should():
    still = replace(LEG, stop_stiffness_N_m=0.0)

    def slope(t, y):
        return jnp.array([y[1], acceleration(still, y[0], y[1], 0.0, REST)])

    path = rk4(slope, np.array([np.radians(70.0), 0.0]), 5e-4, 600)
    before, after = energy(still, path[[0, -1]])[1]
    lost = LEG.damping_N_m_s * np.trapezoid(path[:, 1] ** 2, dx=5e-4)
    assert before - after == pytest.approx(lost, rel=1e-5)


def test_inverse_undoes_acceleration():
    rng = np.random.default_rng(3)
    flexion, rate = rng.uniform(-0.05, 1.3, 50), rng.normal(0.0, 5.0, 50)
    wanted, motion = rng.normal(0.0, 50.0, 50), GAIT.at(rng.uniform(0.0, 1.0, 50))
    torque = inverse(LOADED, flexion, rate, wanted, motion)
    np.testing.assert_allclose(acceleration(LOADED, flexion, rate, torque, motion), wanted, atol=1e-9)


def test_hanging_still_needs_the_torque_of_the_weight():
    """At rest the sprocket holds the weight about the instantaneous centre, less the links' small share."""
    light = replace(LEG, crank_mass_kg=0.0, rocker_mass_kg=0.0, damping_N_m_s=0.0)
    flexion = np.radians(45.0)
    posture = light.knee.at(flexion)
    shank = posture.knee[0] + np.exp(-1j * flexion) * light.shank.centre_m
    foot = posture.knee[0] + np.exp(-1j * flexion) * (light.foot.centre_m - 1j * light.shank.length_m)
    moment = 9.81 * sum(
        m * (posture.centre - place).real for m, place in ((light.shank.mass_kg, shank), (light.foot.mass_kg, foot))
    )
    held = float(inverse(light, flexion, 0.0, 0.0, REST))
    assert held * posture.ratio == pytest.approx(moment, rel=1e-9)


def test_stops_push_back_and_let_the_range_free():
    torque = passive_torque(LEG, np.radians(np.array([-6.0, -5.0, 40.0, 78.0, 80.0])), 0.0)
    np.testing.assert_allclose(torque, [5000.0 * np.radians(1.0 / 1.1), 0.0, 0.0, 0.0, -5000.0 * np.radians(4.0 / 2.1)])
    assert passive_torque(LOADED, 0.5, 2.0) == pytest.approx(2.0 - 0.5 * 2.0, abs=1e-6)
