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
MOVES = {"broadcast_in_dim", "reshape", "squeeze", "expand_dims", "transpose", "concatenate", "stack", "slice", "rev"}
"""Primitives that only move numbers about."""
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
        found = _apply(graph, equation, [value(atom) for atom in equation.invars])
        for var, nodes in zip(equation.outvars, found, strict=True):
            if nodes.shape != var.aval.shape:
                nodes = np.broadcast_to(nodes, var.aval.shape)
            known[var] = nodes
    return [value(atom) for atom in jaxpr.outvars]


def _numbers(graph: Graph, values: Any) -> Nodes:
    return _each(lambda x: graph.number(bool(x) if isinstance(x, bool | np.bool_) else float(x)), np.asarray(values))


def _each(function: Callable[..., int], *arrays: Nodes) -> Nodes:
    return np.asarray(np.frompyfunc(function, len(arrays), 1)(*arrays), dtype=object)


def _apply(graph: Graph, equation: Any, given: list[Nodes]) -> list[Nodes]:
    name, params = equation.primitive.name, equation.params
    if name in CALLS:
        inner = next(params[key] for key in INSIDE if key in params)
        return scalars(graph, inner, given) if hasattr(inner, "consts") else _run(graph, inner, [], given)
    if name in SAME:
        return [_each(lambda *nodes: graph.apply(name, *nodes), *given)]
    if name in RULES:
        return [_each(lambda *nodes: _built(graph, RULES[name], nodes), *given)]
    if name in ARITHMETIC:
        return [_each(lambda *nodes: ARITHMETIC[name](graph, params, *nodes), *given)]
    if name in REDUCE:
        return [_reduced(graph, REDUCE[name], given[0], params["axes"])]
    if name == "iota":
        return [_numbers(graph, equation.primitive.bind(**params))]
    if name == "dot_general":
        return [_dot(graph, given[0], given[1], params["dimension_numbers"])]
    if name in MOVES:  # nodes are numbers as any others
        return [np.asarray(equation.primitive.bind(*(nodes.astype(int) for nodes in given), **params)).astype(object)]
    raise UsageError(
        f"the model uses {name} of JAX, which cannot be exported; write the effect with the functions of other effects"
    )


TOWARD_ZERO = ("select", ("ge", 0, 0.0), ("floor", 0), ("ceil", 0))
RULES: dict[str, Any] = {
    "sign": ("select", ("gt", 0, 0.0), 1.0, ("select", ("lt", 0, 0.0), -1.0, 0.0)),
    "clamp": ("min", ("max", 1, 0), 2),
    "logistic": ("div", 1.0, ("add", 1.0, ("exp", ("neg", 0)))),
    "rsqrt": ("div", 1.0, ("sqrt", 0)),
    "square": ("mul", 0, 0),
    **dict.fromkeys(("stop_gradient", "copy", "copy_p"), 0),
}
"""Primitives of JAX in the operations of a graph; a whole number is the argument of that place, a float a constant."""


def _built(graph: Graph, rule: Any, nodes: Sequence[int]) -> int:
    if isinstance(rule, tuple):
        return graph.apply(rule[0], *(_built(graph, part, nodes) for part in rule[1:]))
    return nodes[rule] if isinstance(rule, int) else graph.number(rule)


def _converted(graph: Graph, params: dict[str, Any], node: int) -> int:
    """Yes and no as 1 and 0; a number as whether it is not 0."""
    kind, answers = np.dtype(params["new_dtype"]).kind, graph.answers(node)
    if answers and kind != "b":
        return _built(graph, ("select", 0, 1.0, 0.0), [node])
    if kind == "b" and not answers:
        return _built(graph, ("ne", 0, 0.0), [node])
    return _built(graph, TOWARD_ZERO, [node]) if kind in "iu" and not answers else node


def _rounded(graph: Graph, params: dict[str, Any], node: int) -> int:
    if int(params["rounding_method"]) != 0:
        raise UsageError("the model rounds to even numbers, which cannot be exported; use floor")
    return _built(graph, ("select", ("ge", 0, 0.0), ("floor", ("add", 0, 0.5)), ("ceil", ("add", 0, -0.5))), [node])


def _power(graph: Graph, params: dict[str, Any], node: int) -> int:
    """A whole power by repeated squaring, as XLA does it."""
    found, square, left = graph.number(1.0), node, abs(params["y"])
    while left:
        if left % 2:
            found = graph.apply("mul", found, square)
        square, left = graph.apply("mul", square, square) if left > 1 else square, left // 2
    return graph.apply("div", graph.number(1.0), found) if params["y"] < 0 else found


def _chosen(graph: Graph, params: dict[str, Any], which: int, *cases: int) -> int:
    if len(cases) != 2 or not graph.answers(which):
        raise UsageError("the model chooses among more than two cases, which cannot be exported; use where")
    return graph.apply("select", which, cases[1], cases[0])


ARITHMETIC: dict[str, Callable[..., int]] = {
    "convert_element_type": _converted,
    "integer_pow": _power,
    "round": _rounded,
    "select_n": _chosen,
}
"""Primitives that depend on their parameters."""


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
