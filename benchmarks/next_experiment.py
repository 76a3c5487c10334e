"""How often the next experiment splits a confused pair: the chosen run beside a random one and the old rule's.

python benchmarks/next_experiment.py [SEEDS] prints a table. A poor record is made on the virtual
rig and diagnosed; where another effect is grouped with the answer, or named in its place, each run is made on the same
muscle and diagnosed by itself. It is split when the hidden effect is named alone, with nothing in its group.
"""

import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pam_ident.core import FitError
from pam_ident.diagnosis import Diagnosis, diagnose
from pam_ident.diagnosis.confounding import one_speed
from pam_ident.diagnosis.possible_runs import PossibleRun, possible_runs
from pam_ident.diagnosis.strokes import Strokes
from pam_ident.effects import catalogue
from pam_ident.model import Model
from pam_ident.records import Record, read_record
from pam_ident.rig import Plan, Protocol, Secret, make_record, write_case
from pam_ident.rig.protocol_file import read_protocol

BLUNT = Protocol(speeds_mm_s=(10.0,), hold_s=0.0, hold_rows=0)
ONE_ISOBAR = Protocol((0.3,))
ONE_LOOP = Protocol((0.3,), speeds_mm_s=(10.0,), hold_s=0.0, hold_rows=0)
CHOU, EXPONENTIAL = "modified_chou_hannaford", "exponential_law"
SUBJECTS = [
    ("one speed", BLUNT, EXPONENTIAL, "coulomb_friction"),
    ("one speed", BLUNT, EXPONENTIAL, "viscous_damping"),
    ("one pressure", ONE_ISOBAR, CHOU, "coulomb_friction"),
    ("one pressure", ONE_ISOBAR, CHOU, "pressure_friction"),
    ("one pressure", ONE_ISOBAR, CHOU, "bladder_elasticity"),
    ("one pressure and speed", ONE_LOOP, CHOU, "viscous_damping"),
    ("one pressure and speed", ONE_LOOP, CHOU, "pressure_friction"),
    ("one pressure and speed", ONE_LOOP, CHOU, "pressure_lag"),
    ("one pressure and speed", ONE_LOOP, CHOU, "creep"),
    ("one pressure and speed", ONE_LOOP, CHOU, "force_drift"),
    ("one pressure and speed", ONE_LOOP, CHOU, "thermal_softening"),
]


VARIED = {
    "pressure": ("pressures_MPa", "tops_mm"),
    "hold": ("hold_s",),
    "reversal": ("minor_loops_mm",),
    "cycles": ("cycles_per_speed",),
    "temperature": ("warming_K",),
}
WAYS = ("chosen", "random", "rule")


def main(seeds: int) -> None:
    print("| poor record | law | hidden | open | chosen | random | old rule | minutes: chosen, random, old rule |")
    for row, (name, protocol, law, hidden) in enumerate(SUBJECTS):
        selections = [selection(protocol, law, hidden, 900 + k, row) for k in range(seeds)]
        left = [t for t in selections if t]
        counts = " | ".join(str(sum(t[way][0] for t in left)) for way in WAYS)
        minutes = ", ".join(f"{np.median([t[way][1] for t in left]):.0f}" if left else "-" for way in WAYS)
        print(f"| {name} | {law} | {hidden} | {len(left)} of {seeds} | {counts} | {minutes} |", flush=True)


def selection(protocol: Protocol, law: str, hidden: str, seed: int, row: int) -> dict[str, tuple[bool, float]]:
    """Whether each way to choose a run split it, and the minutes of the run; empty where the poor record was clear."""
    secret, warming = Secret(hidden, "textbook", 2.0), hidden == "thermal_softening"
    plan = Plan(seed, law, (secret,), protocol=protocol, warming=warming)
    record, first = answer(plan)
    if not first.selected or (first.selected == (hidden,) and not first.groups):
        return {}
    runs = possible_runs(record, Model.build(law), first.base.values)
    draw = np.random.default_rng([seed, row]).integers(len(runs))
    ways = {
        "chosen": first.next_experiment.protocol if first.next_experiment else None,
        "random": runs[draw].strokes,
        "rule": old_rule(first, runs),
    }
    known: dict[Strokes | None, bool] = {None: False}
    for strokes in ways.values():
        if strokes not in known:
            known[strokes] = splits(strokes, plan, hidden)
    return {way: (known[s], PossibleRun((), s).minutes if s else 0.0) for way, s in ways.items()}


def splits(strokes: Strokes, plan: Plan, hidden: str) -> bool:
    """Whether a run on the same muscle names what is hidden, alone. A run that cannot be fitted does not."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "next.toml"
        file.write_text(strokes.toml("next"))
        try:
            _, again = answer(replace(plan, protocol=read_protocol(file), warming=False))
        except FitError:
            return False
    return again.selected == (hidden,) and not again.groups


def answer(plan: Plan) -> tuple[Record, Diagnosis]:
    with TemporaryDirectory() as folder:
        write_case(folder, make_record(plan))
        record = read_record(Path(folder) / "record.csv")
    return record, diagnose(Model.build(plan.law), record)


def old_rule(first: Diagnosis, runs: list[PossibleRun]) -> Strokes | None:
    """All that the rule of until now asks for, in one run: each lever that the first group does not share and the
    record does not vary; the rest as in the record."""
    if not first.groups:
        return None
    record, effects = first.base.record, catalogue()
    members = [effects[name] for name in first.groups[0]]
    levers = list(dict.fromkeys(lever for m in members for lever in m.levers))
    shared = [lever for lever in levers if all(lever in m.levers for m in members)]
    exclusion_groups = any(a.name == b.special_case_of for a in members for b in members)
    splitting = shared if exclusion_groups else [v for v in levers if v not in shared]
    wanted = [v for v in levers if v in lacking(record)] or splitting or levers
    speeds = tuple(sorted({float(f"{v:.1g}") for v in record.inputs.stroke_speed[record.inputs.moving]}))
    plain = runs[0].strokes
    run = plain if "speed" in wanted else replace(plain, speeds_mm_s=speeds)
    for lever, fields in VARIED.items():
        like = next((c.strokes for c in runs[2:] if lever in c.vary), None)
        if lever in wanted and like is not None:
            run = replace(run, **{field: getattr(like, field) for field in fields})
    return run


def lacking(record: Record) -> set[str]:
    """What a record does not vary, as the old rule had it."""
    inputs = record.inputs
    found = {"speed"} if one_speed(record) else set()
    found |= {"pressure"} if len(record.levels) < 3 else set()
    found |= {"hold"} if np.mean(~inputs.moving) < 0.05 else set()
    found |= {"temperature"} if inputs.temperature is None or np.ptp(inputs.temperature) < 5.0 else set()
    found |= {"cycles"} if len(np.unique(inputs.cycle)) < 3 else set()
    return found


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
