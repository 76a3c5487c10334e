"""A tree of made-up records whose parameters are known, and the program as a process that can be killed."""

import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np

from pam_ident.batch.table import read_results

ROOT = Path(__file__).parents[2]
TRUTH = {"a0": -190.0, "a1": 2400.0, "b0": 900.0, "b1": 5500.0, "c0": 20.0, "c1": 690.0, "mu": 45.0}
LAW = ("--law", "exponential_law")


def write_tree(folder: Path, count: int, noise: float = 1.0) -> Path:
    """`count` records of 720 rows: three isobars, six strokes each; a1 grows with the length of the muscle."""
    for k in range(count):
        place = folder / f"muscle{k:02d}"
        place.mkdir(parents=True)
        length = 200.0 + 10.0 * (k % 5)
        phase = np.tile(np.linspace(0.0, 6.0, 240, endpoint=False), 3)
        x = 24.0 * np.abs((phase + 1.0) % 2.0 - 1.0)
        p = np.repeat([0.3, 0.2, 0.4], 240)
        e, q = x / length, TRUTH | {"a1": a1_of(length)}
        force = q["a0"] + q["a1"] * p - (q["b0"] + q["b1"] * p) * e + (q["c0"] + q["c1"] * p) * np.exp(-q["mu"] * e)
        force = force + np.random.default_rng(k).normal(0.0, noise, len(e))
        table = np.column_stack([0.05 * np.arange(len(e)), p, x, force])
        header = "time_s,pressure_MPa,displacement_mm,force_N"
        np.savetxt(place / "run.csv", table, delimiter=",", header=header, comments="", fmt="%.6f")
        (place / "specimen.toml").write_text(
            f'[specimen]\nname = "made {k}"\nserial_number = "B-{100 + k}"\ninitial_length_mm = {length}\n'
            "initial_radius_mm = 10.0\nbraid_angle_deg = 25.4\n"
        )
    return folder


def a1_of(length: float) -> float:
    """The true a1 of a muscle in N/MPa."""
    return 2400.0 + 5.0 * (length - 200.0)


def environment() -> dict[str, str]:
    """The checkout importable, and one thread a process."""
    return {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}


def start(tree: Path, out: Path, *more: object, **options) -> subprocess.Popen:
    """`pam-ident batch` as a process of its own."""
    words = [sys.executable, ROOT / "cli.py", "batch", tree, *LAW, "--out", out, *more]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([str(word) for word in words], env=environment(), **pipes, **options)


def finish(process: subprocess.Popen) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a process that ends by itself."""
    stdout, stderr = process.communicate(timeout=120)
    return process.returncode, stdout, stderr


def answers(out: Path) -> dict[str, tuple[int, int]]:
    """Inode and time of writing of each answer that is kept: both stay where nothing is done twice."""
    found = {path.name: path.stat() for path in out.glob("records/*/*.json")}
    return {name: (stat.st_ino, stat.st_mtime_ns) for name, stat in found.items()}


def frame(out: Path):
    """The table."""
    return read_results(out)


def work_that_kills(item):
    """Work whose record `bad` takes its worker with it always, `once` the first time."""
    marker = Path(item.path)
    if item.name == "bad" or (item.name == "once" and not marker.exists()):
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return item.name


def work_that_runs_out(item):
    """Work whose record `bad` asks for more memory than there is always, `once` the first time; then its process has
    none left."""
    marker = Path(item.path)
    if item.name == "bad" or (item.name == "once" and not marker.exists()):
        marker.touch()
        resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
        np.ones(1 << 32)
    return item.name
