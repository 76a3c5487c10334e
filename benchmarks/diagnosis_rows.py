"""What a diagnosis costs as a record grows: the whole process, its share for reading and fitting, and its memory.

    python benchmarks/diagnosis_rows.py [ROWS ...]     default 5000 50000 200000 1000000

The rig repeats a run of about 5,000 rows, or of 50,000 from there on, with fresh noise and creep hidden. `diagnose` and
`fit` are processes of their own, one thread each. Exits with 1 where a row costs more than 1.5 times as much in the
largest record as in the largest but one, or where creep is not what is named.
"""

import json
import sys
import tempfile
from pathlib import Path

from stream import timed

LAW = "exponential_law"
PROGRAM = ("-m", "pam_ident")
HEAD = "[protocol]\npressures_MPa = [0.1, 0.2, 0.3, 0.4, 0.5]\nspeeds_mm_s = [2, 10, 40]\ncycles_per_speed = 3\n"
RUNS = {
    5_000: "hold_s = 4.0\nmove_rows = 40\nhold_rows = 12\n",
    50_000: "hold_s = 4.0\nmove_rows = 400\nhold_rows = 120\n",
}
ROWS_OF_RUN = {5_000: 4_680, 50_000: 46_800}


def main(sizes: list[int]) -> int:
    print("| rows | diagnose, s | of it fit alone, s | µs a row | peak, GiB | named |\n|---:|---:|---:|---:|---:|---|")
    a_row, names = [], []
    for size in sizes:
        run = max((rows for rows in RUNS if rows <= size), default=5_000)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "run.toml").write_text(HEAD + RUNS[run])
            words = ("--law", LAW, "--effect", "creep", "--repeat", max(1, round(size / ROWS_OF_RUN[run])))
            timed(folder, *PROGRAM, "rig", folder / "set", "--protocol", folder / "run.toml", *words)
            path, target = folder / "set" / "record.csv", folder / "answer.json"
            _, alone, _ = timed(folder, *PROGRAM, "fit", path, "--law", LAW)
            _, seconds, peak = timed(folder, *PROGRAM, "diagnose", path, "--law", LAW, "--json", target)
            answer = json.loads(target.read_text())
        a_row.append(seconds / answer["n"])
        names.append(answer["selected"])
        row = f"{answer['n']} | {seconds:.1f} | {alone:.1f} | {1e6 * a_row[-1]:.0f} | {peak:.2f}"
        print(f"| {row} | {', '.join(answer['selected'])} |", flush=True)
    linear = len(a_row) < 2 or a_row[-1] <= 1.5 * a_row[-2]
    return int(not linear or any(selected != ["creep"] for selected in names))


if __name__ == "__main__":
    sys.exit(main([int(word) for word in sys.argv[1:]] or [5_000, 50_000, 200_000, 1_000_000]))
