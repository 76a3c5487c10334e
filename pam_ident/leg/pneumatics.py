"""Air in and out of a muscle: valve, pressure and mass, and the volume of the braid. SI, absolute pressure.

Air is an ideal gas, the walls let no heat through, and what flows in brings the enthalpy of its source. Pressure and
mass are states side by side, so that the balances of energy and of mass both hold and the temperature follows from
them. Everything here can be traced by JAX.
"""

import math
from dataclasses import dataclass

from ..core import DataError, Specimen
from .arrays import Array, jnp

KAPPA = 1.4
"""Ratio of the specific heats of air."""
GAS = 287.0
"""Gas constant of air, J/(kg·K)."""
ATMOSPHERE = 101325.0
"""Pa."""
LAMINAR = 0.999
"""Pressure ratio above which the flow falls in a straight line to zero: the ellipse of ISO 6358 is infinitely steep at
equal pressures, where the flow is laminar anyhow. Simulators do so from 0.995 to 0.999 (MathWorks, Constant Area
Pneumatic Orifice (ISO 6358); compare Beater 2007, Pneumatic Drives, Springer, which was not seen)."""


@dataclass(frozen=True)
class Supply:
    """The air on both sides of a valve: pressure and temperature of the supply, pressure of the exhaust.

    Raises DataError where the supply is not above the exhaust, or either is no pressure.
    """

    pressure_Pa: float
    temperature_K: float = 293.15
    exhaust_Pa: float = ATMOSPHERE

    def __post_init__(self) -> None:
        if not (0.0 < self.exhaust_Pa < self.pressure_Pa < math.inf and 0.0 < self.temperature_K < math.inf):
            raise DataError(
                f"supply: {self.pressure_Pa} Pa at {self.temperature_K} K over an exhaust of {self.exhaust_Pa} Pa; "
                "expected absolute pressures, the supply's above the exhaust's, and a temperature in K"
            )


@dataclass(frozen=True)
class Valve:
    """A proportional valve: effective area fully open, critical pressure ratio, lag of the opening behind the command.

    The opening runs from −1 (to the exhaust) over 0 (closed) to 1 (from the supply). Raises DataError for an area that
    is not above 0, a ratio outside 0 to 1 or a negative lag.
    """

    area_m2: float
    critical_ratio: float
    lag_s: float

    def __post_init__(self) -> None:
        if not (
            0.0 < self.area_m2 < math.inf and 0.0 <= self.critical_ratio < LAMINAR and 0.0 <= self.lag_s < math.inf
        ):
            raise DataError(
                f"valve: area {self.area_m2} m², critical ratio {self.critical_ratio}, lag {self.lag_s} s; expected an "
                "area above 0, a ratio of 0 to 1 and a lag of 0 or more"
            )


def flow(upstream_Pa: Array, upstream_K: Array, downstream_Pa: Array, area_m2: Array, critical_ratio: float) -> Array:
    """Mass flow in kg/s through an effective area, any shape, never below 0: nothing flows back.

    Equations (10) and (11) of the heterogeneous-leg paper, which is ISO 6358's ellipse: choked below the critical ratio
    of the pressures, above 0.999 in a straight line to 0.
    """
    ratio = downstream_Pa / upstream_Pa
    above = (jnp.clip(ratio, critical_ratio, LAMINAR) - critical_ratio) / (1.0 - critical_ratio)
    laminar = jnp.clip((1.0 - ratio) / (1.0 - LAMINAR), 0.0, 1.0)
    share = jnp.sqrt(1.0 - above**2) * laminar
    return area_m2 * upstream_Pa * math.sqrt(1.0 - critical_ratio) * share / jnp.sqrt(GAS * upstream_K)


def valve_flow(
    opening: Array, pressure_Pa: Array, temperature_K: Array, supply: Supply, valve: Valve
) -> tuple[Array, Array]:
    """Flow into a muscle and out of it in kg/s, any shape; one of the two is 0.

    `opening` is cut at ±1, pressure and temperature are the muscle's.
    """
    opening = jnp.clip(opening, -1.0, 1.0)
    filling, venting = (valve.area_m2 * jnp.maximum(share, 0.0) for share in (opening, -opening))
    b = valve.critical_ratio
    q_in = flow(supply.pressure_Pa, supply.temperature_K, pressure_Pa, filling, b)
    return q_in, flow(pressure_Pa, temperature_K, supply.exhaust_Pa, venting, b)


def gas_temperature(pressure_Pa: Array, mass_kg: Array, volume_m3: Array) -> Array:
    """Temperature in K of an ideal gas, any shape."""
    return pressure_Pa * volume_m3 / (mass_kg * GAS)


def pressure_rate(
    pressure_Pa: Array,
    mass_kg: Array,
    volume_m3: Array,
    volume_rate_m3_s: Array,
    q_in: Array,
    q_out: Array,
    supply_K: float,
) -> tuple[Array, Array]:
    """ṗ in Pa/s and ṁ in kg/s of the air in a muscle, any shape.

    Equation (9): ṗ = κ R (T_s q_in − T q_out)/V − κ p V̇/V with T = pV/(mR), the energy of a variable volume whose walls
    let no heat through; ṁ = q_in − q_out.
    """
    temperature = gas_temperature(pressure_Pa, mass_kg, volume_m3)
    brought = GAS * (supply_K * q_in - temperature * q_out)
    return KAPPA * (brought - pressure_Pa * volume_rate_m3_s) / volume_m3, q_in - q_out


def braid_volume(specimen: Specimen, contraction: Array, dead_m3: float = 0.0) -> tuple[Array, Array]:
    """Volume V = L π r² of the braid's cylinder with a dead volume, m³, and dV/dε, any shape.

    r from cosθ = (1−ε) cosθ0; dV/dε = π r0² L0 [a(1−ε)² − b], the lever of the ideal law (Chou & Hannaford 1996).
    """
    rest = math.pi * specimen.initial_radius_mm**2 * specimen.initial_length_mm * 1e-9
    square = (1.0 - contraction) ** 2
    volume = rest * (1.0 - contraction) * (specimen.b - specimen.a / 3.0 * square)
    return dead_m3 + volume, rest * (specimen.a * square - specimen.b)
