"""How often 95 % intervals hold the truth: ours beside lmfit's, over virtual records with white and correlated noise.

    python benchmarks/coverage.py [--records 2000] [--seed 1] [--workers 2]

The virtual rig runs muscles of its own (their coefficients are the truth) through its standard protocol; 2 N of noise
is added, white or AR(1) with ρ = 0.7 from sample to sample, and the noise of its pressure and displacement sensors.
Each record is fitted by the program and by lmfit from the same start. Exits with 1 where an interval of ours holds the
truth in less than 93 % or more than 97 % of the records.
"""

import argparse
import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # before numpy is imported

import lmfit
import numpy as np
from scipy.signal import lfilter

from pam_ident.core import Specimen
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import Record, build_record
from pam_ident.rig import PROTOCOLS
from pam_ident.rig.muscle import draw_muscle, draw_specimen
from pam_ident.rig.sensors import RigSensors

Array = np.ndarray
SIGMA, RHO = 2.0, 0.7
LAWS = {
    "exponential_law": ("a0", "a1", "b0", "b1", "c0", "c1", "mu"),
    "modified_chou_hannaford": ("k0", "k1", "k2"),
}
START = {"a0": 0.0, "a1": 2000.0, "b0": 0.0, "b1": 5000.0, "c0": 0.0, "c1": 500.0, "mu": 45.0}
START |= {"k0": 1.0, "k1": 1.2, "k2": 0.0}


def virtual_record(law: str, rho: float, seed: int) -> tuple[Record, dict[str, float]]:
    """A record with nothing hidden, and the parameters behind it."""
    rng = np.random.default_rng([seed, list(LAWS).index(law), round(10 * rho)])
    muscle = draw_muscle(rng, law, draw_specimen(rng))
    course = PROTOCOLS["standard"].run(muscle, rng)
    rows = course.rows
    p, e, n = course.pressure[rows], course.eps[rows], len(rows)
    kicks = rng.standard_normal(n)
    kicks[1:] *= np.sqrt(1.0 - rho**2)
    force = muscle.force(p, e) + SIGMA * np.asarray(lfilter([1.0], [1.0, -rho], kicks))
    sensors, s = RigSensors(), muscle.specimen
    record = build_record(
        "virtual",
        Specimen("virtual", s.initial_length_mm, s.initial_radius_mm, s.braid_angle_deg, s.wall_thickness_mm),
        p + sensors.pressure_MPa * rng.standard_normal(n),
        e + sensors.displacement_mm / s.initial_length_mm * rng.standard_normal(n),
        force,
        time=course.time[rows],
        level=p,
        cycle=course.cycle[rows],
    )
    return record, asdict(muscle.law)  # type: ignore[call-overload]


def by_hand(law: str, specimen: Specimen) -> Callable[..., Array]:
    """The law as a user of lmfit writes it down."""
    if law == "exponential_law":
        return lambda p, e, a0, a1, b0, b1, c0, c1, mu: (
            a0 + a1 * p - (b0 + b1 * p) * e + (c0 + c1 * p) * np.exp(-mu * e)
        )
    theta = np.radians(specimen.braid_angle_deg)
    a, b, area = 3.0 / np.tan(theta) ** 2, 1.0 / np.sin(theta) ** 2, np.pi * specimen.initial_radius_mm**2
    return lambda p, e, k0, k1, k2: k0 * area * p * (a * (1.0 - k1 * e) ** 2 - b) + k2


def holds(task: tuple[str, float, int]) -> Array:
    """Whether each parameter's interval holds the truth: ours, then lmfit's, shape (2, parameters)."""
    law, rho, seed = task
    record, truth = virtual_record(law, rho, seed)
    names = LAWS[law]
    estimates = {e.name: e for e in fit(Model.build(law), record).estimates}
    ours = [estimates[n].low <= truth[n] <= estimates[n].high for n in names]
    model = lmfit.Model(by_hand(law, record.specimen), independent_vars=["p", "e"])
    inputs = {"p": record.inputs.pressure, "e": record.inputs.contraction}
    found = model.fit(record.force, **inputs, **{n: START[n] for n in names}).params
    theirs = [abs(found[n].value - truth[n]) <= 1.96 * (found[n].stderr or 0.0) for n in names]
    return np.array([ours, theirs])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    asked = parser.parse_args()
    bad = 0
    print(f"| law | noise | {' | '.join(('parameter', 'pam-ident', 'lmfit'))} |\n|---|---|---|---:|---:|")
    with ProcessPoolExecutor(asked.workers) as pool:
        for law, names in LAWS.items():
            for rho in (0.0, RHO):
                tasks = [(law, rho, asked.seed * 1_000_000 + k) for k in range(asked.records)]
                share = np.mean(list(pool.map(holds, tasks, chunksize=20)), axis=0)
                bad += int(np.sum((share[0] < 0.93) | (share[0] > 0.97)))
                for k, name in enumerate(names):
                    noise = f"AR(1), ρ = {rho}" if rho else "white"
                    print(f"| `{law}` | {noise} | `{name}` | {100 * share[0, k]:.1f} % | {100 * share[1, k]:.1f} % |")
    print(f"{asked.records} records each; {bad} intervals of ours outside 93 to 97 %")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
