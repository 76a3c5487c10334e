"""A muscle foretold by others: Festo 20 mm of three rest lengths, each law fitted to two and held against the third.

    python benchmarks/batch_held_out_muscle.py

All parameters shared, or each muscle with a zero of its load cell of its own (which was not removed from these data),
the third muscle's being the mean. Errors in N over the three ways to leave one out. How far the muscles are apart at
rest length is what no law that knows only pressure and contraction can foretell. Exits with 1 where the law that
foretells best errs more than 1.5 times as much on the third muscle as on the two.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from laws_on_real_data import leans_on_the_braid
from real_records import PSU_LENGTHS_CM, REALDATA, slices

from pam_ident.effects import get_effect
from pam_ident.laws import catalogue
from pam_ident.model import Model, Term
from pam_ident.records import Record
from pam_ident.workflow.batch_hierarchy import fit_muscles

RATIO = 1.5


def rms(parts: list[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def leave_one_out(model: Model, muscles: list[Record], own: tuple[str, ...]) -> tuple[float, list[float], float]:
    """Error on the muscles that were fitted, on each that was left out, and on all of these, in N."""
    inside, outside = [], []
    for k, left in enumerate(muscles):
        rest = [m for j, m in enumerate(muscles) if j != k]
        found = fit_muscles(model, rest, own)
        inside += [model.force(m.inputs, {**found.values, **o}) - m.force for m, o in zip(rest, found.own, strict=True)]
        outside.append(found.force(left.inputs) - left.force)
    return rms(inside), [rms([one]) for one in outside], rms(outside)


def between(muscles: list[Record]) -> float:
    """Rms distance in N of the muscles' mean forces at rest length from their common mean, pressure by pressure."""
    apart = []
    for level in muscles[0].levels:
        rows = [(m.level == level) & (m.inputs.contraction < 1e-9) for m in muscles]
        means = np.array([m.force[r].mean() for m, r in zip(muscles, rows, strict=True) if r.any()])
        if len(means) == len(muscles):
            apart.append(means - means.mean())
    return rms(apart)


def main() -> int:
    if not REALDATA.is_dir():
        print(f"no measurements at {REALDATA}; set PAM_IDENT_REALDATA")
        return 0
    muscles = [slices(REALDATA, cut) for cut in PSU_LENGTHS_CM]
    zero = Term(*get_effect("force_bias"))
    rows = []
    for law in catalogue().values():
        alone = Model(law, free_geometry=leans_on_the_braid(law))
        for model, own in ((alone, ()), (alone.adding(zero), ("force_bias.F_b",))):
            inside, each, outside = leave_one_out(model, muscles, own)
            rows.append((outside, law.name, "own zero" if own else "all shared", inside, each))
    rows.sort()
    lengths = " | ".join(f"{m.specimen.initial_length_mm:g} mm" for m in muscles)
    print(f"at rest length the muscles are {between(muscles):.0f} N rms apart\n")
    print(f"| law | parameters | fitted, N | left out, N | ratio | {lengths} |")
    print("|---|---|---:|---:|---:|---:|---:|---:|")
    for outside, name, kind, inside, each in rows:
        cells = " | ".join(f"{one:.0f}" for one in each)
        print(f"| `{name}` | {kind} | {inside:.1f} | {outside:.1f} | {outside / inside:.2f} | {cells} |")
    best = rows[0][0] / rows[0][3]
    print(f"\nbest: {rows[0][1]}, {rows[0][2]}: {best:.2f} times the error of the fit; target {RATIO}")
    return int(best > RATIO)


if __name__ == "__main__":
    sys.exit(main())
