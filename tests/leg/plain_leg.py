"""The leg a second time, in plain floats and by another way: rigid-body accelerations in place of Lagrange's equation,
circles in place of the closed form, the gas by its energy. For tests and benchmarks alone."""

import cmath
import math
from dataclasses import dataclass

ATMOSPHERE, GAS, KAPPA, GRAVITY = 101325.0, 287.0, 1.4, 9.81


@dataclass
class PlainLeg:
    """An exponential law with linear damping and smoothed dry friction drives the leg of `pam_ident.leg.anatomy`.

    State: flexion, rate, pressures (2, Pa absolute), masses (2, kg), openings (2).
    """

    leg: object
    supply: object
    valve: object
    law: dict
    damping: float
    friction: float
    radius_mm: float
    length_mm: float
    angle_deg: float
    dead_m3: float
    full_open_Pa: float
    force_scale: float = 1.0
    inertia_scale: float = 1.0
    flow_scale: float = 1.0

    def __post_init__(self):
        knee = self.leg.knee
        self.a, self.b = knee.crank_thigh, knee.rocker_thigh
        self.c0, self.d0 = knee.crank_shank, knee.rocker_shank
        self.crank, self.rocker = abs(self.c0 - self.a), abs(self.d0 - self.b)
        self.start = cmath.phase(self.c0 - self.a)
        straight = self.b - (self.d0 - self.c0) - self.a
        self.side = math.copysign(1.0, (straight.conjugate() * (self.c0 - self.a)).imag)

    def linkage(self, flexion):
        """Pivot on the shank C, unit turn of the shank, crank and rocker angles: where two circles meet."""
        turn = cmath.exp(-1j * flexion)
        other = self.b - turn * (self.d0 - self.c0)  # C lies on a circle about A and on one about this point
        line = other - self.a
        distance = abs(line)
        along = (distance**2 + self.crank**2 - self.rocker**2) / (2.0 * distance)
        height = math.sqrt(self.crank**2 - along**2)
        c = self.a + line / distance * complex(along, self.side * height)
        return c, turn, c - self.a, c - other

    def rates_of_links(self, u, v, turn, shank_rate, shank_acceleration):
        """Angular rates and accelerations of crank and rocker from the closed loop A→C→D→B."""
        w = turn * (self.d0 - self.c0)
        determinant = (u.conjugate() * v).imag

        def solve(right):  # x i u − y i v = right, for real x and y
            right = right / 1j
            return (right.conjugate() * v).imag / -(v.conjugate() * u).imag, (u.conjugate() * right).imag / -determinant

        x, y = solve(-1j * shank_rate * w)
        right = -(1j * shank_acceleration - shank_rate**2) * w + x * x * u - y * y * v
        ax, ay = solve(right)
        return x, y, ax, ay

    def sprocket(self, flexion):
        """Turn of the crank from the straight leg, and its derivative by the flexion."""
        _, turn, u, v = self.linkage(flexion)
        x, *_ = self.rates_of_links(u, v, turn, -1.0, 0.0)
        return -math.remainder(cmath.phase(u) - self.start, 2.0 * math.pi), -x

    def flexion_acceleration(self, flexion, rate, torque, hip, ankle):
        """φ̈: power of all inertial and applied forces under a unit rate of flexion vanishes (Jourdain)."""
        leg = self.leg
        c, turn, u, v = self.linkage(flexion)
        unit_x, unit_y, *_ = self.rates_of_links(u, v, turn, -1.0, 0.0)
        x, y, ax, ay = self.rates_of_links(u, v, turn, -rate, 0.0)
        hip_angle, hip_rate, hip_acc = hip
        up = 1j * GRAVITY * cmath.exp(-1j * hip_angle)
        knee = -1j * leg.thigh.length_m

        def felt(place, velocity, acceleration):
            return acceleration + 2j * hip_rate * velocity + (1j * hip_acc - hip_rate**2) * place + up

        inertia, bias = 0.0, 0.0

        def add(mass, place, unit, velocity, acceleration):
            nonlocal inertia, bias
            inertia += mass * abs(unit) ** 2
            bias += mass * (unit.conjugate() * felt(place, velocity, acceleration)).real

        def on_shank(arm):  # of a point fixed to the shank at `arm` from C
            return (
                knee + c + arm,
                1j * unit_x * u - 1j * arm,
                1j * x * u - 1j * rate * arm,
                (1j * ax - x * x) * u - rate * rate * arm,
            )

        add(leg.shank.mass_kg, *on_shank(turn * (leg.shank.centre_m - self.c0)))
        place, unit, velocity, acceleration = on_shank(turn * (-1j * leg.shank.length_m - self.c0))
        foot = turn * cmath.exp(1j * ankle[0]) * leg.foot.centre_m
        spin = ankle[1] - rate
        add(
            leg.foot.mass_kg + leg.load_mass_kg,
            place + foot,
            unit - 1j * foot,
            velocity + 1j * spin * foot,
            acceleration + (1j * ankle[2] - spin * spin) * foot,
        )
        half = 0.5 * u
        add(leg.crank_mass_kg, knee + self.a + half, 1j * unit_x * half, 1j * x * half, (1j * ax - x * x) * half)
        half = 0.5 * v
        add(leg.rocker_mass_kg, knee + self.b + half, 1j * unit_y * half, 1j * y * half, (1j * ay - y * y) * half)
        crank_inertia = leg.crank_mass_kg * self.crank**2 / 12.0 + leg.sprocket_inertia_kg_m2
        rocker_inertia = leg.rocker_mass_kg * self.rocker**2 / 12.0
        shank_inertia, foot_inertia = leg.shank.inertia_kg_m2, leg.foot.inertia_kg_m2
        inertia += shank_inertia + foot_inertia + crank_inertia * unit_x**2 + rocker_inertia * unit_y**2
        bias += -shank_inertia * hip_acc - foot_inertia * (hip_acc + ankle[2])
        bias += crank_inertia * unit_x * (ax + hip_acc) + rocker_inertia * unit_y * (ay + hip_acc)
        return (torque * -unit_x + self.passive(flexion, rate) - bias) / inertia

    def passive(self, flexion, rate):
        """Damping, stops and load."""
        leg = self.leg
        push = 0.0
        for passed, sign in ((leg.stops_rad[0] - flexion, 1.0), (flexion - leg.stops_rad[1], -1.0)):
            if passed > 0.0:
                push += sign * passed * passed / (passed + leg.stop_width_rad)
        return leg.stop_stiffness_N_m * push - leg.damping_N_m_s * rate + leg.load_torque_N_m

    def pull(self, gauge_MPa, contraction, speed_mm_s):
        """Force of a muscle in N, never below zero."""
        q = self.law
        force = q["a0"] + q["a1"] * gauge_MPa - (q["b0"] + q["b1"] * gauge_MPa) * contraction
        force += (q["c0"] + q["c1"] * gauge_MPa) * math.exp(-q["mu"] * contraction)
        force -= self.damping * 1e-3 * speed_mm_s + self.friction * math.tanh(speed_mm_s / 0.2)
        return max(force, 0.0)

    def volume(self, contraction):
        """Volume of a muscle and its hose in m³, and its slope over contraction."""
        cos, sin = math.cos(math.radians(self.angle_deg)), math.sin(math.radians(self.angle_deg))
        stretch = 1.0 - contraction
        front = math.pi * self.radius_mm**2 * self.length_mm * 1e-9 / sin**2
        return (
            front * stretch * (1.0 - (stretch * cos) ** 2) + self.dead_m3,
            -front * (1.0 - 3.0 * (stretch * cos) ** 2),
        )

    def orifice(self, up_Pa, up_K, down_Pa, area):
        """(10) and (11), straight in the last thousandth of the pressure ratio."""
        ratio, critical = down_Pa / up_Pa, self.valve.critical_ratio
        if ratio >= 1.0:
            return 0.0
        edge = 0.999
        if ratio > edge:
            share = math.sqrt(1.0 - ((edge - critical) / (1.0 - critical)) ** 2) * (1.0 - ratio) / (1.0 - edge)
        else:
            share = 1.0 if ratio <= critical else math.sqrt(1.0 - ((ratio - critical) / (1.0 - critical)) ** 2)
        return area * up_Pa * math.sqrt(1.0 - critical) * share / math.sqrt(GAS * up_K)

    def slope(self, state, reference_Pa, hip, ankle):
        """Time derivative of the state."""
        flexion, rate = state[0], state[1]
        angle, ratio = self.sprocket(flexion)
        rates = [rate, 0.0] + [0.0] * 6
        forces = []
        for k, sign in enumerate((1.0, -1.0)):
            pressure, mass, opening = state[2 + k], state[4 + k], state[6 + k]
            contraction = (
                self.leg.rest_contraction[k] + sign * self.leg.sprocket_radius_m * angle * 1e3 / self.length_mm
            )
            speed = sign * self.leg.sprocket_radius_m * ratio * rate * 1e3
            volume, grow = self.volume(contraction)
            swell = grow * speed / self.length_mm
            heat = pressure * volume / (mass * GAS)
            area = abs(max(-1.0, min(opening, 1.0))) * self.flow_scale * self.valve.area_m2
            if opening > 0.0:
                flow = self.orifice(self.supply.pressure_Pa, self.supply.temperature_K, pressure, area)
                enthalpy = flow * self.supply.temperature_K
            else:
                flow = -self.orifice(pressure, heat, self.supply.exhaust_Pa, area)
                enthalpy = flow * heat
            rates[2 + k] = KAPPA * (GAS * enthalpy - pressure * swell) / volume
            rates[4 + k] = flow
            wanted = max(-1.0, min((reference_Pa[k] - pressure) / self.full_open_Pa, 1.0))
            rates[6 + k] = (wanted - opening) / self.valve.lag_s
            gauge = max((pressure - ATMOSPHERE) * 1e-6, 0.0)
            forces.append(self.pull(gauge, contraction, speed) * self.force_scale)
        torque = (forces[0] - forces[1]) * self.leg.sprocket_radius_m / self.inertia_scale
        rates[1] = self.flexion_acceleration(flexion, rate, torque, hip, ankle)
        return rates
