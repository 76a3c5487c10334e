"""How often the 95 % interval of a new reading holds it, with cycles, pressures and speeds left out.

    python benchmarks/prediction_coverage.py [--records 500] [--seed 1] [--real]

Each record of a challenge set (nine in ten hide an effect that the law does not have) is fitted without some of its
cycles, without one of its inner pressures, without its lowest or highest, and without one of its speeds; each time the
interval is predicted for the readings that were left out: by the law alone where an effect is hidden, by the law with
that effect, and where nothing is hidden. A row a kind: records, the share of all readings inside, the quartiles of that
share over the records, the median half width over the rms error of the same readings and over that of the noise alone,
and how often the answer says that it is wide because something is missing. With --real the same of the measured
muscles, ten draws of each kind a record.
"""

import argparse
import math
import os
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

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

Case = tuple[Record, Model, float]
"""A record, the model to fit, and the standard deviation of its noise in N, NaN where it is not known."""
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


def covered(case: Case, kind: str, rng: np.random.Generator) -> tuple[float, ...] | None:
    """Of the readings left out: the share that their interval holds, its half width over their rms error and over that
    of the noise alone, whether it is told to be wide by what the model lacks, and how many they are."""
    record, model, noise = case
    out = left_out(record, kind, rng)
    if out is None:
        return None
    one = fit(model, record, ~out)
    found = Predictor.of(one, reading_spread(one)).at(record.inputs)
    error, half = (record.force - found.force)[out], found.half_reading[out]
    if np.isnan(half).any():
        return None
    width = float(np.median(half))
    rms = float(np.sqrt(np.mean(error**2)))
    return (
        float(np.mean(np.abs(error) <= half)),
        width / rms,
        width / (1.96 * noise),
        float(found.unexplained[0]),
        len(error),
    )


def table(cases: list[Case], seed: int) -> list[str]:
    """Rows of the table over some records."""
    rng = np.random.default_rng(seed)
    lines = [
        "| left out | records | readings inside | quartiles over records | half width / rms | / 1.96 noise | says so |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind in KINDS:
        rows = []
        for case in cases:
            try:
                rows.append(covered(case, kind, rng))
            except PamError:
                continue
        rows = np.array([row for row in rows if row is not None])
        if not len(rows):
            continue
        share, width, wide, said, n = rows.T
        low, middle, high = np.percentile(100 * share, [25, 50, 75])
        lines.append(
            f"| {kind} | {len(rows)} | {100 * np.average(share, weights=n):.1f} % "
            f"| {low:.0f}, {middle:.0f}, {high:.0f} % | {np.median(width):.2f} | {np.median(wide):.2f} "
            f"| {100 * said.mean():.0f} % |"
        )
    return lines


def groups(records: list[tuple[Record, dict[str, Any]]]) -> dict[str, list[Case]]:
    """Cases by what the model has of the truth."""
    found: dict[str, list[Case]] = {"the model lacks an effect": [], "it has the effect": [], "nothing is hidden": []}
    for record, one in records:
        hidden, noise = bool(one["truth"] or one["unknown"]), one["noise_rms"]
        found["the model lacks an effect" if hidden else "nothing is hidden"].append((record, Model(one["law"]), noise))
        if one["truth"] and not one["unknown"]:
            found["it has the effect"].append((record, Model(one["law"], one["truth"]), noise))
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--records", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--real", action="store_true")
    asked = parser.parse_args()
    with TemporaryDirectory() as folder:
        truth = make_challenge(folder, asked.records, asked.seed)
        records = [(thinned(read_record(Path(folder, one["case"], "record.csv")), 4000), one) for one in truth]
    for name, cases in groups(records).items():
        print("", f"{name}:", *table(cases, asked.seed), sep="\n", flush=True)
    for record in measured() if asked.real else ():
        law = choose_law(record, Setup(AUTO)).law
        print(
            "",
            f"{record.name}, {law}:",
            *table(10 * [(thinned(record, 4000), Model(law), math.nan)], asked.seed),
            sep="\n",
        )


def measured() -> list[Record]:
    """The measured muscles: the bundled static map, and those beside the checkout."""
    from real_records import REALDATA, records

    return list(records(REALDATA))


if __name__ == "__main__":
    main()
