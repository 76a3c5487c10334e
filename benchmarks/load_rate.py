"""How fast a long CSV is read, beside pandas, and how much memory it takes.

    python benchmarks/load_rate.py [ROWS] [FOLDER]     rows (default 10 million, about 1 GB), folder for the file

Each way of reading runs in a process of its own, so that its peak of memory is its own: pandas.read_csv of the whole
file; the columns of a record in internal units, whole; the same columns block by block, none of them kept; and, with
strokes, cycles and isobars found, the record in memory and the record on disk. The file is deleted afterwards.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

ROOT = Path(__file__).parents[1]
HEADER = "time_s,pressure_MPa,displacement_mm,force_N,temperature_C,supply_MPa,valve_V,strain_1,strain_2"
PIECE = 100_000
READ = """
import resource, sys, time
import numpy as np, pandas as pd
from pathlib import Path
from pam_ident.records.columns import join_runs, read_columns
from pam_ident.records.quantities import find_sources
from pam_ident.records.text_table import read_text
path = Path(sys.argv[1])
start = time.perf_counter()
{what}
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(len(found), seconds, peak / 2**20)
"""
WAYS = {
    "pandas.read_csv": "found = pd.read_csv(path)",
    "columns of a record, whole": """
(table,) = read_text(path)
found = join_runs(read_columns(table, find_sources(table), 200.0), str(path))["force"]""",
    "block by block": """
(table,) = read_text(path)
sources = find_sources(table)
wanted = [source.position for source in sources.values()]
found = range(sum(len(block) for block in table.read(wanted)))""",
    "record, whole, with its strokes": """
from pam_ident.records import read_record
found = read_record(path)""",
    "record on disk, in chunks": """
from pam_ident.records.long import open_long
with open_long(path) as found:
    pass""",
}
SPECIMEN = '[specimen]\nname = "long"\ninitial_length_mm = 200.0\ninitial_radius_mm = 10.0\nbraid_angle_deg = 25.4\n'


def write(path: Path, rows: int) -> None:
    """A sine of 0.2 Hz at one pressure, logged at 1 kHz, with noise; a PIECE of other columns again and again."""
    import numpy as np

    rng = np.random.default_rng(0)
    rest = rng.normal((22.0, 0.7, 2.5, 1e-3, 1e-3), (0.1, 1e-3, 0.1, 1e-4, 1e-4), (PIECE, 5))
    with path.open("w") as file:
        file.write(HEADER + "\n")
        for begin in range(0, rows, PIECE):
            t = 1e-3 * np.arange(begin, min(begin + PIECE, rows))
            x = 20.0 - 20.0 * np.cos(0.4 * np.pi * t)
            p, force = rng.normal(0.3, 1e-4, len(t)), 900.0 - 20.0 * x + rng.normal(0.0, 1.0, len(t))
            table = np.column_stack([t, p, x, force, rest[: len(t)]])
            np.savetxt(file, table, fmt="%.3f,%.8f,%.7f,%.6f,%.5f,%.7f,%.7f,%.9f,%.9f")


def main(rows: int = 10_000_000, folder: str | None = None) -> None:
    where = Path(tempfile.mkdtemp(dir=folder))
    path = where / "record.csv"
    try:
        write(path, rows)
        (where / "specimen.toml").write_text(SPECIMEN)
        size = path.stat().st_size
        print(f"{rows} rows, {size / 1e9:.3f} GB")
        times: dict[str, list[float]] = {name: [] for name in WAYS}
        peaks: dict[str, float] = {}
        for _ in range(3):
            for name, what in WAYS.items():
                words = [sys.executable, "-c", READ.format(what=what), str(path)]
                answer = subprocess.run(words, check=True, capture_output=True, text=True, cwd=ROOT).stdout.split()
                assert int(answer[0]) == rows, answer
                times[name].append(float(answer[1]))
                peaks[name] = float(answer[2])
        pandas = min(times["pandas.read_csv"])
        print(f"{'':28} {'seconds':>8} {'GB/s':>6} {'of pandas':>9} {'peak, GiB':>9}   best of three")
        for name, seconds in times.items():
            best = min(seconds)
            print(f"{name:28} {best:8.2f} {size / best / 1e9:6.2f} {pandas / best:9.2f} {peaks[name]:9.2f}")
    finally:
        shutil.rmtree(where)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]), *sys.argv[2:3])
