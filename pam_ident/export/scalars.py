"""What JAX has traced, taken apart into operations on single numbers.

An array becomes an array of nodes (dtype object): what only moves numbers about is done here and leaves no trace.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

import numpy as np

from ..core import UsageError
from .graph import MEANING, Graph

Nodes = np.ndarray
SAME = frozenset(MEANING) - {"select"}
"""Primitives of JAX that a graph has by the same name."""
REDUCE = {"reduce_sum": "add", "reduce_prod": "mul", "reduce_max": "max", "reduce_min": "min"}
INSIDE = ("jaxpr", "call_jaxpr", "fun_jaxpr")
"""Where a primitive that calls a function keeps it."""
CALLS = {"jit", "pjit", "closed_call", "core_call", "custom_jvp_call", "custom_vjp_call", "remat", "checkpoint"}


def scalars(graph: Graph, closed: Any, given: Sequence[Nodes]) -> list[Nodes]:
    """The results of a closed jaxpr for arrays of nodes. Raises UsageError for a primitive that is not known here."""
    return _run(graph, closed.jaxpr, [_numbers(graph, c) for c in closed.consts], given)


def _run(graph: Graph, jaxpr: Any, consts: Sequence[Nodes], given: Sequence[Nodes]) -> list[Nodes]:
    known: dict[Any, Nodes] = dict(zip((*jaxpr.constvars, *jaxpr.invars), (*consts, *given), strict=True))

    def value(atom: Any) -> Nodes:
        return _numbers(graph, atom.val) if hasattr(atom, "val") else known[atom]

    for equation in jaxpr.eqns:
        if equation.primitive.name == "div" and equation.outvars[0].aval.dtype.kind in "iu":
            raise UsageError("the model divides whole numbers, which cannot be exported; use 2.0 in place of 2")
        found = _apply(graph, equation.primitive.name, equation.params, [value(atom) for atom in equation.invars])
        for var, nodes in zip(equation.outvars, found, strict=True):
            if nodes.shape != var.aval.shape:
                nodes = np.broadcast_to(nodes, var.aval.shape)
            known[var] = nodes
    return [value(atom) for atom in jaxpr.outvars]


def _numbers(graph: Graph, values: Any) -> Nodes:
    return _each(lambda x: graph.number(bool(x) if isinstance(x, bool | np.bool_) else float(x)), np.asarray(values))


def _each(function: Callable[..., int], *arrays: Nodes) -> Nodes:
    return np.asarray(np.frompyfunc(function, len(arrays), 1)(*arrays), dtype=object)


def _apply(graph: Graph, name: str, params: dict[str, Any], given: list[Nodes]) -> list[Nodes]:
    if name in CALLS:
        inner = next(params[key] for key in INSIDE if key in params)
        return scalars(graph, inner, given) if hasattr(inner, "consts") else _run(graph, inner, [], given)
    if name in SAME:
        return [_each(lambda *nodes: graph.apply(name, *nodes), *given)]
    if name in ARITHMETIC:
        return [_each(lambda *nodes: ARITHMETIC[name](graph, params, *nodes), *given)]
    if name in REDUCE:
        return [_reduced(graph, REDUCE[name], given[0], params["axes"])]
    if name == "iota":
        along = np.arange(params["shape"][params["dimension"]], dtype=float)
        spread = {"shape": params["shape"], "broadcast_dimensions": (params["dimension"],)}
        return [_numbers(graph, _broadcast(spread, along))]
    if name == "dot_general":
        return [_dot(graph, given[0], given[1], params["dimension_numbers"])]
    if name in MOVES:
        return [np.asarray(MOVES[name](params, *given), dtype=object)]
    raise UsageError(
        f"the model uses {name} of JAX, which cannot be exported; write the effect with the functions of other effects"
    )


def _converted(graph: Graph, params: dict[str, Any], node: int) -> int:
    """Yes and no as 1 and 0; a number as whether it is not 0."""
    kind, answers = np.dtype(params["new_dtype"]).kind, graph.answers(node)
    if answers and kind != "b":
        return graph.apply("select", node, graph.number(1.0), graph.number(0.0))
    if kind == "b" and not answers:
        return graph.apply("ne", node, graph.number(0.0))
    return _toward_zero(graph, node, 0.0) if kind in "iu" and not answers else node


def _toward_zero(graph: Graph, node: int, more: float) -> int:
    """The node with its fraction cut off, after its size has grown by `more`."""
    up, down = (graph.apply("add", node, graph.number(sign * more)) for sign in (1.0, -1.0))
    positive = graph.apply("ge", node, graph.number(0.0))
    return graph.apply("select", positive, graph.apply("floor", up), graph.apply("ceil", down))


def _rounded(graph: Graph, params: dict[str, Any], node: int) -> int:
    if int(params["rounding_method"]) != 0:
        raise UsageError("the model rounds to even numbers, which cannot be exported; use floor")
    return _toward_zero(graph, node, 0.5)


def _power(graph: Graph, params: dict[str, Any], node: int) -> int:
    """A whole power by repeated squaring, as XLA does it."""
    found, square, left = graph.number(1.0), node, abs(params["y"])
    while left:
        if left % 2:
            found = graph.apply("mul", found, square)
        square, left = graph.apply("mul", square, square) if left > 1 else square, left // 2
    return graph.apply("div", graph.number(1.0), found) if params["y"] < 0 else found


def _sign(graph: Graph, params: dict[str, Any], node: int) -> int:
    zero, one = graph.number(0.0), graph.number(1.0)
    negative = graph.apply("select", graph.apply("lt", node, zero), graph.number(-1.0), zero)
    return graph.apply("select", graph.apply("gt", node, zero), one, negative)


def _chosen(graph: Graph, params: dict[str, Any], which: int, *cases: int) -> int:
    if len(cases) != 2 or not graph.answers(which):
        raise UsageError("the model chooses among more than two cases, which cannot be exported; use where")
    return graph.apply("select", which, cases[1], cases[0])


def _clamped(graph: Graph, params: dict[str, Any], low: int, node: int, high: int) -> int:
    return graph.apply("min", graph.apply("max", node, low), high)


def _logistic(graph: Graph, params: dict[str, Any], node: int) -> int:
    one = graph.number(1.0)
    return graph.apply("div", one, graph.apply("add", one, graph.apply("exp", graph.apply("neg", node))))


def _reciprocal_root(graph: Graph, params: dict[str, Any], node: int) -> int:
    return graph.apply("div", graph.number(1.0), graph.apply("sqrt", node))


def _square(graph: Graph, params: dict[str, Any], node: int) -> int:
    return graph.apply("mul", node, node)


def _same(graph: Graph, params: dict[str, Any], node: int) -> int:
    return node


ARITHMETIC: dict[str, Callable[..., int]] = {
    "convert_element_type": _converted,
    "integer_pow": _power,
    "round": _rounded,
    "sign": _sign,
    "select_n": _chosen,
    "clamp": _clamped,
    "logistic": _logistic,
    "rsqrt": _reciprocal_root,
    "square": _square,
    "stop_gradient": _same,
    "copy": _same,
    "copy_p": _same,
}
"""Primitives of JAX that are written with the operations of a graph."""


def _reduced(graph: Graph, op: str, nodes: Nodes, axes: Sequence[int]) -> Nodes:
    rows = np.moveaxis(nodes, axes, range(len(axes)))
    rows = rows.reshape(-1, *rows.shape[len(axes) :])
    if not len(rows):
        return np.full(rows.shape[1:], graph.number({"add": 0.0, "mul": 1.0}[op]), dtype=object)
    return reduce(lambda a, b: _each(lambda x, y: graph.apply(op, x, y), a, b), rows)


def _dot(graph: Graph, left: Nodes, right: Nodes, numbers: Any) -> Nodes:
    (left_axes, right_axes), (left_batch, right_batch) = numbers
    if left_batch or right_batch:
        raise UsageError("the model multiplies stacks of matrices, which cannot be exported; use sums of products")
    first = np.moveaxis(left, left_axes, range(len(left_axes)))
    second = np.moveaxis(right, right_axes, range(len(right_axes)))
    k = len(left_axes)
    spread = first.reshape(first.shape + (1,) * (second.ndim - k))
    other = second.reshape(second.shape[:k] + (1,) * (first.ndim - k) + second.shape[k:])
    products = _each(lambda x, y: graph.apply("mul", x, y), *np.broadcast_arrays(spread, other))
    return _reduced(graph, "add", products, range(k))


def _broadcast(params: dict[str, Any], nodes: Nodes, *_: Nodes) -> Nodes:
    shape = [1] * len(params["shape"])
    for axis, size in zip(params["broadcast_dimensions"], nodes.shape, strict=True):
        shape[axis] = size
    return np.broadcast_to(nodes.reshape(shape), params["shape"])


def _slice(params: dict[str, Any], nodes: Nodes) -> Nodes:
    steps = params["strides"] or (1,) * nodes.ndim
    cuts = zip(params["start_indices"], params["limit_indices"], steps, strict=True)
    return nodes[tuple(slice(*cut) for cut in cuts)]


MOVES: dict[str, Callable[..., Nodes]] = {
    "broadcast_in_dim": _broadcast,
    "reshape": lambda params, nodes, *_: nodes.reshape(params["new_sizes"]),
    "squeeze": lambda params, nodes: np.squeeze(nodes, tuple(params["dimensions"])),
    "expand_dims": lambda params, nodes: np.expand_dims(nodes, tuple(params["dimensions"])),
    "transpose": lambda params, nodes: nodes.transpose(params["permutation"]),
    "concatenate": lambda params, *nodes: np.concatenate(nodes, params["dimension"]),
    "stack": lambda params, *nodes: np.stack(nodes, params["axis"]),
    "slice": _slice,
    "rev": lambda params, nodes: np.flip(nodes, tuple(params["dimensions"])),
}
"""Primitives that only move numbers about."""
