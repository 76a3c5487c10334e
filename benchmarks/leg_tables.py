"""The tables of docs/leg.md and docs/measured.md: every rung at 1 Hz in both legs, other cadences, the budget.

python benchmarks/leg_tables.py [--markdown docs/leg.md docs/measured.md]
"""

import argparse
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from pam_ident.leg.track import Track, Tracking
from pam_ident.tasks.track import TrackOptions, track_leg

TASKS = {
    "0.5": (0.5, False),
    "0.8": (0.8, False),
    "1.0": (1.0, False),
    "1.2": (1.2, False),
    "1.0, the 0.2 s": (1.0, True),
}
LEGS = {"reduced": False, "prototype": True}


def numbers(*values: float) -> str:
    return " | ".join(f"{value:.3f}" for value in values)


def both(one: Tracking, other: Tracking) -> str:
    return numbers(one.rms_deg, one.peak_deg, other.rms_deg, other.peak_deg)


def rungs(reduced: Track, prototype: Track) -> str:
    rows = [
        "| controller, degrees | reduced: rms | peak | prototype: rms | peak | 95 % band of rms |",
        "|---|---:|---:|---:|---:|---:|",
        f"| PID tuned by hand | {both(reduced.pid_by_hand, prototype.pid_by_hand)} | |",
        f"| PID tuned automatically | {both(reduced.pid, prototype.pid)} | |",
    ]
    before: list[str] = []
    for k, (one, other) in enumerate(zip(reduced.rungs, prototype.rungs, strict=True)):
        model = one.muscle.model
        new = ", ".join(f"`{label}`" for label in model.labels if label not in before)
        name = f"PID + `{model.law.name}`" if k == 0 else f"+ {new}"
        band = "" if one.band is None else f"{one.band[0]:.3f} to {one.band[1]:.3f}"
        rows.append(f"| {k}: {name} | {both(one.tracking, other.tracking)} | {band} |")
        before = model.labels
    rows.append(f"| PID + the plant's own model | {both(reduced.ideal, prototype.ideal)} | |")
    hand, best = reduced.by_hand, reduced.automatic
    last = reduced.rungs[-1].tracking.rms_deg, prototype.rungs[-1].tracking.rms_deg
    rows += [
        "",
        f"By hand: {gains(hand.gains)} ({hand.runs} runs; {hand.worst_deg:.2f}° on the worst plant). Automatic: "
        f"{gains(best.gains)} ({best.worst_deg:.2f}°). Both legs differ by {prototype.agreement_deg:.3f}° rms in the",
        f"last step, which is {reduced.pid.rms_deg / last[0]:.0f} times better than the PID alone in the reduced leg, "
        f"{prototype.pid.rms_deg / last[1]:.0f} times in the prototype. Bands are the reduced leg's.",
    ]
    return "\n".join(rows)


def gains(given: tuple[float, ...]) -> str:
    return "Kp {:.3g} MPa/rad, Ki {:.3g} MPa/(rad s), Kd {:.3g} MPa s/rad".format(*given)


def cadences(found: dict[tuple[str, str], Track]) -> str:
    rows = [
        "| strides a second | leg | PID by hand | PID | step 0 | step 2 | last step: rms | peak | own model | troubles "
        "of the last step |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---|",
    ]
    for (task, leg), track in found.items():
        first, third, last = (track.rungs[k].tracking for k in (0, 2, -1))
        runs = (track.pid_by_hand.rms_deg, track.pid.rms_deg, first.rms_deg, third.rms_deg, last.rms_deg, last.peak_deg)
        told = ", ".join(f"{t.kind} {100 * t.share:.0f} %" for t in last.troubles)
        rows.append(f"| {task} | {leg} | {numbers(*runs, track.ideal.rms_deg)} | {told} |")
    return "\n".join(rows)


def budgets(found: dict[tuple[str, str], Track]) -> str:
    reduced = {task: track.budget for (task, leg), track in found.items() if leg == "reduced"}
    rows = [f"| degrees | {' | '.join(f'{task} Hz' if len(task) == 3 else task for task in reduced)} |"]
    rows.append("|---|" + "---:|" * len(reduced))
    lines = {
        "PID tuned by hand": [f"{b.by_hand:.2f}" for b in reduced.values()],
        "PID tuned automatically": [f"{b.automatic:.2f}" for b in reduced.values()],
        "share of the tuning": [f"{b.tuning:+.2f}" for b in reduced.values()],
        "share of the structure: the four-bar against a hinge": [f"{b.structure:+.2f}" for b in reduced.values()],
        "share of the muscle: against the nearest plane": [f"{b.muscle:+.2f}" for b in reduced.values()],
    }
    return "\n".join(rows + [f"| {name} | {' | '.join(cells)} |" for name, cells in lines.items()])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--markdown", type=Path, nargs="*", default=(), help="pages whose tables are written anew")
    given = parser.parse_args()
    found = {}
    for task, (cadence, paper) in TASKS.items():
        for leg, prototype in LEGS.items():
            found[task, leg] = track_leg(TrackOptions(cadence_Hz=cadence, paper=paper, prototype=prototype))
            print(task, leg, f"{found[task, leg].rungs[-1].tracking.rms_deg:.3f}", flush=True)
    tables = {
        "rungs": rungs(found["1.0", "reduced"], found["1.0", "prototype"]),
        "cadence": cadences(found),
        "budget": budgets(found),
    }
    for name, table in tables.items():
        print(f"\n{table}")
        for page in given.markdown:
            text = page.read_text(encoding="utf-8")
            marks = f"<!-- {name} -->", f"<!-- /{name} -->"
            text = re.sub(f"{marks[0]}.*?{marks[1]}", lambda _: f"{marks[0]}\n{table}\n{marks[1]}", text, flags=re.S)  # noqa: B023
            page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
