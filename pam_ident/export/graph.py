"""A formula as a graph of operations on single numbers; equal parts of it exist once.

SymPy's `cse` and printers were tried in its place: they agree where a model is small, but of seven effects at once they
had no answer after two minutes, where this takes two seconds.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..core import UsageError

LOGICAL = {"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not"}
"""Operations that answer yes or no."""
SAME = "abs ceil cbrt cos cosh exp expm1 floor log log1p sin sinh sqrt tan tanh"
"""Operations that NumPy has by the same name."""
MEANING: dict[str, Callable[..., Any]] = {
    **{name: getattr(np, name) for name in SAME.split()},
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "pow": np.power,
    "max": np.maximum,
    "min": np.minimum,
    "rem": np.fmod,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "select": np.where,
}
"""Every operation a graph can hold, as NumPy computes it. `select(test, yes, no)`."""


class Node(NamedTuple):
    """An operation on earlier nodes, by their numbers; or, without arguments, a number or a name."""

    op: str
    args: tuple[int, ...] = ()
    leaf: float | bool | str = 0.0


class Graph:
    """Nodes by number, each after those it needs. What is known already is computed at once.

    Numbers are taken to be finite: 0·x and x − x are 0.
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._known: dict[tuple[Node, type], int] = {}

    def number(self, value: float | bool) -> int:
        """A constant. Raises UsageError for what is not finite."""
        if not math.isfinite(value):
            raise UsageError(f"a constant of the model is {value}; expected finite numbers, check the parameters")
        return self._add(Node("number", (), value if isinstance(value, bool) else float(value)))

    def name(self, name: str) -> int:
        """Something that is given from outside."""
        return self._add(Node("name", (), name))

    def apply(self, op: str, *args: int) -> int:
        """The node of an operation of `MEANING`, or a simpler one that is equal to it."""
        known = [self.nodes[a].leaf for a in args if self.nodes[a].op == "number"]
        if len(known) == len(args):
            with np.errstate(all="ignore"):
                return self.number(MEANING[op](*known).item())
        simpler = self._simpler(op, args)
        return self._add(Node(op, args)) if simpler is None else simpler

    def answers(self, node: int) -> bool:
        """Whether a node is yes or no, and no number."""
        one = self.nodes[node]
        if one.op == "select":
            return self.answers(one.args[1])
        return one.op in LOGICAL or isinstance(one.leaf, bool)

    def reached(self, ends: Iterable[int]) -> list[int]:
        """The nodes that `ends` need, themselves included, each after those it needs."""
        found: set[int] = set()
        waiting = list(ends)
        while waiting:
            node = waiting.pop()
            if node not in found:
                found.add(node)
                waiting += self.nodes[node].args
        return sorted(found)

    def evaluate(self, end: int, given: Mapping[str, Any]) -> Any:
        """The value of a node for numbers or arrays by name."""
        found: dict[int, Any] = {}
        for node in self.reached([end]):
            op, args, leaf = self.nodes[node]
            known = given[str(leaf)] if op == "name" else leaf
            found[node] = MEANING[op](*(found[a] for a in args)) if args else known
        return found[end]

    def _add(self, node: Node) -> int:
        key = node, type(node.leaf)  # True and 1.0 are equal, and not the same
        if key not in self._known:
            self._known[key] = len(self.nodes)
            self.nodes.append(node)
        return self._known[key]

    def _simpler(self, op: str, args: tuple[int, ...]) -> int | None:
        leaf = [self.nodes[a].leaf if self.nodes[a].op == "number" else None for a in args]
        if op == "mul" and 0.0 in leaf:
            return self.number(0.0)
        if op in ("mul", "add") and leaf[0] == float(op == "mul"):
            return args[1]
        if op in ("mul", "div") and leaf[1] == 1.0:
            return args[0]
        if op in ("add", "sub") and leaf[1] == 0.0:
            return args[0]
        if op == "sub" and args[0] == args[1]:
            return self.number(0.0)
        if op == "sub" and leaf[0] == 0.0:
            return self.apply("neg", args[1])
        if op == "mul" and -1.0 in leaf:
            return self.apply("neg", args[1 - leaf.index(-1.0)])
        if op in ("neg", "not") and self.nodes[args[0]].op == op:
            return self.nodes[args[0]].args[0]
        if op == "select" and (leaf[0] is not None or args[1] == args[2]):
            return args[1] if leaf[0] or args[1] == args[2] else args[2]
        if op in ("and", "or") and any(isinstance(x, bool) for x in leaf):
            known, other = (0, 1) if leaf[0] is not None else (1, 0)
            return args[other] if leaf[known] == (op == "and") else args[known]
        return None
