"""Two muscles over one sprocket, each behind a proportional pressure valve."""

from dataclasses import dataclass
from typing import NamedTuple

from .anatomy import LEG, Leg
from .arrays import Array, jnp
from .control import SIGN
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

SUPPLY = Supply(pressure_Pa=0.7e6 + ATMOSPHERE, temperature_K=293.15, exhaust_Pa=ATMOSPHERE)
VALVE = Valve(area_m2=5.7e-6, critical_ratio=0.35, lag_s=0.004)
"""350 l/min from 6 to 5 bar (gauge), as the data sheet of Festo's proportional valve MPYE-5-1/8-HF-010-B gives; the
critical ratio and the lag are assumed."""


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
    pressure is off the reference, fully at `full_open_MPa`. References stay between `lowest_MPa`, below which venting
    has no pressure left to drive it, and `highest_MPa`, what the maker allows (Festo DMSP-20: 0.6 MPa); `mean_MPa`
    is the pressure about which the pair is split, all gauge.
    """

    muscle: Muscle
    leg: Leg = LEG
    supply: Supply = SUPPLY
    valve: Valve = VALVE
    dead_volume_m3: float = 1.5e-5
    full_open_MPa: float = 0.05
    mean_MPa: float = 0.315
    lowest_MPa: float = 0.03
    highest_MPa: float = 0.6

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
        return jnp.maximum(force, 0.0), memory

    def torque(self, force: Array) -> Array:
        """Torque of the forces (2,) in N on the sprocket in N·m, positive flexes."""
        return (force[0] - force[1]) * self.leg.sprocket_radius_m
