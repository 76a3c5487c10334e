"""A fitted model as a program: the force of one muscle at one instant, from numbers and a memory."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..core import Inputs, UsageError
from ..core.recursion import Live, Slot
from ..leg.arrays import jax, jnp
from ..leg.muscle import SPEED_OF_REVERSAL, count_reversals
from ..model import GEOMETRY
from .fitted import Fitted, Parameter
from .graph import Graph
from .scalars import scalars

ARGUMENTS = {
    "pressure_MPa": "gauge pressure in the muscle, MPa",
    "contraction": "contraction ratio (L0 - L)/L0",
    "velocity_mm_s": "speed of shortening, mm/s",
    "direction": "+1 while the muscle shortens, -1 while it lengthens; in a loop tanh(velocity_mm_s/0.2)",
    "time_s": "time of the sample, s; it must not run backwards",
    "cycle": "number of the cycle, from 1",
    "temperature_C": "temperature of the muscle, degrees C",
    "held": "1 while the rig holds the length, else 0; the direction stays that of the motion before",
}
"""What a program may be given, in the order of its arguments; the first two are always there."""
FOUND = ("direction", "cycle")
"""What is found from the speed where a program is live."""
Tree = Any


@dataclass(frozen=True)
class Block:
    """What is computed at an instant: nodes of the force in N and of what is then remembered."""

    force: int
    memory: tuple[int, ...] = ()

    @property
    def ends(self) -> tuple[int, ...]:
        """All nodes that are wanted."""
        return (self.force, *self.memory)


@dataclass(frozen=True, eq=False)
class Program:
    """`first` is what is computed at the first sample, `later` at any other, None where nothing is remembered.

    `constants` are the parameters that occur by name, `arguments` those of `ARGUMENTS` that do; `memory` names what is
    remembered from one sample to the next.
    """

    graph: Graph
    arguments: tuple[str, ...]
    constants: tuple[str, ...]
    memory: tuple[str, ...]
    first: Block
    later: Block | None

    def values(self, fitted: Fitted) -> dict[str, float]:
        """Values of the parameters that occur, by their names in the graph."""
        return {name: p.value for name, p in named_parameters(fitted) if name in self.constants}


def program(fitted: Fitted, live: bool = False) -> Program:
    """The program of a fitted model: its `Model.step`, or where nothing is remembered its `Model.force`.

    Where the branches have parameters of their own, `contraction_…` and `extension_…`, their forces are blended by the
    direction. With `live`, direction and cycle are no arguments but found from the speed, as a `leg.Muscle` finds them.
    Raises UsageError for an effect that JAX cannot trace or that uses what cannot be exported.
    """
    graph = Graph()
    given = {name: np.array([graph.name(name)], dtype=object) for name in ARGUMENTS if not (live and name in FOUND)}
    values = {
        branch: {
            p.name: np.array(graph.name(constant_name(fitted, branch, p.name)), dtype=object)
            for p in parameters
            if not _geometry(fitted, p.name)
        }
        for branch, parameters in fitted.branches.items()
    }
    try:
        force, memory = _traced(graph, partial(_instant, fitted, None), given, values)
        first, later, names = _with_memory(graph, fitted, given, values, force, memory)
    except jax.errors.JAXTypeError:
        labels = ", ".join(fitted.model.labels)
        raise UsageError(f"an effect among {labels} cannot be exported: take functions from the arrays, xp") from None
    blocks = [first] if later is None else [first, later]
    used = {graph.nodes[n].leaf for n in graph.reached(end for block in blocks for end in block.ends)}
    arguments = tuple(name for k, name in enumerate(ARGUMENTS) if k < 2 or name in used)
    constants = tuple(name for name, _ in named_parameters(fitted) if name in used)
    return Program(graph, arguments, constants, names, first, later)


def constant_name(fitted: Fitted, branch: str, name: str) -> str:
    """A parameter's name in a program; `=` keeps it apart from an argument of the same name."""
    return f"={name}" if len(fitted.branches) == 1 else f"={branch}_{name}"


def named_parameters(fitted: Fitted) -> Iterator[tuple[str, Parameter]]:
    """Every parameter of every branch under its name in a program."""
    for branch, parameters in fitted.branches.items():
        for p in parameters:
            yield constant_name(fitted, branch, p.name), p


def _instant(fitted: Fitted, memory: Tree, given: Tree, values: Tree) -> tuple[Any, Tree]:
    """Force (1,) of a muscle at an instant and what is then remembered."""
    (turn, stroke), *before = ((None, None),) if memory is None else memory
    velocity, held = given["velocity_mm_s"], given["held"] > 0.5
    moving_to = jnp.tanh(velocity / SPEED_OF_REVERSAL)
    turn, cycle = count_reversals(turn, moving_to)
    direction = given.get("direction", jnp.where(held, turn[0], moving_to))
    stroke, mean_speed = _stroke(stroke, given["time_s"], jnp.where(held, 0.0, jnp.abs(velocity)), held, direction)
    inputs = Inputs(
        pressure=given["pressure_MPa"],
        contraction=given["contraction"],
        specimen=fitted.specimen,
        direction=direction,
        time=given["time_s"],
        velocity=velocity,
        stroke_speed=jnp.where(held, mean_speed, jnp.abs(velocity)),
        moving=~held,
        cycle=given.get("cycle", cycle),
        temperature=given["temperature_C"],
        segment=jnp.zeros(1, int),
    )
    asked = []
    for k, branch in enumerate(fitted.branches):
        own = {p.name: p.value for p in fitted.branches[branch] if _geometry(fitted, p.name)} | values[branch]
        asked.append(_step(fitted, inputs, own, before[k] if before else None))
    after = ((turn, stroke), *(after for _, after in asked if after))
    if len(asked) == 1:
        return asked[0][0], after
    share = dict(zip(fitted.branches, (0.5 * (1.0 + direction), 0.5 * (1.0 - direction)), strict=True))
    force = sum(share[branch] * one for branch, (one, _) in zip(fitted.branches, asked, strict=True))
    return force, after


def _stroke(slot: Slot | None, time: Any, speed: Any, held: Any, direction: Any) -> tuple[Slot, Any]:
    """Way in mm and time in s since the last reversal, holds left out, direction and time of the sample, (1,) each, and
    the mean speed that makes: what a record takes from a stroke as a whole is not yet known."""
    if slot is None:
        return (jnp.zeros(1), jnp.zeros(1), direction, time), speed
    way, lasted, direction_before, time_before = slot
    step, goes_on = time - time_before, direction * direction_before >= 0.0
    way = jnp.where(goes_on, way, 0.0) + speed * step
    lasted = jnp.where(goes_on, lasted, 0.0) + jnp.where(held, 0.0, step)
    return (way, lasted, direction, time), jnp.where(lasted > 0.0, way / jnp.maximum(lasted, 1e-300), speed)


def _step(fitted: Fitted, inputs: Inputs, values: dict[str, Any], memory: Tree) -> tuple[Any, Tree]:
    live = Live(None)
    fitted.model.design(replace(inputs, live=live), values, jnp.zeros(1))
    if live.slots:
        return fitted.model.step(inputs, values, memory)
    return fitted.model.force(replace(inputs, live=Live(None)), values), ()


def _with_memory(
    graph: Graph, fitted: Fitted, given: Tree, values: Tree, force: Tree, memory: Tree
) -> tuple[Block, Block | None, tuple[str, ...]]:
    """First and later block with the names of the memory, less what is never read or is there twice; no later block
    where the first says all."""
    ends, shape = jax.tree.flatten(memory)
    begins = [end.item() for end in ends]
    slots = [graph.name(f"memory{k}") for k in range(len(begins))]

    def after() -> tuple[int, list[int]]:
        known = jax.tree.unflatten(shape, [np.array([slot], dtype=object) for slot in slots])
        found, remembered = _traced(graph, lambda m, *rest: _instant(fitted, m, *rest), known, given, values)
        return found.item(), [end.item() for end in jax.tree.leaves(remembered)]

    _, becomes = after()
    twins: dict[tuple[int, int], int] = {}
    for k, same in enumerate(zip(begins, becomes, strict=True)):
        constant = same[0] == same[1] and _constant(graph, same[0])
        slots[k] = same[0] if constant else twins.setdefault(same, slots[k])
    then, becomes = after()
    read: set[int] = set()
    while True:
        wanted = [then, *(end for slot, end in zip(slots, becomes, strict=True) if slot in read)]
        more = {node for node in graph.reached(wanted) if node in slots and node in twins.values()}
        if more == read:
            break
        read = more
    kept = sorted(slots.index(slot) for slot in read)
    names = tuple(str(graph.nodes[slots[k]].leaf) for k in kept)
    if not kept and then == force.item():
        return Block(then), None, ()
    first = Block(force.item(), tuple(begins[k] for k in kept))
    return first, Block(then, tuple(becomes[k] for k in kept)), names


def _traced(graph: Graph, function: Callable[..., Tree], *nodes: Tree) -> Tree:
    """What a function of arrays gives, as nodes, for trees of nodes."""
    examples = jax.tree.map(lambda one: jnp.zeros(one.shape), nodes)
    closed, shape = jax.make_jaxpr(function, return_shape=True)(*examples)
    return jax.tree.unflatten(jax.tree.structure(shape), scalars(graph, closed, jax.tree.leaves(nodes)))


def _constant(graph: Graph, node: int) -> bool:
    """Whether a node needs nothing but parameters."""
    needed = (graph.nodes[n] for n in graph.reached([node]))
    return all(str(one.leaf).startswith("=") for one in needed if one.op == "name")


def _geometry(fitted: Fitted, name: str) -> bool:
    return fitted.model.free_geometry and name in {p.name for p in GEOMETRY}
