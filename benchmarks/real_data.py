"""What the program makes of every measured set at hand: kind, law, ladder with nested error, verdict, time, parameters.

    python benchmarks/real_data.py [--only WORD] [--markdown FILE]

The sets are read from the folder PAM_IDENT_REALDATA (default ../shared/realdata beside the checkout). A row a set: the
ladder with the law that the program chooses, and beside it the best law alone on the same held-out rows. `--markdown`
puts the table into FILE, between its lines <!-- real --> and <!-- /real -->.
"""

import argparse
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import numpy as np
from real_records import PSU_LENGTHS_CM, REALDATA, heldout_text, plateaus, slices, static_map

from pam_ident.core import PamError, Specimen
from pam_ident.diagnosis.nested import anew, masks_of
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import Record, build_record, read_record, thinned
from pam_ident.tasks.gate import computing
from pam_ident.tasks.ladder import climb_ladder
from pam_ident.tasks.law_choice import settle
from pam_ident.tasks.setup import AUTO, Setup

OPEN, CLOSE = "<!-- real -->\n", "<!-- /real -->"
ROWS = 4000


def cylinder(folder: Path) -> Record:
    """Four isobars of a cylinder with a seal, each run a file; rows thinned."""
    home = folder / "cylinder_oring"
    return thinned(read_record(str(home / "*.csv"), home / "specimen.toml"), ROWS)


def across_muscles(folder: Path) -> Record:
    """The three muscles of PSU as one, their contraction by their own lengths; a muscle is held out whole."""
    found = [slices(folder, cut) for cut in PSU_LENGTHS_CM]
    one = build_record(
        "PSU, three muscles",
        Specimen("Festo 20 mm", 200.0, 10.0, 25.4),
        *(np.concatenate([getattr(r.inputs, key) for r in found]) for key in ("pressure", "contraction")),
        np.concatenate([r.force for r in found]),
    )
    return replace(one, groups={"muscle": np.repeat(np.arange(len(found)), [len(r) for r in found])})


def dead_weights(folder: Path) -> Iterator[Record]:
    """Runs with a weight that hangs on the muscle."""
    for path in sorted((folder / "mit2151_mckibben300mm" / "deadweight").glob("*.dat")):
        yield replace(read_record(path), name=f"MIT dead weight, {path.stem}")


def sets(folder: Path) -> Iterator[tuple[Record, str]]:
    """Each set, and what is held out of it."""
    yield static_map(), "length"
    if not folder.is_dir():
        print(f"no measurements at {folder}; set PAM_IDENT_REALDATA")
        return
    yield cylinder(folder), "pressure"
    yield plateaus(folder), "length"
    for cut in PSU_LENGTHS_CM:
        yield slices(folder, cut), "length"
    yield across_muscles(folder), "muscle"
    for record in dead_weights(folder):
        yield record, "cycle"


def row(record: Record, by: str) -> str:
    """A line of the table."""
    begun, kind = time.monotonic(), record.kind
    start = f"| {record.name} | {len(record)} | {kind} | {by} |"
    try:
        setup, _ = settle(record, Setup(AUTO, heldout=by))
        found = climb_ladder(record, setup)
    except PamError as error:
        why = re.split("[:;,]", str(error).partition(": ")[2])[0]
        return f"{start} refused ({error.exit_code}): {why} | | | | | {time.monotonic() - begun:.0f} |"
    last = found.rungs[-1]
    assert found.nested is not None and last.refit_rmse is not None
    best, (_, error) = next(iter(found.nested.beside.items()))
    odd = ", ".join(e.name for e in last.fit.impossible) or "possible"
    return (
        f"{start} {' + '.join([last.fit.model.law.name, *last.effects])} | {last.fit.rmse:.2f} "
        f"| {heldout_text(last.refit_rmse)}, {heldout_text(last.heldout_rmse)} | {best} {heldout_text(error)} "
        f"| {found.verdict}; {odd} | {time.monotonic() - begun:.0f} |"
    )


def cylinder_in_numbers(record: Record) -> list[str]:
    """The area, the friction by pressure, and the error at 5 bar by a fit to the others."""
    lines = []
    for label in ("pressure_friction", "coulomb_friction", "pressure_friction:preloaded"):
        model = Model("polynomial", [label])
        with computing(record):
            one = fit(model, record)
            five = next(mask for mask in masks_of(record, "pressure") if abs(record.level[mask][0] - 0.5) < 0.05)
            (error,) = anew(record, [five], lambda part, model=model: [fit(model, part, detail=False)], 1)
        heldout = error * np.sqrt(len(record) / five.sum())
        sizes = ", ".join(f"{e.name} {e.value:.3g} ± {e.stderr:.1g} {e.unit}" for e in one.estimates if "." in e.name)
        area = f"slope over pressure at rest length {one.values['a0']:.0f} mm²"
        lines.append(f"- `{label}`: {sizes}; {area}; {one.rmse:.2f} N rms; 5 bar held out {heldout:.2f} N")
    return [f"Cylinder ({record.name}):", "", *lines]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="WORD")
    parser.add_argument("--markdown", type=Path, metavar="FILE")
    asked = parser.parse_args()
    lines = [
        "| set | rows | kind | held out | ladder | rmse, N | refitted, nested, N | best law alone, N "
        "| verdict; parameters | s |",
        "|---|---:|---|---|---|---:|---:|---|---|---:|",
    ]
    print(*lines, sep="\n", flush=True)
    more: list[str] = []
    for record, by in sets(REALDATA):
        if asked.only in record.name:
            lines.append(row(record, by))
            print(lines[-1], flush=True)
            more = cylinder_in_numbers(record) if by == "pressure" else more
    print("", *more, sep="\n")
    if asked.markdown is not None:
        page = asked.markdown.read_text(encoding="utf-8")
        before, after = page.split(OPEN, 1)[0], page.split(CLOSE, 1)[1]
        text = "\n".join([*lines, "", *more])
        asked.markdown.write_text(f"{before}{OPEN}{text}\n{CLOSE}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
