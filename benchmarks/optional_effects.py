"""How well effects are found that are tried only where they are asked for, on records of the rig, and what that costs.

    python benchmarks/optional_effects.py

The rig moves a mass and meets a soft stop by formulas of its own.
"""

import tempfile
import time
from pathlib import Path

import numpy as np

from pam_ident.diagnosis import diagnose
from pam_ident.effects import catalogue
from pam_ident.model import Model
from pam_ident.records import Record, read_record
from pam_ident.rig import Plan, Secret, make_record, write_case
from pam_ident.rig.record import RigRecord

LAWS = ("exponential_law", "modified_chou_hannaford")
SEEDS = (15, 16, 17)
KNOWN = ("presliding_hysteresis", "bladder_elasticity", "mullins_softening", "creep", "pressure_lag")
ALL = tuple(sorted(e.name for e in catalogue().values() if not e.candidate and not e.warning))


def made(plan: Plan) -> tuple[RigRecord, Record]:
    """A record as the rig made it, and as it is read."""
    with tempfile.TemporaryDirectory() as folder:
        found = make_record(plan)
        write_case(folder, found)
        return found, read_record(Path(folder) / "record.csv")


def mass_of(one: RigRecord) -> float:
    """The mass in kg that makes the hidden force of the run's acceleration, at each of its instants."""
    run = one.course
    rate = np.gradient(run.rate, run.time + 1e-9 * np.arange(len(run.time))) * 1e-3 * run.length_mm
    rate = np.where(run.moving != 0, rate, 0.0)
    return -float(rate @ one.hidden[0].force / (rate @ rate))


def told(law: str, seed: int, form: tuple[str, str], name: str, value: str, protocol: str) -> str:
    """A line on one record: its answer without and with the effect, the value found and the true one."""
    one, record = made(Plan(seed, law, unknown=Secret(*form, 3.0), sigma_N=1.0, protocol=protocol))
    true = mass_of(one) if name == "moving_mass" else one.hidden[0].size / 0.01 / one.course.length_mm
    plain = diagnose(Model.build(law), record, detail=False)
    asked = diagnose(Model.build(law), record, also=(name,), detail=False)
    found = asked.best.values.get(f"{name}.{value}", float("nan"))
    hint = "told" if f"--also {name}" in plain.sentence else "not told"
    named = ", ".join(asked.labels) or "nothing"
    return (
        f"| {name} | {law} | {seed} | {plain.verdict}, {hint} | {named}, {asked.verdict} | {true:.4g} | {found:.4g} |"
    )


def main() -> None:
    """Print the table, then whether asking for all changes the answers to other records."""
    print(
        "| effect | law | seed | by itself | asked for | true, kg or N/mm | found |\n|---|---|---:|---|---|---:|---:|"
    )
    for law in LAWS:
        for seed in SEEDS:
            print(told(law, seed, ("dynamics", "moving_mass"), "moving_mass", "m", "sines"), flush=True)
    for law in LAWS:
        for seed in SEEDS:
            print(told(law, seed, ("rub", "end_stop"), "end_contact", "K", "standard"), flush=True)
    same, seconds, answers = 0, np.zeros(2), 0
    for seed, secrets in enumerate([(), (), (), *((Secret(name, "textbook", 2.0),) for name in KNOWN)], 51):
        for law in LAWS:
            try:
                _, record = made(Plan(seed, law, secrets))
            except ValueError:  # the law takes the effect up
                continue
            begin = time.perf_counter()
            plain = diagnose(Model.build(law), record, detail=False)
            middle = time.perf_counter()
            asked = diagnose(Model.build(law), record, also=ALL, detail=False)
            seconds += middle - begin, time.perf_counter() - middle
            same, answers = same + (plain.labels == asked.labels), answers + 1
    print(f"\nAll of {', '.join(ALL)} asked for: the same names in {same} of {answers} other records;")
    print(f"{seconds[0]:.1f} s → {seconds[1]:.1f} s.")


if __name__ == "__main__":
    main()
