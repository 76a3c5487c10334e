"""A record larger than memory: written by the rig in chunks, fitted in chunks, beside the fit in memory.

    python benchmarks/stream.py [GB] [FOLDER]     size of the record (default 0.1), folder for it and for its columns

The rig repeats a run of 43,000 rows with fresh noise. Each fit is a process of its own, so that its peak of memory is
its own: `pam-ident fit` in chunks; and in memory, where there is room for it, `fitting.fit` of all rows at once, and
of a smaller record `pam-ident fit` and the solver without sums over chunks. Printed are rates, peaks and how far
apart the parameters are. It exits with 1 where the fit in chunks takes more than 1 GiB, or its parameters differ from
any other's by more than 1e-9. The files are deleted.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pam_ident.records.files import free_memory

ROOT = Path(__file__).parents[1]
RUN = "[protocol]\npressures_MPa = [0.1, 0.2, 0.3, 0.4, 0.5]\nspeeds_mm_s = [10]\ncycles_per_speed = 2\n" + (
    "hold_s = 1.0\nmove_rows = 2000\nhold_rows = 150\n"
)
ROWS, BYTES_A_ROW = 43_000, 48.6
PEAK = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL); " + (
    "used = resource.getrusage(resource.RUSAGE_CHILDREN); print(used.ru_utime + used.ru_stime, used.ru_maxrss / 2**20)"
)
ROOM = 180
"""Bytes of memory for a row of a record that is fitted in memory."""
AT_ONCE = """
from pam_ident.records.long import open_long
with open_long(sys.argv[1]) as on_disk:
    record = on_disk.sample(len(on_disk))
assert len(record) == len(on_disk)
found = fit(model, record, detail=False)
"""
SOLVED = """
from pam_ident.fitting import VariableProjection
from pam_ident.records import read_record
found = fit(model, read_record(sys.argv[1]), detail=False, solver=VariableProjection())
"""
BEGIN = """
import json, sys
from pam_ident.fitting import fit
from pam_ident.model import Model
model = Model.build("exponential_law")
"""
END = """
json.dump(found.values, open(sys.argv[2], "w"))
"""


def timed(folder: Path, *words: object) -> tuple[float, float, float]:
    """Seconds on the clock and of the processor, and peak memory in GiB, of Python with some words."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **one_thread, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder)}
    begin = time.perf_counter()
    command = [sys.executable, "-c", PEAK, sys.executable, *map(str, words)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    cores, peak = map(float, done.stdout.split())
    return time.perf_counter() - begin, cores, peak


def fitted(folder: Path, path: Path, *more: str) -> tuple[tuple[float, float, float], dict[str, float]]:
    """What `pam-ident fit` took, and the parameters of both branches together."""
    target = folder / "answer.json"
    cost = timed(folder, ROOT / "cli.py", "fit", path, "--law", "exponential_law", "--json", target, *more)
    found = json.loads(target.read_text())["branches"]["together"]["parameters"]
    return cost, {name: one["value"] for name, one in found.items()}


def solved(folder: Path, path: Path, how: str) -> tuple[tuple[float, float, float], dict[str, float]]:
    """The same for a fit in Python."""
    target = folder / "solved.json"
    return timed(folder, "-c", BEGIN + how + END, path, target), json.loads(target.read_text())


def main(gigabytes: float = 0.1, where: str | None = None) -> int:
    with tempfile.TemporaryDirectory(dir=where) as name:
        folder = Path(name)
        (folder / "run.toml").write_text(RUN)
        times = max(1, round(1e9 * gigabytes / ROWS / BYTES_A_ROW))
        words = ("--protocol", folder / "run.toml", "--law", "exponential_law", "--repeat", times)
        written = timed(folder, ROOT / "cli.py", "rig", folder / "record", *words)
        path = folder / "record" / "record.csv"
        size, rows = path.stat().st_size, ROWS * times
        chunked, mine = fitted(folder, path, "--chunked")
        others, free = {}, free_memory()
        if ROOM * rows < free:
            others["fit of all rows in memory"] = solved(folder, path, AT_ONCE)
        if size < free / 8:
            others |= {"`pam-ident fit`": fitted(folder, path), "solver in memory": solved(folder, path, SOLVED)}
    costs = {name: cost for name, (cost, _) in others.items()}
    apart = {name: furthest(mine, values) for name, (_, values) in others.items()}
    print(f"{rows} rows, {size / 1e9:.2f} GB, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores\n")
    print("| | on the clock, s | of cores, s | MB/s of cores | million rows/s of cores | peak, GiB |")
    print("|---|---:|---:|---:|---:|---:|")
    for name, (clock, cores, peak) in {"rig writes it": written, "fit in chunks": chunked, **costs}.items():
        print(
            f"| {name} | {clock:.1f} | {cores:.1f} | {size / cores / 1e6:.0f} | {rows / cores / 1e6:.2f} | {peak:.2f} |"
        )
    for name, most in apart.items():
        print(f"parameters of the {name} are {most:.1e} apart, relative")
    return int(chunked[2] > 1.0 or any(most > 1e-9 for most in apart.values()))


def furthest(mine: dict[str, float], other: dict[str, float]) -> float:
    """The largest relative difference of a parameter."""
    return max(abs(mine[key] / value - 1.0) for key, value in other.items())


if __name__ == "__main__":
    sys.exit(main(*map(float, sys.argv[1:2]), *sys.argv[2:3]))
