"""A record larger than memory: written by the rig in chunks, fitted in chunks, beside the fit in memory.

    python benchmarks/stream.py [GB] [FOLDER]     size of the record (default 0.1), folder for it and for its columns

The rig repeats a run of 43,000 rows with fresh noise. Each fit is `pam-ident fit` in a process of its own, so that its
peak of memory is its own: in chunks, and in memory where the record takes no more than an eighth of what is free.
Printed are rates, peaks and how far apart the parameters are: of `fit` in memory, and of the solver. It exits with 1
where the fit in chunks takes more than 1 GiB, or its parameters differ from either by more than 1e-9. The files are
deleted.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
RUN = "[protocol]\npressures_MPa = [0.1, 0.2, 0.3, 0.4, 0.5]\nspeeds_mm_s = [10]\ncycles_per_speed = 2\n" + (
    "hold_s = 1.0\nmove_rows = 2000\nhold_rows = 150\n"
)
ROWS, BYTES_A_ROW = 43_000, 48.6
PEAK = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL); " + (
    "used = resource.getrusage(resource.RUSAGE_CHILDREN); print(used.ru_utime + used.ru_stime, used.ru_maxrss / 2**20)"
)


def timed(folder: Path, *words: object) -> tuple[float, float, float]:
    """Seconds on the clock and of the processor, and peak memory in GiB, of `pam-ident` with some words."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **one_thread, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder)}
    begin = time.perf_counter()
    command = [sys.executable, "-c", PEAK, sys.executable, str(ROOT / "cli.py"), *map(str, words)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    cores, peak = map(float, done.stdout.split())
    return time.perf_counter() - begin, cores, peak


def fitted(folder: Path, path: Path, *more: str) -> tuple[tuple[float, float, float], dict]:
    """What a fit took, and what it answered for both branches together."""
    target = folder / "answer.json"
    cost = timed(folder, "fit", path, "--law", "exponential_law", "--json", target, *more)
    return cost, json.loads(target.read_text())["branches"]["together"]


SOLVED = """
import json, sys
from pam_ident.fitting import VariableProjection, fit
from pam_ident.model import Model
from pam_ident.records import read_record
record, model = read_record(sys.argv[1]), Model.build("exponential_law")
json.dump(fit(model, record, detail=False, solver=VariableProjection()).values, open(sys.argv[2], "w"))
"""


def main(gigabytes: float = 0.1, where: str | None = None) -> int:
    with tempfile.TemporaryDirectory(dir=where) as name:
        folder = Path(name)
        (folder / "run.toml").write_text(RUN)
        times = max(1, round(1e9 * gigabytes / ROWS / BYTES_A_ROW))
        words = ("--protocol", folder / "run.toml", "--law", "exponential_law", "--repeat", times)
        written = timed(folder, "rig", folder / "record", *words)
        path = folder / "record" / "record.csv"
        size = path.stat().st_size
        chunked, answer = fitted(folder, path, "--chunked")
        free = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_AVPHYS_PAGES")
        rows = {"rig writes it": written, "fit in chunks": chunked}
        apart: dict[str, float] = {}
        if size < free / 8:
            mine = {key: one["value"] for key, one in answer["parameters"].items()}
            rows["fit in memory"], whole = fitted(folder, path)
            apart["fit in memory"] = furthest(mine, {k: one["value"] for k, one in whole["parameters"].items()})
            subprocess.run([sys.executable, "-c", SOLVED, path, folder / "solved.json"], check=True, cwd=ROOT)
            apart["solver in memory"] = furthest(mine, json.loads((folder / "solved.json").read_text()))
    print(f"{answer['n']} rows, {size / 1e9:.2f} GB, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores\n")
    print("| | on the clock, s | of cores, s | MB/s of cores | million rows/s of cores | peak, GiB |")
    print("|---|---:|---:|---:|---:|---:|")
    for name, (clock, cores, peak) in rows.items():
        rates = f"{size / cores / 1e6:.0f} | {answer['n'] / cores / 1e6:.2f}"
        print(f"| {name} | {clock:.1f} | {cores:.1f} | {rates} | {peak:.2f} |")
    for name, most in apart.items():
        print(f"parameters of the {name} are {most:.1e} apart, relative")
    return int(chunked[2] > 1.0 or any(most > 1e-9 for most in apart.values()))


def furthest(mine: dict[str, float], other: dict[str, float]) -> float:
    """The largest relative difference of a parameter."""
    return max(abs(mine[key] / value - 1.0) for key, value in other.items())


if __name__ == "__main__":
    sys.exit(main(*map(float, sys.argv[1:2]), *sys.argv[2:3]))
