"""Rows of a record by a condition: `pressure_MPa > 0.1 and not cycle == 1`."""

import ast
import operator
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..core import Array, DataError, UsageError
from ..core.units import split_header
from .motion import long_pause
from .notes import Notes
from .quantities import QUANTITIES, scale_of
from .record import Record

LONGEST = 2000
"""Characters of a condition."""
BRANCHES = {1.0: "contraction", -1.0: "extension", 0.0: ""}
COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_QUOTED = re.compile(r"`([^`]*)`")


def rows_where(record: Record, condition: str) -> Record:
    """The samples for which a condition holds: names of quantities with units (`force_N`, in backticks with blanks),
    numbers, comparisons, `and`, `or`, `not`. Strokes, cycles and isobars stay those of the whole record; where rows go
    for longer than a pause of the clock, a new segment begins.

    Raises UsageError for anything else in the condition, DataError where no row is left.

    Example:
        >>> from pam_ident.records import read_record
        >>> from pam_ident.records.datasets import dataset_record
        >>> from pam_ident.records.where import rows_where
        >>> record = read_record(dataset_record("hidden_effect"))
        >>> some = rows_where(record, "0.15 < pressure_MPa < 0.45 and not cycle == 1")
        >>> print(len(some), "of", len(record), "samples at", some.levels, "MPa")
        2496 of 4680 samples at [0.2 0.3 0.4] MPa
    """
    rows = np.flatnonzero(_Condition(record, condition).mask)
    if len(rows) == len(record):
        return record
    if not len(rows):
        raise DataError(f"{record.source or record.name}: no row with {condition}; nothing is left to fit")
    notes = Notes()
    notes.add("rows_chosen", None, condition, len(record) - len(rows))
    return replace(_parted(record, rows), notes=(*record.notes, *notes.told()))


def _parted(record: Record, rows: Array) -> Record:
    """Some rows, with a new segment behind each gap that a pause would be."""
    chosen = record.take(rows)
    time, segment = record.inputs.time, record.inputs.segment
    if time is None or segment is None:
        return chosen
    pause = long_pause(float(np.quantile(np.diff(time), 0.95)) if len(time) > 1 else 0.0)
    breaks = (np.diff(segment[rows]) != 0) | ((np.diff(rows) > 1) & (np.diff(time[rows]) > pause))
    parts = np.r_[0, np.cumsum(breaks)]
    inputs, steady = (replace(one, segment=parts) for one in (chosen.inputs, chosen.steady))
    return replace(chosen, inputs=inputs, steady=steady)


class _Condition:
    """A condition on the rows of a record; `mask` (n,) is true where it holds. Raises UsageError."""

    def __init__(self, record: Record, text: str) -> None:
        self.record, self.text = record, text
        self.quoted: dict[str, str] = {}
        if len(text) > LONGEST:
            raise UsageError(f"--where: more than {LONGEST} characters; shorten the condition")
        try:
            tree = ast.parse(_QUOTED.sub(self._quote, text).strip(), mode="eval").body
            found = self._truth(tree)
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise self._wrong("cannot be read") from None
        self.mask = np.broadcast_to(found, len(record))

    def _quote(self, found: "re.Match[str]") -> str:
        name = f"quoted_{len(self.quoted)}"
        self.quoted[name] = found[1]
        return name

    def _wrong(self, what: str) -> UsageError:
        return UsageError(
            f"--where {self.text[:200]!r}: {what}; expected names with units, numbers, comparisons, and, or, not, such "
            "as 'pressure_MPa > 0.1 and not cycle == 1'"
        )

    def _truth(self, node: ast.expr) -> Array:
        if isinstance(node, ast.BoolOp):
            join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
            return join.reduce([np.broadcast_to(self._truth(one), len(self.record)) for one in node.values])
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return ~self._truth(node.operand)
        if isinstance(node, ast.Compare):
            return self._compared(node)
        raise self._wrong(f"{ast.unparse(node)!r} is neither true nor false")

    def _compared(self, node: ast.Compare) -> Array:
        sides = [self._value(one) for one in (node.left, *node.comparators)]
        if not any(isinstance(one, np.ndarray) for one in sides):
            raise self._wrong(f"{ast.unparse(node)!r} names no column")
        holds = np.ones(len(self.record), bool)
        for op, left, right in zip(node.ops, sides, sides[1:], strict=False):
            of_text = [np.asarray(one).dtype.kind in "US" for one in (left, right)]
            if type(op) not in COMPARISONS or of_text[0] != of_text[1]:
                raise self._wrong(f"{ast.unparse(node)!r} compares what cannot be compared")
            holds &= COMPARISONS[type(op)](left, right)
        return holds

    def _value(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Name):
            return self._column(self.quoted.get(node.id, node.id))
        sign = 1.0
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
            sign, node = (-1.0 if isinstance(node.op, ast.USub) else 1.0), node.operand
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
            return sign * node.value
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and sign == 1.0:
            return node.value
        raise self._wrong(f"{ast.unparse(node)!r} is neither a name nor a number")

    def _column(self, name: str) -> Array:
        """A quantity of the record in the unit of the name, shape (n,)."""
        quantity, unit = split_header(name)
        inputs = self.record.inputs
        length_mm = self.record.specimen.initial_length_mm
        known = {
            "time": inputs.time,
            "pressure": inputs.pressure,
            "pressure_set": self.record.level,
            "displacement": inputs.contraction * length_mm,
            "contraction": inputs.contraction,
            "length": (1.0 - inputs.contraction) * length_mm,
            "force": self.record.force,
            "temperature": inputs.temperature,
            "cycle": self.record.groups.get("cycle", inputs.cycle),
            "branch": np.array([BRANCHES[sign] for sign in inputs.direction.tolist()]),
        }
        if quantity not in known or (column := known[quantity]) is None:
            there = ", ".join(key for key, column in known.items() if column is not None)
            raise self._wrong(f"the record has no {name!r}, only {there}")
        if QUANTITIES[quantity] == "text":
            return column
        try:
            factor, offset = scale_of(quantity, unit, repr(name))
        except DataError as error:
            raise self._wrong(str(error)) from None
        return (column - offset) / factor
