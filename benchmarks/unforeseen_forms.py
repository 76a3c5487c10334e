"""Are effects named by what the force follows, or by forms that somebody foresaw?

Records of the virtual rig with nothing hidden get the force of an effect in a form that no file of `pam_ident/effects`
has: its driver times a dependence on pressure and contraction made up here. `--written` leaves the free forms out of
the catalogue, as a comparison.

    python benchmarks/unforeseen_forms.py --n 40 --seed 11 [--written]
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from tempfile import TemporaryDirectory

import numpy as np

from pam_ident import Model, diagnose, effects, fit
from pam_ident.records import read_record
from pam_ident.rig import Plan, make_record, write_case

SURE = 0.9


def sliding(i):
    return i.direction * i.moving


def warming(i):
    return i.temperature - i.temperature[0]


def softening(i, cycles):
    return np.exp(-(i.cycle - 1.0) / cycles)


FORMS: dict[str, tuple[Callable, ...]] = {
    "thermal_softening": (
        lambda i: -warming(i) * (0.3 + 4.0 * i.contraction),
        lambda i: -warming(i) * (i.pressure + 0.1) * (1.0 - 3.0 * i.contraction),
        lambda i: -warming(i) * (0.2 + 20.0 * i.contraction**2),
    ),
    "coulomb_friction": (
        lambda i: -sliding(i) * (1.0 + 8.0 * i.contraction),
        lambda i: -sliding(i) * np.exp(-i.contraction / 0.06),
        lambda i: -sliding(i) * (1.0 + 100.0 * (i.contraction - 0.08) ** 2),
    ),
    "pressure_friction": (
        lambda i: -sliding(i) * i.pressure * (1.0 + 10.0 * i.contraction),
        lambda i: -sliding(i) * i.pressure * np.exp(-i.contraction / 0.08),
    ),
    "mullins_softening": (
        lambda i: softening(i, 1.3) * (i.pressure * i.contraction + 0.01),
        lambda i: softening(i, 0.9) * (0.1 + 40.0 * i.contraction**2),
    ),
    "viscous_damping": (
        lambda i: -np.sign(i.velocity) * np.abs(i.velocity) ** 0.8 * (1.0 + 8.0 * i.contraction),
        lambda i: -i.velocity * np.exp(-i.contraction / 0.08),
    ),
}


def only_written() -> None:
    """Take the free forms out of the catalogue."""
    for name, effect in effects.catalogue().items():
        forms = tuple(form for form in effect.forms if form.name != "free")
        effects._packaged()[name] = replace(effect, forms=forms)


def case(k: int, rng: np.random.Generator):
    """A record with one effect in a form that nobody wrote, 0.7 to 6 times the noise after the law is refitted."""
    name = list(FORMS)[k % len(FORMS)]
    form = FORMS[name][k // len(FORMS) % len(FORMS[name])]
    law = ("exponential_law", "modified_chou_hannaford")[int(rng.integers(2))]
    size = float(np.exp(rng.uniform(np.log(0.7), np.log(6.0))))
    plan = Plan(int(rng.integers(1, 10**6)), law, (), None, warming=name == "thermal_softening")
    with TemporaryDirectory() as folder:
        write_case(folder, make_record(plan))
        record = read_record(f"{folder}/record.csv")
    model = Model.build(law)
    alone = fit(model, record)
    hidden = form(record.inputs)
    seen = fit(model, replace(record, force=hidden + model.force(record.inputs, alone.values))).rmse
    return name, model, replace(record, force=record.force + hidden * size * alone.rmse / seen), size


def main(n: int, seed: int) -> None:
    """Diagnose n records and print what was named, and how often rightly."""
    rng = np.random.default_rng(seed)
    right = exact = sure = false = 0
    spent = []
    for k in range(n):
        name, model, record, size = case(k, rng)
        start = time.perf_counter()
        found = diagnose(model, record)
        spent.append(time.perf_counter() - start)
        same = set().union(*(group for group in map(set, found.groups) if name in group), {name})
        named = set(found.selected)
        right += bool(named & same)
        exact += bool(named & same) and len(named) == 1 and found.verdict == "missing_effect"
        stated = [one.effect for one in found.ranking if one.probability >= SURE]
        sure += len(stated)
        false += sum(one not in same for one in stated)
        print(
            f"{k:3d} {name} {model.law.name} {size:.1f} × noise: {found.verdict} {' + '.join(found.labels)}", flush=True
        )
    print(f"right {right} of {n}, exact {exact}; {false} of {sure} statements of {SURE} or more false")
    print(f"median {np.median(spent):.2f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=40)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--written", action="store_true")
    asked = parser.parse_args()
    if asked.written:
        only_written()
    main(asked.n, asked.seed)
