"""How often the next experiment splits a confused pair: the chosen run beside a random one and the old rule's.

python benchmarks/next_experiment.py [SEEDS] prints the table of docs/diagnosis.md. A poor record is made on the virtual
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
from pam_ident.diagnosis.candidates import Candidate, candidates
from pam_ident.diagnosis.confounding import one_speed
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


def main(seeds: int) -> None:
    print("poor record | law | hidden | records | confused | chosen | random | old rule | minutes |", flush=True)
    for name, protocol, law, hidden in SUBJECTS:
        trials = [trial(protocol, law, hidden, 900 + k) for k in range(seeds)]
        open_ = [t for t in trials if t]
        counts = " | ".join(str(sum(t[way] for t in open_)) for way in ("chosen", "random", "rule"))
        minutes = np.median([t["minutes"] for t in open_]) if open_ else 0.0
        print(f"{name} | {law} | {hidden} | {len(trials)} | {len(open_)} | {counts} | {minutes:.0f} |", flush=True)


def trial(protocol: Protocol, law: str, hidden: str, seed: int) -> dict[str, float]:
    """Whether each way to choose a run split the confusion; empty where the poor record was clear."""
    secret, warming = Secret(hidden, "textbook", 2.0), hidden == "thermal_softening"
    plan = Plan(seed, law, (secret,), protocol=protocol, warming=warming)
    record, first = answer(plan)
    if not first.selected or (first.selected == (hidden,) and not first.groups):
        return {}
    runs = candidates(record, Model.build(law), first.base.values)
    experiment = first.next_experiment
    ways = {
        "chosen": experiment.protocol if experiment else None,
        "random": at_own_speed(runs, int(np.random.default_rng(seed).integers(len(runs))), record),
        "rule": at_own_speed(runs, old_rule(first, runs), record),
    }
    known: dict[Strokes | None, bool] = {None: False}
    for strokes in ways.values():
        if strokes not in known:
            known[strokes] = splits(strokes, plan, hidden)
    minutes = experiment.minutes if experiment else None
    return {way: known[strokes] for way, strokes in ways.items()} | {"minutes": minutes or 0.0}


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


def at_own_speed(runs: list[Candidate], k: int, record: Record) -> Strokes:
    """A run at the record's own speeds, unless speed is what it varies: candidates have two speeds in any case."""
    speeds = sorted({float(f"{v:.1g}") for v in record.inputs.stroke_speed[record.inputs.moving]})
    return runs[k].strokes if k < 2 else replace(runs[k].strokes, speeds_mm_s=tuple(speeds))


def answer(plan: Plan) -> tuple[Record, Diagnosis]:
    with TemporaryDirectory() as folder:
        write_case(folder, make_record(plan))
        record = read_record(Path(folder) / "record.csv")
    return record, diagnose(Model.build(plan.law), record)


def old_rule(first: Diagnosis, runs: list[Candidate]) -> int:
    """Number of the run for the first lever that the group does not share and the record does not vary, as in 0.1."""
    members = [catalogue()[name] for name in (first.groups[0] if first.groups else first.selected)]
    levers = list(dict.fromkeys(lever for m in members for lever in m.levers))
    shared = [lever for lever in levers if all(lever in m.levers for m in members)]
    inputs = first.base.record.inputs
    lacking = {"temperature"} if inputs.temperature is None else set()
    lacking |= {"speed"} if one_speed(first.base.record) else set()
    lacking |= {"pressure"} if len(first.base.record.levels) < 3 else set()
    lacking |= {"hold"} if np.mean(~inputs.moving) < 0.05 else set()
    wanted = [v for v in levers if v in lacking] or [v for v in levers if v not in shared] or levers
    if "speed" in wanted[:1]:
        return 0
    return next((k for v in wanted for k, run in enumerate(runs) if k > 1 and v in run.vary), 0)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
