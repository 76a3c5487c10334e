"""Ten thousand refits, and one fit of a million rows, beside scipy and lmfit in one run.

    python benchmarks/refits.py [--refits 10000] [--rows 1000000] [--times 5]

The global exponential law (7 parameters) on 1000 rows of a measured contraction axis. Bootstrap by residuals: other
forces at the same inputs. Bootstrap by cycles: cycles taken with replacement, as weights. Ours does all refits at once;
the peers are loops, timed on some of the same refits: scipy's `least_squares(method="lm")` with the analytic Jacobian,
and lmfit's `Model.fit`, both from the fit to the whole record. All must reach the same minimum, parameters to 1e-6
relative (scipy's converged to rounding). Then one fit of a million rows beside lmfit's. Medians of several times, taken
in turn; exits with 1 where a ratio misses its target.
"""

import argparse
import functools
import os
import statistics
import sys
import time
from collections.abc import Callable

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # before numpy is imported; a second thread harms matrices this small

import lmfit
import numpy as np
from scipy.optimize import least_squares

from pam_ident.core import Specimen
from pam_ident.fitting import Fit, fit
from pam_ident.fitting.refit import refit_forces, refit_weights
from pam_ident.model import Model
from pam_ident.records import Record, build_record

Array = np.ndarray
NAMES = ("a0", "a1", "b0", "b1", "c0", "c1", "mu")
TRUTH = np.array([-197.8, 2442.0, 1735.0, 5464.0, -9.3, 688.3, 45.0])
LAW = Model.build("exponential_law")
SCIPYS, LMFITS = 200, 40
"""Refits that the peers are timed on."""


def law(p: Array, e: Array, a0, a1, b0, b1, c0, c1, mu) -> Array:
    return a0 + a1 * p - (b0 + b1 * p) * e + (c0 + c1 * p) * np.exp(-mu * e)


def slopes(p: Array, e: Array, x: Array) -> Array:
    d = np.exp(-x[6] * e)
    return np.column_stack([np.ones_like(p), p, -e, -e * p, d, d * p, -(x[4] + x[5] * p) * e * d])


def make(rows: int, seed: int = 1) -> Record:
    """Five isobars of six strokes on a measured axis, 2 N of noise."""
    rng = np.random.default_rng(seed)
    level = np.repeat([0.1, 0.2, 0.3, 0.4, 0.5], rows // 5)
    p = level + rng.normal(0.0, 2e-4, rows)
    phase = np.tile(np.linspace(0.0, 6.0, rows // 5, endpoint=False), 5)
    e = 0.2 * np.abs((phase + 1.0) % 2.0 - 1.0) + rng.normal(0.0, 5e-5, rows)
    force = law(p, e, *TRUTH) + rng.normal(0.0, 2.0, rows)
    return build_record("bench", Specimen("bench"), p, e, force, time=0.1 * np.arange(rows), level=level)


def by_scipy(record: Record, force: Array, weight: Array | float, begin: Array, tight: bool = False) -> Array:
    p, e, root = record.inputs.pressure, record.inputs.contraction, np.sqrt(weight)
    options = {"xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-14} if tight else {}
    column = root[:, None] if isinstance(root, np.ndarray) else root
    return least_squares(
        lambda x: root * (law(p, e, *x) - force), begin, lambda x: column * slopes(p, e, x), method="lm", **options
    ).x


def by_lmfit(record: Record, force: Array, weight: Array | float, begin: Array) -> "lmfit.model.ModelResult":
    model = lmfit.Model(law, independent_vars=["p", "e"])
    p, e = record.inputs.pressure, record.inputs.contraction
    root = np.sqrt(weight) if isinstance(weight, np.ndarray) else None
    return model.fit(force, weights=root, p=p, e=e, **dict(zip(NAMES, begin, strict=True)))


def timed(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def refits(times: int, count: int) -> list[tuple[str, float, float, float, float]]:
    """Name, seconds a refit by ours, scipy and lmfit, and the largest relative difference from scipy's minimum."""
    record = make(1000)
    whole: Fit = fit(LAW, record)
    begin = np.array([whole.values[n] for n in NAMES])
    order = [e.name for e in whole.estimates]
    back = [order.index(n) for n in NAMES]
    rng = np.random.default_rng(2)
    forces = whole.force[:, None] + rng.choice(whole.residual, (len(record), count))
    _, block = np.unique(record.block, return_inverse=True)
    cycles = int(block.max()) + 1
    counts = rng.multinomial(cycles, np.full(cycles, 1.0 / cycles), count).astype(float)
    rows = []
    for name, ours, task in (
        ("residuals", lambda: refit_forces(whole, forces), lambda b: (forces[:, b], 1.0)),
        ("cycles", lambda: refit_weights(whole, block, counts), lambda b: (record.force, counts[b][block])),
    ):
        loops = {
            "scipy": (SCIPYS, functools.partial(loop, by_scipy, record, [task(b) for b in range(SCIPYS)], begin)),
            "lmfit": (LMFITS, functools.partial(loop, by_lmfit, record, [task(b) for b in range(LMFITS)], begin)),
        }
        taken: dict[str, list[float]] = {"ours": [], "scipy": [], "lmfit": []}
        for _ in range(times):
            taken["ours"].append(timed(ours) / count)
            for peer, (number, work) in loops.items():
                taken[peer].append(timed(work) / number)
        exact = np.array([by_scipy(record, *task(b), begin, tight=True) for b in range(SCIPYS)])
        apart = float(np.max(np.abs(ours()[0][:SCIPYS, back] / exact - 1.0)))
        rows.append((name, *(statistics.median(taken[k]) for k in ("ours", "scipy", "lmfit")), apart))
    return rows


def loop(solver: Callable[..., object], record: Record, tasks: list[tuple[Array, Array | float]], begin: Array) -> None:
    for force, weight in tasks:
        solver(record, force, weight, begin)


def million(times: int, rows: int) -> tuple[float, float, float, float]:
    """Seconds of one fit with standard errors: ours with white noise, ours as it comes, lmfit's; and how far apart."""
    record, start = make(rows), np.array([0.0, 2000.0, 0.0, 5000.0, 0.0, 500.0, 45.0])
    taken: dict[str, list[float]] = {"white": [], "default": [], "lmfit": []}
    for _ in range(times):
        taken["white"].append(timed(lambda: fit(LAW, record, white=True)))
        taken["default"].append(timed(lambda: fit(LAW, record)))
        taken["lmfit"].append(timed(lambda: by_lmfit(record, record.force, 1.0, start)))
    ours = fit(LAW, record, detail=False).values
    exact = by_scipy(record, record.force, 1.0, np.array([ours[n] for n in NAMES]), tight=True)
    apart = float(np.max(np.abs(np.array([ours[n] for n in NAMES]) / exact - 1.0)))
    return (*(statistics.median(taken[k]) for k in ("white", "default", "lmfit")), apart)  # type: ignore[return-value]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--refits", type=int, default=10_000)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--times", type=int, default=5)
    asked = parser.parse_args()
    bad = 0
    print("| refits | pam-ident | scipy lm | lmfit | scipy / ours | lmfit / ours | furthest from scipy's minimum |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for name, ours, scipys, lmfits, apart in refits(asked.times, asked.refits):
        bad += scipys < 50.0 * ours or lmfits < 300.0 * ours or apart > 1e-6
        times = " | ".join(f"{1e6 * t:.1f} µs" for t in (ours, scipys, lmfits))
        print(f"| by {name} | {times} | {scipys / ours:.0f} | {lmfits / ours:.0f} | {apart:.0e} |")
    white, default, lmfits, apart = million(asked.times, asked.rows)
    bad += lmfits < 10.0 * white or apart > 1e-6
    print(f"\n| one fit of {asked.rows} rows | time | lmfit / ours |\n|---|---:|---:|")
    print(f"| lmfit | {1e3 * lmfits:.0f} ms | |")
    print(f"| pam-ident, errors of white noise as lmfit's | {1e3 * white:.0f} ms | {lmfits / white:.1f} |")
    print(f"| pam-ident, errors that allow for correlation | {1e3 * default:.0f} ms | {lmfits / default:.1f} |")
    print(f"\nfurthest from scipy's minimum: {apart:.0e} relative; {bad} targets missed")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
