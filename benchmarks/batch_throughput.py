"""`pam-ident batch` over many records of 5000 rows: records a second, a second worker's gain, memory, lmfit beside it.

    python benchmarks/batch_throughput.py [--records 2000] [--peers 10]

Whole processes on two cores in one run: the batch with one worker, with a process for each core, as it is by default,
with two workers of a Dask cluster (all tables must be the same bytes), and with one over a quarter of the records,
whose peak memory must be the same within a fifth. The peers do some of the same files and are scaled up: the ten-line
lmfit script once a file, as a user would loop over it in a shell, and the same fit looped in one process, which finds
no strokes, no noise floor and no errors that allow for correlation, and keeps nothing.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parent))
from fit_process import ROOT, write_record

LOOP = """
import sys, lmfit, numpy as np, pandas as pd
def law(p, e, a0, a1, b0, b1, c0, c1, mu):
    return a0 + a1 * p - (b0 + b1 * p) * e + (c0 + c1 * p) * np.exp(-mu * e)
for path in sys.argv[1:]:
    data = pd.read_csv(path)
    print(lmfit.Model(law, independent_vars=["p", "e"]).fit(data.force_N, p=data.pressure_MPa,
        e=data.displacement_mm / 200, a0=0, a1=2000, b0=0, b1=5000, c0=0, c1=500, mu=45).best_values)
"""
LAPS = 30
"""Times that the loop goes over its files, so that its start does not count."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class Cost(NamedTuple):
    """Of a process and its workers: seconds on the clock and of all cores, peak memory in MiB of the largest."""

    clock: float
    cores: float
    memory: float


def timed(*words: object) -> Cost:
    code = (
        "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL);"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN);"
        "print(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)"
    )
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": str(ROOT)}
    begin = time.perf_counter()
    command = [sys.executable, "-c", code, sys.executable, *map(str, words)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return Cost(time.perf_counter() - begin, *map(float, done.stdout.split()))


def batch(tree: Path, out: Path, *options: object) -> Cost:
    return timed(ROOT / "cli.py", "batch", tree, "--law", "exponential_law", "--out", out, *options)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=2000)
    parser.add_argument("--peers", type=int, default=10)
    asked = parser.parse_args()
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        paths = []
        for k in range(asked.records):
            place = folder / "tree" / ("first" if k < asked.records // 4 else "rest") / f"r{k:05d}"
            place.mkdir(parents=True)
            paths.append(write_record(place, seed=k))
        one = batch(folder / "tree", folder / "one", "--workers", 1)
        two = batch(folder / "tree", folder / "two")
        dask = batch(folder / "tree", folder / "dask", "--workers", 2)
        again = batch(folder / "tree", folder / "two")
        quarter = batch(folder / "tree" / "first", folder / "quarter", "--workers", 1)
        same = len({(folder / out / "results.parquet").read_bytes() for out in ("one", "two", "dask")}) == 1
        some = paths[:: max(len(paths) // asked.peers, 1)][: asked.peers]
        lines = Path(__file__).with_name("ten_lines_of_lmfit.py")
        script = [timed(lines, path) for path in some]
        loop = timed("-c", LOOP, *(some * LAPS))
    n, peers = asked.records, len(some)
    rows = {
        "batch, one worker": (one.clock / n, one.cores / n),
        "batch, two processes": (two.clock / n, two.cores / n),
        "batch, two workers of Dask": (dask.clock / n, dask.cores / n),
        "batch, all kept from before": (again.clock / n, again.cores / n),
        "lmfit script, a process a file": (sum(c.clock for c in script) / peers, sum(c.cores for c in script) / peers),
        "lmfit in a loop, parameters alone": (loop.clock / (LAPS * peers), loop.cores / (LAPS * peers)),
    }
    print(f"{n} records of 5000 rows, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    print("| | time a record | time of cores a record | of two processes |\n|---|---:|---:|---:|")
    for name, (clock, cores) in rows.items():
        print(f"| {name} | {1e3 * clock:.1f} ms | {1e3 * cores:.1f} ms | {clock * n / two.clock:.2f} |")
    gain, peer = one.clock / two.clock, rows["lmfit script, a process a file"][0] * n / two.clock
    print(f"\n{n / one.cores:.0f} records a second of a core; a second process gains {gain:.2f}", end=", ")
    print(f"a second worker of Dask {one.clock / dask.clock:.2f}")
    print(f"peak memory {one.memory:.0f} MiB, of a quarter of the records {quarter.memory:.0f} MiB")
    print(f"the tables of all three are {'the same bytes' if same else 'NOT THE SAME'}")
    missed = (gain < 1.8) + (peer < 20.0) + (one.memory > 1.2 * quarter.memory) + (not same)
    print(f"{missed} targets missed")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
