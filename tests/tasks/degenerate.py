"""Some sixty kinds of record that hold next to nothing, or nothing right: name → a frame, from a seed."""

from collections.abc import Callable

import numpy as np
import pandas as pd

COLUMNS = ("time_s", "pressure_MPa", "displacement_mm", "force_N")
LENGTH_MM = 200.0


def ideal(p, e):
    """Force in N of the ideal braid of a muscle of 10 mm and 25.4°."""
    angle = np.radians(25.4)
    return np.pi * 100.0 * p * (3.0 * (1.0 - e) ** 2 / np.tan(angle) ** 2 - 1.0 / np.sin(angle) ** 2)


def good(rng: np.random.Generator, pressures=(0.2, 0.3, 0.4), speeds=(5.0, 20.0), cycles=2, rows=25, top=40.0):
    """A saw-tooth of strokes at each pressure, the force of an ideal braid with 2 N of noise: columns (n, 4)."""
    found, clock = [], 0.0
    for p in pressures:
        for v in speeds:
            for _ in range(cycles):
                for begin, end in ((0.0, top), (top, 0.0)):
                    share = np.arange(rows) / rows
                    span = abs(end - begin) / v
                    x = begin + (end - begin) * share
                    found.append(np.column_stack([clock + span * share, np.full(rows, p), x, np.zeros(rows)]))
                    clock += span
        clock += 10.0
    table = np.vstack(found)
    p, e = table[:, 1], table[:, 2] / LENGTH_MM
    table[:, 3] = ideal(p, e) - 60.0 * e + rng.normal(0.0, 2.0, len(p))
    return table


def frame(table: np.ndarray) -> pd.DataFrame:
    """A table as a record's columns."""
    return pd.DataFrame(table, columns=list(COLUMNS))


def _with(column: int, change: Callable) -> Callable:
    def make(rng):
        table = good(rng)
        table[:, column] = change(table[:, column], rng)
        return table

    return make


def _rows(pick: Callable) -> Callable:
    def make(rng):
        table = good(rng)
        return table[pick(table, rng)]

    return make


def _put(column: int, value: float, where=7) -> Callable:
    def change(values, rng):
        values = values.copy()
        values[where] = value
        return values

    return _with(column, change)


def _saw(rng, every: int):
    table = good(rng)
    table[:, 2] = 20.0 + 15.0 * ((np.arange(len(table)) // every) % 2)
    return table


def _steps(rng, locked=(0.0,)):
    """Lengths locked one after the other, the pressure stepped up and down at each."""
    p = np.repeat(np.r_[0.0:0.6:0.05, 0.6:0.0:-0.05], 20)
    x = np.repeat(locked, len(p))
    p = np.tile(p, len(locked)) + rng.normal(0.0, 1e-4, len(x))
    e = x / LENGTH_MM
    force = ideal(p, e) + rng.normal(0.0, 2.0, len(x))
    return np.column_stack([0.1 * np.arange(len(x)), p, x, force])


def _weight(rng, load=80.0):
    """A dead weight: the length follows the pressure."""
    time = 0.02 * np.arange(1500)
    p = 0.3 + 0.1 * np.sin(time)
    x = 60.0 * (1.0 - 0.1 / p) + rng.normal(0.0, 0.02, len(p))
    return np.column_stack([time, p, x, load + rng.normal(0.0, 1.0, len(p))])


KINDS: dict[str, Callable] = {
    **{f"{n} rows": _rows(lambda t, r, n=n: slice(0, n)) for n in (1, 2, 3, 4, 5, 6, 12, 19)},
    **{f"{n} rows from all": _rows(lambda t, r, n=n: np.linspace(0, len(t) - 1, n).astype(int)) for n in (3, 6, 20)},
    "one row a pressure": _rows(lambda t, r: np.unique(t[:, 1], return_index=True)[1]),
    "1000 identical rows": lambda rng: good(rng)[7:8] + np.outer(0.01 * np.arange(1000), [1, 0, 0, 0]),
    "identical rows without a clock": lambda rng: np.repeat(good(rng)[7:8], 1000, axis=0),
    "two states in turn": lambda rng: np.column_stack(
        [0.1 * np.arange(600), np.tile(good(rng)[[7, 90], 1:], (300, 1))]
    ),
    "a stroke": _rows(lambda t, r: slice(0, 25)),
    "two strokes": _rows(lambda t, r: slice(0, 50)),
    "one pressure": lambda rng: good(rng, (0.3,)),
    "one pressure, one cycle": lambda rng: good(rng, (0.3,), (10.0,), 1),
    "two pressures almost alike": lambda rng: good(rng, (0.3, 0.3001)),
    "no pressure": _with(1, lambda p, r: 0.0 * p),
    "hardly a pressure": _with(1, lambda p, r: 1e-300 * p),
    "a pressure of 1e-9": _with(1, lambda p, r: 1e-9 * p),
    "noise for a pressure": _with(1, lambda p, r: r.normal(0.3, 0.1, len(p)).clip(0.01)),
    "a pressure that jumps from row to row": _with(1, lambda p, r: r.uniform(0.1, 0.6, len(p))),
    "a pressure that rises all the time": _with(1, lambda p, r: np.linspace(0.05, 0.6, len(p))),
    "turned pressure": _with(1, lambda p, r: -p),
    "absolute pressure": _with(1, lambda p, r: p + 0.101325),
    "near vacuum, at hardly a length": lambda rng: good(rng) * [1.0, 1e-3, 1e-3, 1.0] - [0.0, 0.101, 0.0, 0.0],
    "no length": _with(2, lambda x, r: 0.0 * x),
    "a length of 1e-300": _with(2, lambda x, r: 1e-300 * x),
    "a length of 1e-7": _with(2, lambda x, r: 1e-7 * x),
    "constant length": _with(2, lambda x, r: 0.0 * x + 15.0),
    "noise for a length": _with(2, lambda x, r: r.normal(15.0, 3.0, len(x))),
    "noise about a constant length": _with(2, lambda x, r: r.normal(15.0, 0.01, len(x))),
    "a saw of every row": lambda rng: _saw(rng, 1),
    "a saw of every other row": lambda rng: _saw(rng, 2),
    "a saw of every third row": lambda rng: _saw(rng, 3),
    "turned length": _with(2, lambda x, r: -x),
    "a length counted from the far end": _with(2, lambda x, r: 40.0 - x),
    "stretched to 0.94": _with(2, lambda x, r: x - 188.0),
    "shortened to 0.94": _with(2, lambda x, r: x + 148.0),
    "one jump of the length": _put(2, 180.0),
    "no force": _with(3, lambda f, r: 0.0 * f),
    "a constant force": _with(3, lambda f, r: 0.0 * f + 80.0),
    "noise for a force": _with(3, lambda f, r: r.normal(0.0, 5.0, len(f))),
    "noise about a constant force": _with(3, lambda f, r: r.normal(300.0, 5.0, len(f))),
    "turned force": _with(3, lambda f, r: -f),
    "force in another order": _with(3, lambda f, r: r.permutation(f)),
    "force of 1e300": _with(3, lambda f, r: 1e300 * np.sign(f)),
    "force of 1e-300": _with(3, lambda f, r: 1e-300 * f),
    "force of 1e150 here and there": _with(3, lambda f, r: np.where(np.arange(len(f)) % 3, f, 1e150)),
    "a spike of 1e10": _put(3, 1e10),
    "a spike of 1e300": _put(3, 1e300),
    "a spike of minus 1e300": _put(3, -1e300),
    "spikes in every tenth row": _with(3, lambda f, r: np.where(np.arange(len(f)) % 10, f, 1e7)),
    "clipped at the top": _with(3, lambda f, r: np.minimum(f, np.quantile(f, 0.6))),
    "clipped at the bottom": _with(3, lambda f, r: np.maximum(f, np.quantile(f, 0.4))),
    "a force that only drifts": _with(3, lambda f, r: np.linspace(0.0, 500.0, len(f))),
    "a force of two values": _with(3, lambda f, r: np.where(f > f.mean(), 500.0, 100.0)),
    "a clock that stands": _with(0, lambda t, r: 0.0 * t),
    "a clock of 1e-300": _with(0, lambda t, r: 1e-300 * t),
    "a clock of 1e200": _with(0, lambda t, r: 1e200 * t),
    "milliseconds": _with(0, lambda t, r: 1e3 * t),
    "microseconds": _with(0, lambda t, r: 1e6 * t),
    "locked at one length": _steps,
    "locked at four lengths": lambda rng: _steps(rng, (0.0, 10.0, 20.0, 30.0)),
    "a dead weight": _weight,
    "no load": lambda rng: _weight(rng, 2.0),
    "everything noise": lambda rng: np.column_stack(
        [0.1 * np.arange(600), rng.uniform(0.1, 0.6, 600), rng.uniform(0.0, 40.0, 600), rng.normal(300.0, 99.0, 600)]
    ),
}
NAMELESS = set(KINDS) - {
    "two strokes", "one pressure", "one pressure, one cycle", "two pressures almost alike", "a stroke",
    "20 rows from all", "a pressure that rises all the time", "a saw of every third row", "a clock that stands",
    "a force that only drifts", "one jump of the length",
}  # fmt: skip
"""Of these nothing may be named; of the others something true may be."""
