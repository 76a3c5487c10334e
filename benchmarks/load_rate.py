"""How fast a long CSV is read, beside pandas, and how much memory it takes.

    python benchmarks/load_rate.py [ROWS] [FOLDER]     rows (default 10 million, about 1 GB), folder for the file

Each way of reading runs in a process of its own, so that its peak of memory is its own: pandas.read_csv of the whole
file; the columns of a record in internal units, whole; the same columns block by block, none of them kept; and, with
strokes, cycles and isobars found, the record in memory and the record on disk. The file is deleted afterwards.

The ways take turns, ROUNDS times. Times are the least of each, on the clock and on the processor: another's work on the
same machine makes either longer, never shorter. Ends with 1 where columns, whole or by blocks, come at less than LEAST
of pandas' rate by the processor, or the record on disk takes more than MOST_GIB.
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
ROUNDS, LEAST, MOST_GIB = 5, 0.6, 0.6
READ = """
import resource, sys, time
import numpy as np, pandas as pd
from pathlib import Path
from pam_ident.records.columns import join_runs, read_columns
from pam_ident.records.sources import find_sources
from pam_ident.records.text_table import read_text
path = Path(sys.argv[1])
start = time.perf_counter(), time.process_time()
{what}
wall, processor = time.perf_counter() - start[0], time.process_time() - start[1]
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(len(found), wall, processor, peak / 2**20)
"""
PANDAS, WHOLE, BLOCKS = "pandas.read_csv", "columns of a record, whole", "columns, block by block"
ON_DISK = "record on disk, in chunks"
WAYS = {
    PANDAS: "found = pd.read_csv(path)",
    WHOLE: """
(table,) = read_text(path)
found = join_runs(read_columns(table, find_sources(table), 200.0), str(path))["force"]""",
    BLOCKS: """
(table,) = read_text(path)
sources = find_sources(table)
wanted = [source.position for source in sources.values()]
found = range(sum(len(block) for block in table.read(wanted)))""",
    "record, whole, with its strokes": """
from pam_ident.records import read_record
found = read_record(path)""",
    ON_DISK: """
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


def main(rows: int = 10_000_000, folder: str | None = None) -> int:
    where = Path(tempfile.mkdtemp(dir=folder))
    path = where / "record.csv"
    try:
        write(path, rows)
        (where / "specimen.toml").write_text(SPECIMEN)
        size = path.stat().st_size
        print(f"{rows} rows, {size / 1e9:.3f} GB, least of {ROUNDS}")
        print(f"{'':32}{'clock, s':>9}{'of pandas':>10}{'processor, s':>13}{'of pandas':>10}{'peak, GiB':>10}")
        found: dict[str, list[list[float]]] = {name: [] for name in WAYS}
        for _ in range(ROUNDS):
            for name, what in WAYS.items():
                words = [sys.executable, "-c", READ.format(what=what), str(path)]
                answer = subprocess.run(words, check=True, capture_output=True, text=True, cwd=ROOT).stdout.split()
                assert int(answer[0]) == rows, answer
                found[name].append([float(x) for x in answer[1:]])
    finally:
        shutil.rmtree(where)
    least = {name: [min(column) for column in zip(*runs, strict=True)] for name, runs in found.items()}
    peaks = {name: max(run[2] for run in runs) for name, runs in found.items()}
    of_pandas = {name: [least[PANDAS][k] / least[name][k] for k in (0, 1)] for name in WAYS}
    for name, (clock, processor, _) in least.items():
        rates = of_pandas[name]
        print(f"{name:32}{clock:9.2f}{rates[0]:10.2f}{processor:13.2f}{rates[1]:10.2f}{peaks[name]:10.2f}")
    slow = min(of_pandas[name][1] for name in (WHOLE, BLOCKS)) < LEAST
    return int(slow or peaks[ON_DISK] > MOST_GIB)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:2]), *sys.argv[2:3]))
