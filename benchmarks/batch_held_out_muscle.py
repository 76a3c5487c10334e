"""A muscle predicted by others: Festo 20 mm of three rest lengths, each law fitted to two and held against the third.

    python benchmarks/batch_held_out_muscle.py

Each law alone, and the rungs of a ladder from the ideal one, of effects that the PSU tables were found to show. All
parameters shared, or each muscle with a zero of its load cell of its own (which was not removed from these data) or,
for the ladder, a rest length of its own; the third muscle's is the mean. Errors in N over the three ways to leave one
out. How far the muscles are apart at rest length is what no law that knows only pressure and contraction can predict.
Exits with 1 where the model that predicts best errs more than 1.5 times as much on the third muscle as on the two.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from laws_on_real_data import leans_on_the_braid
from real_records import PSU_LENGTHS_CM, REALDATA, slices

from pam_ident.batch.hierarchy import fit_muscles
from pam_ident.effects import get_effect
from pam_ident.laws import catalogue
from pam_ident.model import Model, Term
from pam_ident.records import Record

RATIO = 1.5
LADDER = ("bladder_elasticity", "threshold_pressure")
"""What is added to the ideal law, one after the other."""


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


def asked() -> Iterator[tuple[Model, dict[str, str]]]:
    """Models, each with what is every muscle's own, in words and by name."""
    zero, rest = Term(*get_effect("force_bias")), Term(*get_effect("length_offset"))
    own_zero = {"own zero": "force_bias.F_b"}
    own_rest = {"own rest length": f"length_offset.{rest.form.linear[0].name}"}
    for law in catalogue().values():
        alone = Model(law, free_geometry=leans_on_the_braid(law))
        yield alone, {}
        yield alone.adding(zero), own_zero
    for rungs in range(1, len(LADDER) + 1):
        model = Model.build("chou_hannaford", LADDER[:rungs], free_geometry=True)
        yield model, {}
        yield model.adding(zero), own_zero
        yield model.adding(rest), own_rest


def main() -> int:
    if not REALDATA.is_dir():
        print(f"no measurements at {REALDATA}; set PAM_IDENT_REALDATA")
        return 0
    muscles = [slices(REALDATA, cut) for cut in PSU_LENGTHS_CM]
    rows = []
    for model, own in asked():
        inside, each, outside = leave_one_out(model, muscles, tuple(own.values()))
        shared = [label for label in model.labels if not any(one.startswith(label) for one in own.values())]
        rows.append((outside, " + ".join([model.law.name, *shared]), next(iter(own), "all shared"), inside, each))
    rows.sort()
    lengths = " | ".join(f"{m.specimen.initial_length_mm:g} mm" for m in muscles)
    print(f"at rest length the muscles are {between(muscles):.0f} N rms apart\n")
    print(f"| model | parameters | fitted, N | left out, N | ratio | {lengths} |")
    print("|---|---|---:|---:|---:|---:|---:|---:|")
    for outside, name, kind, inside, each in rows:
        cells = " | ".join(f"{one:.0f}" for one in each)
        print(f"| `{name}` | {kind} | {inside:.1f} | {outside:.1f} | {outside / inside:.2f} | {cells} |")
    best = rows[0][0] / rows[0][3]
    print(f"\nbest: {rows[0][1]}, {rows[0][2]}: {best:.2f} times the error of the fit; target {RATIO}")
    return int(best > RATIO)


if __name__ == "__main__":
    sys.exit(main())
