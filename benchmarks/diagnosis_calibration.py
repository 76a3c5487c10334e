"""Are probabilities between 0.1 and 0.9 worth what they say? Faint effects in short and long records, diagnosed.

    python benchmarks/diagnosis_calibration.py [--n 100] [--seed 201 ...] [--workers 2] [--svg FILE]

In a challenge effects stand out, and nearly all statements are near 0 or 1. Here effects leave 0.05 to 0.8 of the
noise, by any form, alone, in pairs or not at all, in white noise or coloured, in records of about 100 to 5000 rows at
two to six pressures. Prints a line a bin with the interval of the truly hidden share (Wilson's, 95 %); `--svg` draws
it. Each seed adds n records.
"""

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np

from pam_ident.core import PamError
from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
from pam_ident.plot import calibration, to_svg
from pam_ident.records import read_record
from pam_ident.rig import Plan, Protocol, Secret, make_record, write_case
from pam_ident.rig.challenge import COLOURED, FAMILY, SHARP, VISIBLE
from pam_ident.rig.hidden import EFFECTS, TooSmall
from pam_ident.schema.diagnosis import diagnosis_json
from pam_ident.validation.calibration import reliability
from pam_ident.validation.score import score

SIZES = (0.05, 0.8)
"""What an effect leaves in the standard protocol, in multiples of the noise."""
SHORT, PAIRS, NOTHING, SLOW, TEXTBOOK = 0.6, 0.2, 0.15, 0.25, 0.5
"""Shares of short records, of pairs, of records with nothing hidden, of coloured noise, of textbook forms."""
BINS = (0.0, 0.01, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.99, 1.0)


def plans(seed: int) -> Iterator[Plan]:
    """Endless plans; the effects of both laws come in turn."""
    rng = np.random.default_rng([seed, 501])
    subjects = [(law, name) for law, names in VISIBLE.items() for name in names]
    for k in count():
        law, name = subjects[k % len(subjects)]
        names = [name] if rng.random() > NOTHING else []
        if names and rng.random() < PAIRS:
            names.append(str(rng.choice([e for e in VISIBLE[law] if FAMILY.get(e, e) != FAMILY.get(name, name)])))
        yield Plan(
            seed=seed * 100_000 + k,
            law=law,
            secrets=tuple(_secret(e, rng) for e in names),
            protocol=_short(rng) if rng.random() < SHORT else str(rng.choice(SHARP)),
            sigma_N=float(rng.choice([1.0, 2.0, 4.0])),
            noise=str(rng.choice(COLOURED)) if rng.random() < SLOW else "white",
            warming="thermal_softening" in names or bool(rng.random() < 0.5),
            other_specimen=bool(rng.random() < 0.4),
        )


def _secret(name: str, rng: np.random.Generator) -> Secret:
    form = "textbook" if rng.random() < TEXTBOOK else str(rng.choice(list(EFFECTS[name])))
    return Secret(name, form, float(np.exp(rng.uniform(*np.log(SIZES)))))


def _short(rng: np.random.Generator) -> Protocol:
    """Two to four pressures, two or three speeds, few rows."""
    return Protocol(
        pressures_MPa=tuple(np.round(np.linspace(0.15, 0.5, int(rng.integers(2, 5))), 2).tolist()),
        speeds_mm_s=((5.0, 40.0), (2.0, 10.0, 40.0))[int(rng.integers(2))],
        cycles_per_speed=int(rng.integers(1, 4)),
        move_rows=int(rng.integers(12, 31)),
        hold_rows=int(rng.integers(4, 10)),
        warming_K=float(rng.choice([0.0, 10.0])),
    )


def statements(plan: Plan) -> tuple[tuple[float, bool], ...] | None:
    """What a diagnosis of one record states, and whether it is so; None where the plan asks for too much."""
    with TemporaryDirectory() as folder:
        try:
            truth = write_case(folder, make_record(plan))
            record = read_record(f"{folder}/record.csv")
            return score(truth, diagnosis_json(folder, diagnose(Model.build(plan.law), record))).statements
        except (TooSmall, PamError):
            return None


def collect(n: int, seed: int, workers: int) -> list[tuple[float, bool]]:
    """Statements on n records of a seed."""
    found: list[tuple[tuple[float, bool], ...]] = []
    source = plans(seed)
    with ProcessPoolExecutor(workers) as pool:
        while len(found) < n:
            some = [next(source) for _ in range(n - len(found))]
            found += [one for one in pool.map(statements, some) if one is not None]
    return [statement for one in found for statement in one]


def show(said: Sequence[tuple[float, bool]]) -> None:
    """A line a bin, and Brier's score."""
    stated, true = zip(*said, strict=True)
    found = reliability(stated, true, BINS)
    shown = calibration.data(found)
    print("| stated | statements | mean stated | truly hidden | share, with 95 % interval |\n|---|---:|---:|---:|---|")
    for one, low, high in zip(found.bins, shown.low, shown.high, strict=True):
        share = f"{one.true / one.n:.3f} ({low:.3f} to {high:.3f})"
        print(f"| {one.low:g} to {one.high:g} | {one.n} | {one.stated:.3f} | {one.true} | {share} |")
    print(f"| Brier score | {len(said)} | {shown.brier:.4f} | | |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=100)
    parser.add_argument("--seed", type=int, nargs="+", default=[201])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--svg")
    args = parser.parse_args()
    said = [one for seed in args.seed for one in collect(args.n, seed, args.workers)]
    show(said)
    if args.svg:
        Path(args.svg).write_text(
            to_svg(calibration.draw(reliability(*zip(*said, strict=True), BINS))), encoding="utf-8"
        )
