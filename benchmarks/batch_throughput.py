"""`pam-ident batch` over many records of 5000 rows: records a second, a second worker's gain, memory, lmfit beside it.

    python benchmarks/batch_throughput.py [--records 2000] [--peers 10]

Whole processes in one run: the batch with one worker, with two (both tables must be the same bytes), and over a
quarter of the records, whose peak memory must be the same within a fifth. The peers do some of the same files and are
scaled up: the ten-line lmfit script once a file, as a user would loop over it in a shell, and the same fit looped in
one process, which finds no strokes, no noise floor and no errors that allow for correlation, and keeps nothing.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

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
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def timed(*words: object) -> tuple[float, float]:
    """Seconds of a process, and the peak memory in MiB of the largest of it and its workers."""
    code = (
        "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL);"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    )
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": str(ROOT)}
    begin = time.perf_counter()
    command = [sys.executable, "-c", code, sys.executable, *map(str, words)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return time.perf_counter() - begin, int(done.stdout) / 1024


def batch(tree: Path, out: Path, workers: int) -> tuple[float, float]:
    return timed(ROOT / "cli.py", "batch", tree, "--law", "exponential_law", "--out", out, "--workers", workers)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=2000)
    parser.add_argument("--peers", type=int, default=10)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        paths = []
        for k in range(asked.records):
            place = folder / "tree" / ("first" if k < asked.records // 4 else "rest") / f"r{k:05d}"
            place.mkdir(parents=True)
            paths.append(write_record(place, seed=k))
        one, memory = batch(folder / "tree", folder / "one", 1)
        two, _ = batch(folder / "tree", folder / "two", 2)
        again, _ = batch(folder / "tree", folder / "two", 2)
        _, quarter = batch(folder / "tree" / "first", folder / "quarter", 1)
        same = len({(folder / out / "results.parquet").read_bytes() for out in ("one", "two")}) == 1
        some = paths[:: max(len(paths) // asked.peers, 1)][: asked.peers]
        script = sum(timed(Path(__file__).with_name("ten_lines_of_lmfit.py"), path)[0] for path in some) / len(some)
        loop = timed("-c", LOOP, *some, *some, *some)[0] / (3 * len(some))
    n = asked.records
    print(f"{n} records of 5000 rows, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    print("| | time a record | of two workers |\n|---|---:|---:|")
    print(f"| batch, one worker | {1e3 * one / n:.1f} ms | {one / two:.2f} |")
    print(f"| batch, two workers | {1e3 * two / n:.1f} ms | 1.00 |")
    print(f"| batch, all kept from before | {1e3 * again / n:.1f} ms | {again / two:.2f} |")
    print(f"| lmfit script, a process a file | {1e3 * script:.1f} ms | {script * n / two:.1f} |")
    print(f"| lmfit in a loop, parameters alone | {1e3 * loop:.1f} ms | {loop * n / two:.2f} |")
    print(f"\n{n / one:.0f} records a second and core; peak memory {memory:.0f} MiB, of a quarter {quarter:.0f} MiB")
    print(f"the tables of one and two workers are {'the same bytes' if same else 'NOT THE SAME'}")
    missed = (one / two < 1.8) + (script * n / two < 20.0) + (memory > 1.2 * quarter) + (not same)
    print(f"{missed} targets missed")
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
