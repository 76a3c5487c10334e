"""How often the 95 % interval of a new reading holds it, with cycles, pressures and speeds left out.

    python benchmarks/prediction_coverage.py [--records 500] [--seed 1] [--real]

Each record of a challenge set (nine in ten hide an effect that the law does not have) is fitted without some of its
cycles, without one of its inner pressures, without its lowest or highest, and without one of its speeds; each time the
interval is foretold for the readings that were left out. A row a kind: records, the share of all readings inside, the
quartiles of that share over the records, and the median half width over the rms error of the same readings. With --real
the same of the measured muscles, ten draws of each kind a record.
"""

import argparse
import os
from pathlib import Path
from tempfile import TemporaryDirectory

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # before numpy is imported

import numpy as np

from pam_ident.core import PamError
from pam_ident.fitting import fit
from pam_ident.fitting.prediction import Predictor, _speeds, reading_spread
from pam_ident.model import Model
from pam_ident.records import Record, read_record, thinned
from pam_ident.rig.challenge import make_challenge
from pam_ident.tasks.law_choice import choose_law
from pam_ident.tasks.setup import AUTO, Setup

KINDS = ("cycles", "inner pressure", "end pressure", "speed")


def left_out(record: Record, kind: str, rng: np.random.Generator) -> np.ndarray | None:
    """Mask of the readings to leave out; None where the record has none to spare."""
    levels, speed = record.levels, _speeds(record)
    if kind == "cycles":
        blocks = np.unique(record.block)
        if len(blocks) < 6:
            return None
        return np.isin(record.block, rng.choice(blocks, max(len(blocks) // 6, 1), replace=False))
    if kind == "inner pressure":
        return record.level == rng.choice(levels[1:-1]) if len(levels) > 4 else None
    if kind == "end pressure":
        return record.level == rng.choice(levels[[0, -1]]) if len(levels) > 4 else None
    speeds = np.unique(speed[speed > 0])
    return speed == rng.choice(speeds) if len(speeds) > 2 else None


def covered(record: Record, law: str, kind: str, rng: np.random.Generator) -> tuple[float, float, int] | None:
    """Share of the readings left out that their interval holds, its half width over their rms error, and how many."""
    out = left_out(record, kind, rng)
    if out is None:
        return None
    seen, unseen = record.take(np.flatnonzero(~out)), record.take(np.flatnonzero(out))
    one = fit(Model(law), seen)
    found = Predictor.of(one, reading_spread(one)).at(unseen.inputs)
    error = unseen.force - found.force
    if np.isnan(found.half_reading).any():
        return None
    inside = np.abs(error) <= found.half_reading
    return float(inside.mean()), float(np.median(found.half_reading) / np.sqrt(np.mean(error**2))), len(error)


def table(records: list[tuple[Record, str]], seed: int) -> list[str]:
    """Rows of the table over some records."""
    rng = np.random.default_rng(seed)
    lines = [
        "| left out | records | readings inside | quartiles over records | half width / rms |",
        "|---|---|---|---|---|",
    ]
    for kind in KINDS:
        rows = []
        for record, law in records:
            try:
                rows.append(covered(record, law, kind, rng))
            except PamError:
                continue
        rows = np.array([row for row in rows if row is not None])
        if not len(rows):
            continue
        share, width, n = rows.T
        low, middle, high = np.percentile(100 * share, [25, 50, 75])
        lines.append(
            f"| {kind} | {len(rows)} | {100 * np.average(share, weights=n):.1f} % "
            f"| {low:.0f}, {middle:.0f}, {high:.0f} % | {np.median(width):.2f} |"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--records", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--real", action="store_true")
    asked = parser.parse_args()
    with TemporaryDirectory() as folder:
        truth = make_challenge(folder, asked.records, asked.seed)
        cases = [(thinned(read_record(Path(folder, one["case"], "record.csv")), 4000), one["law"]) for one in truth]
    print(*table(cases, asked.seed), sep="\n")
    for record in measured() if asked.real else ():
        law = choose_law(record, Setup(AUTO)).law
        print("", f"{record.name}, {law}:", *table(10 * [(thinned(record, 4000), law)], asked.seed), sep="\n")


def measured() -> list[Record]:
    """The measured muscles: the static map that comes along, and those beside the checkout."""
    from real_records import REALDATA, records

    return list(records(REALDATA))


if __name__ == "__main__":
    main()
