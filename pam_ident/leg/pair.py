"""Two muscles over one sprocket, each behind a proportional pressure valve."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .anatomy import Leg, leg_of
from .arrays import Array, jnp
from .control import SIGN
from .leg_file import DEFAULT, Tables
from .muscle import ByBranch, Memory, Muscle
from .pneumatics import (
    ATMOSPHERE,
    GAS,
    Supply,
    Valve,
    braid_volume,
    gas_temperature,
    pressure_rate,
    valve_flow,
)


class Air(NamedTuple):
    """What the valves and the muscles' gas are in: absolute pressure (Pa), mass (kg), opening (−1 … 1), shape (2,)."""

    pressure: Array
    mass: Array
    opening: Array

    @property
    def gauge_MPa(self) -> Array:
        """Gauge pressure in MPa, shape (2,)."""
        return (self.pressure - ATMOSPHERE) * 1e-6


@dataclass(frozen=True, eq=False)
class Pair:
    """An antagonist pair, index 0 the flexor and 1 the extensor, equation (8)'s F1 and F2.

    `dead_volume_m3` is that of hose and fittings of one muscle. A valve opens in proportion to what its muscle's
    pressure is off the reference, fully at `full_open_MPa`. References stay between `lowest_MPa` and `highest_MPa`;
    `mean_MPa` is the pressure about which the pair is split, all gauge. `strength` is the share of the model's force
    that each muscle has; it decays at the rate `ageing_per_s`.
    """

    muscle: Muscle
    leg: Leg
    supply: Supply
    valve: Valve
    dead_volume_m3: float
    full_open_MPa: float
    mean_MPa: float
    lowest_MPa: float
    highest_MPa: float
    strength: tuple[float, float] = (1.0, 1.0)
    ageing_per_s: float = 0.0

    @property
    def reach_MPa(self) -> float:
        """Largest split on both sides of the mean."""
        return min(self.mean_MPa - self.lowest_MPa, self.highest_MPa - self.mean_MPa)

    def stroke(self, angle: Array, rate: Array) -> tuple[Array, Array]:
        """Contraction (2,) and its speed in mm/s (2,) at a sprocket angle (rad) and rate (rad/s)."""
        contraction = self.leg.contraction(angle, 1e-3 * self.muscle.specimen.initial_length_mm)
        return jnp.stack(contraction), SIGN * 1e3 * self.leg.sprocket_radius_m * rate

    def at_rest(self, gauge_MPa: Array, contraction: Array) -> Air:
        """Air at supply temperature and closed valves, arrays of shape (2,)."""
        pressure = gauge_MPa * 1e6 + ATMOSPHERE
        volume, _ = self.volume(contraction)
        return Air(pressure, pressure * volume / (GAS * self.supply.temperature_K), jnp.zeros(2))

    def volume(self, contraction: Array) -> tuple[Array, Array]:
        """Volume of muscle and hose in m³, and its slope over contraction, shape (2,) each."""
        return braid_volume(self.muscle.specimen, contraction, self.dead_volume_m3)

    def rates(self, air: Air, reference_Pa: Array, contraction: Array, speed: Array, flow: Array) -> Air:
        """Time derivatives of the air; `flow` scales the valves' area, `reference_Pa` (2,) is absolute."""
        volume, slope = self.volume(contraction)
        swell = slope * speed / self.muscle.specimen.initial_length_mm
        heat = gas_temperature(air.pressure, air.mass, volume)
        filling, venting = (flow * q for q in valve_flow(air.opening, air.pressure, heat, self.supply, self.valve))
        rise, gain = pressure_rate(air.pressure, air.mass, volume, swell, filling, venting, self.supply.temperature_K)
        wanted = jnp.clip((reference_Pa - air.pressure) * 1e-6 / self.full_open_MPa, -1.0, 1.0)
        return Air(rise, gain, (wanted - air.opening) / self.valve.lag_s)

    def pull(
        self, values: ByBranch, memory: Memory, time: Array, gauge_MPa: Array, contraction: Array, speed: Array
    ) -> tuple[Array, Memory]:
        """Forces in N (2,), never below zero because a chain cannot push, and the memory after it."""
        force, memory = self.muscle.force(values, memory, time, jnp.maximum(gauge_MPa, 0.0), contraction, speed)
        return jnp.maximum(force, 0.0) * np.array(self.strength) * jnp.exp(-self.ageing_per_s * time), memory

    def torque(self, force: Array) -> Array:
        """Torque of the forces (2,) in N on the sprocket in N·m, positive flexes."""
        return (force[0] - force[1]) * self.leg.sprocket_radius_m


def pair_of(muscle: Muscle, tables: Tables = DEFAULT) -> Pair:
    """Two such muscles in the leg of a file, by default the leg's own. Raises UsageError for a knee that cannot be."""
    air, supply, valve = (tables[name] for name in ("muscles", "supply", "valve"))
    return Pair(
        muscle,
        leg_of(tables),
        Supply(supply["pressure_MPa"] * 1e6 + ATMOSPHERE, supply["temperature_K"]),
        Valve(valve["area_mm2"] * 1e-6, valve["critical_ratio"], valve["lag_s"]),
        air["dead_volume_m3"],
        valve["full_open_MPa"],
        air["mean_MPa"],
        air["lowest_MPa"],
        air["highest_MPa"],
    )
