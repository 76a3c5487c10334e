"""Held-out error with everything chosen anew in each part, over that by refits of what was chosen on all rows.

    python benchmarks/nested_heldout.py [--records 100] [--seed 1] [--by cycle]

The ladder is climbed on each record of a challenge set, thinned to 2000 rows. A row for the records whose ladder names
nothing and one for the others: how many, quartiles of the ratio, its extremes, how many between 0.95 and 1.05.
"""

import argparse
import os
from pathlib import Path
from tempfile import TemporaryDirectory

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # before numpy is imported

import numpy as np

from pam_ident.diagnosis import climb, heldout_rmse
from pam_ident.diagnosis.nested import anew, masks_of
from pam_ident.fitting import Fit
from pam_ident.model import Model
from pam_ident.records import Record, read_record, thinned
from pam_ident.rig.challenge import make_challenge
from pam_ident.tasks.gate import computing

ROWS = 2000


def top(model: Model, record: Record) -> Fit:
    """The last rung of a ladder."""
    return climb(model, record, detail=False).rungs[-1].fit


def ratio_of(record: Record, model: Model, by: str) -> tuple[int, float]:
    """Effects on the last rung, and its nested error over that by refits."""
    masks = masks_of(record, by)
    with computing(record):
        last = top(model, record)
        (found,) = anew(record, masks, lambda part: [top(model, part)], 1)
        return len(last.model.terms), float(found) / heldout_rmse(last.model, record, last, masks)


def row(name: str, ratios: np.ndarray) -> str:
    """A line of the table."""
    low, middle, high = np.percentile(ratios, [25, 50, 75])
    near = int(np.sum((ratios > 0.95) & (ratios < 1.05)))
    ends = f"{ratios.min():.3f} to {ratios.max():.3f}"
    return f"| {name} | {len(ratios)} | {low:.3f}, {middle:.3f}, {high:.3f} | {ends} | {near} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--by", default="cycle")
    asked = parser.parse_args()
    found = []
    with TemporaryDirectory() as folder:
        for one in make_challenge(folder, asked.records, asked.seed):
            record = thinned(read_record(Path(folder, one["case"], "record.csv")), ROWS)
            found.append(ratio_of(record, Model(one["law"]), asked.by))
            print(one["case"], one["truth"], f"{found[-1][0]} effects, ratio {found[-1][1]:.3f}", flush=True)
    counts, ratios = (np.array(values) for values in zip(*found, strict=True))
    print(
        "",
        "| ladder | records | quartiles of the ratio | extremes | 0.95 to 1.05 |",
        "|---|---:|---|---|---:|",
        sep="\n",
    )
    for name, rows in (("names nothing", counts == 0), ("names something", counts > 0)):
        if rows.any():
            print(row(name, ratios[rows]))


if __name__ == "__main__":
    main()
