"""The plain leg under control: gait, PID, sampled loop, and an example muscle, in plain floats. For tests and
benchmarks alone."""

import cmath
import math
from dataclasses import dataclass

from plain_leg import ATMOSPHERE, GAS, PlainLeg


class PlainGait:
    """Fourier sums of `pam_ident.leg.gait.Gait`, asked one float at a time."""

    def __init__(self, gait):
        self.omega = 2.0 * math.pi * gait.cadence_Hz
        self.series = [
            [(n * self.omega, c, s) for n, (c, s) in enumerate(zip(*rows, strict=True))]
            for rows in zip(gait.cosines.tolist(), gait.sines.tolist(), strict=True)
        ]

    def knee(self, time):
        """Flexion wanted."""
        return sum(c * math.cos(w * time) + s * math.sin(w * time) for w, c, s in self.series[0])

    def hip_and_ankle(self, time):
        """Angle, rate and acceleration of each."""
        turn = cmath.exp(1j * self.omega * time)
        powers, power = [], 1.0 + 0.0j
        for _ in self.series[0]:
            powers.append(power)
            power *= turn
        found = []
        for series in self.series[1:]:
            angle = rate = acceleration = 0.0
            for (w, c, s), power in zip(series, powers, strict=True):
                cos, sin = power.real, power.imag
                angle += c * cos + s * sin
                rate += w * (s * cos - c * sin)
                acceleration -= w * w * (c * cos + s * sin)
            found.append((angle, rate, acceleration))
        return found


@dataclass
class PlainPid:
    """The controller, one float at a time: split of the pair's gauge pressures from the angle and what is wanted."""

    kp: float
    ki: float
    kd: float
    mean_MPa: float = 0.315
    lowest_MPa: float = 0.03
    highest_MPa: float = 0.6
    every_s: float = 0.005
    filter_s: float = 0.01

    def begin(self, error):
        """At rest."""
        self.whole, self.last, self.slope = 0.0, error, 0.0

    def references(self, error):
        """Absolute pressures in Pa; nothing is known ahead, the split waits at its limits."""
        share = self.every_s / (self.filter_s + self.every_s)
        self.slope = (1.0 - share) * self.slope + share * (error - self.last) / self.every_s
        self.last = error
        whole = self.whole + self.every_s * error
        wanted = self.kp * error + self.ki * whole + self.kd * self.slope
        reach = min(self.mean_MPa - self.lowest_MPa, self.highest_MPa - self.mean_MPa)
        if abs(wanted) <= reach or wanted * error <= 0.0:
            self.whole = whole
        split = max(-reach, min(wanted, reach))
        return [
            max(self.lowest_MPa, min(self.mean_MPa + sign * split, self.highest_MPa)) * 1e6 + ATMOSPHERE
            for sign in (1.0, -1.0)
        ]


def closed_loop(plant, gait, pid, samples, advance):
    """States (samples, 8) at the samples of control, the angle read without steps. `advance(slope, t0, t1, state)`
    integrates `slope(t, state)`."""
    every = pid.every_s
    first = gait.knee(0.0)
    angle, _ = plant.sprocket(first)
    pressure = pid.mean_MPa * 1e6 + ATMOSPHERE
    state = [first, (gait.knee(every) - first) / every, pressure, pressure]
    for k, sign in enumerate((1.0, -1.0)):
        turned = plant.leg.sprocket_radius_m * angle * 1e3 / plant.length_mm
        volume, _ = plant.volume(plant.leg.rest_contraction[k] + sign * turned)
        state.append(pressure * volume / (GAS * plant.supply.temperature_K))
    state += [0.0, 0.0]
    pid.begin(0.0)
    rows = []
    for k in range(samples):
        rows.append(list(state))
        reference = pid.references(gait.knee(k * every) - state[0])

        def slope(time, y, reference=reference):
            return plant.slope(y, reference, *gait.hip_and_ankle(time))

        state = advance(slope, k * every, (k + 1) * every, state)
    return rows


def runge_kutta(slope, begin, end, state, steps=10):
    """Classical, of fourth order."""
    h = (end - begin) / steps
    for i in range(steps):
        t = begin + i * h
        a = slope(t, state)
        b = slope(t + h / 2, [y + h / 2 * d for y, d in zip(state, a, strict=True)])
        c = slope(t + h / 2, [y + h / 2 * d for y, d in zip(state, b, strict=True)])
        d = slope(t + h, [y + h * d for y, d in zip(state, c, strict=True)])
        rows = zip(state, a, b, c, d, strict=True)
        state = [y + h / 6 * (e + 2 * f + 2 * g + q) for y, e, f, g, q in rows]
    return state


def smooth_example(damping=400.0, **changes):
    """A muscle without friction whose slopes have no corner but the valves', in floats and as `pam_ident` has it."""
    from dataclasses import replace

    from pam_ident.core import Specimen
    from pam_ident.leg.muscle import Muscle
    from pam_ident.leg.pair import pair_of
    from pam_ident.model import Model

    law = {"a0": -150.0, "a1": 2400.0, "b0": 900.0, "b1": 5500.0, "c0": 20.0, "c1": 690.0, "mu": 45.0}
    values = {**law, "viscous_damping.B": damping}
    specimen = Specimen("made", 200.0, 10.0, 25.4, 1.5)
    model = Model.build("exponential_law", ("viscous_damping",))
    pair = replace(pair_of(Muscle(model, specimen, values, values)), **changes)
    plain = PlainLeg(
        leg=pair.leg,
        supply=pair.supply,
        valve=pair.valve,
        law=law,
        damping=damping,
        friction=0.0,
        radius_mm=specimen.initial_radius_mm,
        length_mm=specimen.initial_length_mm,
        angle_deg=specimen.braid_angle_deg,
        dead_m3=pair.dead_volume_m3,
        full_open_Pa=pair.full_open_MPa * 1e6,
    )
    return pair, plain
