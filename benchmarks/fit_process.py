"""`pam-ident fit` on 5000 rows beside a ten-line lmfit script that fits the same law, as whole processes in one run.

    python benchmarks/fit_process.py [--times 9]

Both read the same CSV, fit the exponential law to all of it and print its parameters; they take turns. Exits with 1
where the ratio of the medians is above 0.7.
"""

import argparse
import json
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
TARGET = 0.7
TRUTH = {"a0": -197.8, "a1": 2442.0, "b0": 1735.0, "b1": 5464.0, "c0": -9.3, "c1": 688.3, "mu": 45.0}


def write_record(folder: Path, rows: int = 5000, seed: int = 1) -> Path:
    """Five isobars, ten strokes each, 1 N of noise."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(rows) * 0.05
    p = np.repeat([0.1, 0.3, 0.5, 0.2, 0.4], rows // 5)
    phase = np.tile(np.linspace(0.0, 10.0, rows // 5), 5)
    x = 40.0 * np.abs((phase + 1.0) % 2.0 - 1.0)
    e, t = x / 200.0, TRUTH
    force = t["a0"] + t["a1"] * p - (t["b0"] + t["b1"] * p) * e + (t["c0"] + t["c1"] * p) * np.exp(-t["mu"] * e)
    columns = np.column_stack([time_s, p, x, force + rng.normal(0.0, 1.0, rows)])
    path = folder / "record.csv"
    header = "time_s,pressure_MPa,displacement_mm,force_N"
    np.savetxt(path, columns, delimiter=",", header=header, comments="", fmt="%.6g")
    (folder / "specimen.toml").write_text(
        '[specimen]\nname = "bench"\ninitial_length_mm = 200.0\ninitial_radius_mm = 10.0\nbraid_angle_deg = 25.4\n'
    )
    return path


def timed(command: list[str]) -> tuple[float, str]:
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    return time.perf_counter() - start, done.stdout


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=9)
    times = parser.parse_args().times
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        record = write_record(folder)
        answer = folder / "fit.json"
        ours = [sys.executable, "cli.py", "fit", str(record), "--law", "exponential_law", "--json", str(answer)]
        theirs = [sys.executable, str(Path(__file__).with_name("ten_lines_of_lmfit.py")), str(record)]
        _, text = timed(theirs)
        timed(ours)
        values = json.loads(answer.read_text())["branches"]["together"]["parameters"]
        for key in TRUTH:
            found = re.search(rf"^ +{key}: +(\S+)", text, re.M)
            assert found, f"lmfit printed no {key}"
            other = float(found[1])
            assert abs(other - values[key]["value"]) < 0.1 * values[key]["stderr"] + 1e-6 * abs(other), (key, other)
        taken: dict[str, list[float]] = {"pam-ident fit": [], "lmfit script": []}
        for _ in range(times):
            taken["pam-ident fit"].append(timed(ours)[0])
            taken["lmfit script"].append(timed(theirs)[0])
    middle = {key: statistics.median(values) for key, values in taken.items()}
    for key, values in taken.items():
        print(f"{key}: median {middle[key]:.3f} s, {min(values):.3f} to {max(values):.3f} s, {times} times")
    ratio = middle["pam-ident fit"] / middle["lmfit script"]
    print(f"ratio {ratio:.2f} (the same parameters to a tenth of a standard error)")
    return int(ratio > TARGET)


if __name__ == "__main__":
    sys.exit(main())
