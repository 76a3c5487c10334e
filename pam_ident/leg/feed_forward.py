"""Pressures that should move the leg along its target: the inverse of leg, fitted muscles and valves."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from .arrays import Array, jax, jnp
from .control import SAMPLE_S, SIGN
from .gait import LegAngles
from .joint import inverse
from .muscle import ByBranch, Memory
from .pair import Pair
from .pneumatics import ATMOSPHERE, GAS, KAPPA, valve_flow

HALVINGS = 30


class PressurePlan(NamedTuple):
    """At N instants: contraction of both muscles (N, 2), gauge pressures wanted in them and references that lead the
    valves to these (MPa, (N, 2)), the torque that the leg needs and what of it the pair cannot give (N·m, (N,)), the
    openings that the pressures need (N, 2), beyond ±1 where the valves are too small."""

    contraction: Array
    pressure: Array
    reference: Array
    torque: Array
    missing: Array
    opening: Array


@dataclass(frozen=True, eq=False)
class FeedForward:
    """Inverse of a leg on a pair of muscles, whose model is the controller's own."""

    pair: Pair

    def plans(self, sets: Any, time: Array, motion: LegAngles) -> PressurePlan:
        """Plans at times (N,) of a gait, for k sets of parameters as `Muscle.draws` gives them; the k in front of all
        arrays, 1 for a model without parameters."""
        leaves = jax.tree.leaves(sets)
        count = len(leaves[0]) if leaves else 1
        return jax.jit(jax.vmap(self._plan, in_axes=(0, None, None), axis_size=count))(sets, time, motion)

    def _plan(self, values: ByBranch, time: Array, motion: LegAngles) -> PressurePlan:
        pair, knee = self.pair, motion.knee
        posture = pair.leg.knee.at(knee.angle)
        contraction, speed = jax.vmap(pair.stroke)(posture.sprocket, posture.ratio * knee.rate)
        need = inverse(pair.leg, *knee, motion)

        def solve(memory: Memory, now: tuple[Array, ...]) -> tuple[Memory, tuple[Array, Array]]:
            time, contraction, speed, need = now

            def pulled(split: Array) -> tuple[Array, Memory]:
                gauge = pair.mean_MPa + split * SIGN
                force, after = pair.pull(values, memory, time, gauge, contraction, speed)
                return pair.torque(force), after

            def halve(_: int, ends: tuple[Array, Array]) -> tuple[Array, Array]:
                low, high = ends
                middle = 0.5 * (low + high)
                short = pulled(middle)[0] < need
                return jnp.where(short, middle, low), jnp.where(short, high, middle)

            reach = jnp.asarray(pair.reach_MPa)
            low, high = jax.lax.fori_loop(0, HALVINGS, halve, (-reach, reach))
            split = 0.5 * (low + high)
            torque, memory = pulled(split)
            return memory, (pair.mean_MPa + split * SIGN, need - torque)

        memory = pair.muscle.start(jnp.full(2, pair.mean_MPa), contraction[0], values=values)
        _, (pressure, missing) = jax.lax.scan(solve, memory, (time, contraction, speed, need))
        opening = self._opening(pressure * 1e6 + ATMOSPHERE, contraction, speed)
        lead = opening + pair.valve.lag_s * _slope(opening)
        reference = pressure + pair.full_open_MPa * jnp.clip(lead, -1.0, 1.0)
        return PressurePlan(contraction, pressure, reference, need, missing, opening)

    def _opening(self, pressure: Array, contraction: Array, speed: Array) -> Array:
        """Openings (N, 2) that let the absolute pressures (Pa, (N, 2)) come about, from (9) solved for the flow."""
        pair = self.pair
        heat = pair.supply.temperature_K
        volume, slope = pair.volume(contraction)
        swell = slope * speed / pair.muscle.specimen.initial_length_mm
        flow = (_slope(pressure) * volume + KAPPA * pressure * swell) / (KAPPA * GAS * heat)
        filling, _ = valve_flow(jnp.ones_like(pressure), pressure, heat, pair.supply, pair.valve)
        _, venting = valve_flow(-jnp.ones_like(pressure), pressure, heat, pair.supply, pair.valve)
        return flow / jnp.maximum(jnp.where(flow > 0.0, filling, venting), 1e-9)


def _slope(values: Array) -> Array:
    """Time derivative along the first axis, by central differences."""
    return jnp.gradient(values, SAMPLE_S, axis=0)
