"""Every force law on every measured muscle at hand: parameters, error, error on held-out data, largest error.

    python benchmarks/laws_on_real_data.py [--markdown FILE]

The static map comes along. The other measurements are read from the folder PAM_IDENT_REALDATA (default
../shared/realdata beside the checkout) and passed over where it is absent. `--markdown` puts the tables into FILE,
between its lines <!-- tables --> and <!-- /tables --> where it has them.
"""

import argparse
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from pam_ident.core import Specimen
from pam_ident.diagnosis import heldout_rmse
from pam_ident.fitting import Fit, fit
from pam_ident.laws import Law, catalogue
from pam_ident.model import Model
from pam_ident.records import Record, build_record, read_record
from pam_ident.records.datasets import dataset_record

ROOT = Path(__file__).parents[1]
REALDATA = Path(os.environ.get("PAM_IDENT_REALDATA", ROOT.parent / "shared" / "realdata"))
MIT = Specimen("McKibben 300 mm", 300.0, 5.0, 23.0)
SLACK_N = 20.0
"""What the load cell reads, offset included, is below this where the muscle hangs slack."""
OPEN, CLOSE = "<!-- tables -->\n", "<!-- /tables -->"
MIT_FREQUENCIES = ("01.57", "06.28", "12.56", "25.12")
PSU_LENGTHS_CM = (12, 23, 30)


@dataclass(frozen=True)
class Row:
    """How one law does on one record, errors in N.

    `heldout` is over all blocks, `between` over those whose contractions lie inside what the others cover.
    `settled` is False where the record does not determine all parameters.
    """

    law: str
    parameters: int
    rmse: float
    heldout: float
    between: float
    largest: float
    settled: bool


def static_map() -> Record:
    """Festo DMSP-20-300, slack masked."""
    return read_record(dataset_record("dmsp20_300"))


def plateaus(folder: Path) -> Record:
    """Hand-made McKibben, muscle locked at 11 lengths and inflated in steps; a lock is a length."""
    table = pd.read_csv(folder / "mit2151_mckibben300mm" / "plateaus.csv")
    record = build_record(
        "MIT plateaus",
        MIT,
        table["p_kPa_span12bar"].to_numpy() * 1e-3,
        table["contraction_mm"].to_numpy() / MIT.initial_length_mm,
        table["F_N"].to_numpy(),
        level=table["cmd_pct"].to_numpy() / 100.0,
    )
    return replace(record, block=table["lock"].to_numpy(), block_kind="length")


def sine(folder: Path, frequency: str) -> Record:
    """The same muscle without load, its pressure a sine; contraction from where it stands at rest."""
    name = f"freq_noload_amp50pct/{frequency}rads.csv"
    table = pd.read_csv(folder / "mit2151_mckibben300mm" / name)
    rest = pd.read_csv(folder / "mit2151_mckibben300mm" / "plateaus.csv")["x_mm"].iloc[0]
    pressure = table["p_kPa_span12bar"].to_numpy() * 1e-3
    record = build_record(
        f"MIT sine, {float(frequency):g} rad/s",
        MIT,
        pressure,
        (rest - table["x_mm"].to_numpy()) / MIT.initial_length_mm,
        table["F_N"].to_numpy(),
        time=table["t_s"].to_numpy(),
        level=np.zeros(len(table)),
    )
    return replace(record, level=np.round(pressure, 2))  # one run, but many pressures


def slices(folder: Path, cut_length_cm: int) -> Record:
    """Festo 20 mm locked at 3 or 4 lengths: force at fixed pressures, inflating and deflating together.

    Left out: slack, slices read across a gap of more than 30 kPa, and the first cycle, which conditions the muscle.
    """
    table = pd.read_csv(folder / "psu_festo20mm_isometric" / "isobaric_slices.csv")
    table = table[table["cut_len_cm"] == cut_length_cm]
    keep = (table["F_N"] > SLACK_N) & (table["p_gap_kPa"] <= 30.0) & (table["test"] > 1)
    table = table[keep]
    pressure = table["p_kPa"].to_numpy() * 1e-3
    return build_record(
        f"PSU, cut length {cut_length_cm} cm",
        Specimen(f"Festo 20 mm, {cut_length_cm} cm", float(table["lo_mm"].iloc[0]), 10.0, 25.4),
        pressure,
        1.0 - table["li_mm"].to_numpy() / table["lo_mm"].to_numpy(),
        table["F_N"].to_numpy(float),
        level=pressure,
    )


def records(folder: Path) -> Iterator[Record]:
    """The map, and all that the folder holds."""
    yield static_map()
    if not folder.is_dir():
        print(f"no measurements at {folder}; set PAM_IDENT_REALDATA")
        return
    yield plateaus(folder)
    for frequency in MIT_FREQUENCIES:
        yield sine(folder, frequency)
    for cut_length in PSU_LENGTHS_CM:
        yield slices(folder, cut_length)


def leans_on_the_braid(law: Law) -> bool:
    """Whether the specimen's angle changes the force, so that a fair fit frees it."""
    p, e = np.array([0.5]), np.array([0.1])
    values = {q.name: q.start for q in law.params}
    return len({float(law.force(p, e, Specimen(braid_angle_deg=angle), values)[0]) for angle in (24.0, 26.0)}) == 2


def judge(law: Law, record: Record) -> Row:
    """Fit `law` to the whole record, and to all but each length, isobar or fifth of the cycles."""
    model = Model(law, free_geometry=leans_on_the_braid(law))
    found = fit(model, record)
    settled = all(e.identified for e in found.estimates)
    heldout = heldout_rmse(model, record, found)
    return Row(law.name, len(model.params), found.rmse, heldout, heldout_between(found), found.max_error, settled)


def heldout_between(whole: Fit) -> float:
    """Held-out error over the lengths of a table other than its first and last; NaN for a record in time."""
    record, errors = whole.record, []
    if record.inputs.time is not None:
        return math.nan
    contraction = record.inputs.contraction
    for block in np.unique(record.block):
        mask = record.block == block
        outside = contraction[~mask]
        if outside.min() < contraction[mask].min() and contraction[mask].max() < outside.max():
            part = fit(whole.model, record, ~mask, whole.values, detail=False)
            errors.append(part.residual[mask])
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def table_of(record: Record) -> list[str]:
    """A Markdown table, the law with the smallest error first."""
    rows = sorted((judge(law, record) for law in catalogue().values()), key=lambda row: (round(row.rmse, 2), row.law))
    kind = "every fifth cycle" if record.inputs.time is not None else f"one {record.block_kind}"
    lines = [
        f"**{record.name}**: {len(record)} samples, {record.force.min():.0f} to {record.force.max():.0f} N; "
        f"held out: {kind}",
        "",
        "| law | parameters | rmse, N | held out, N | held out between, N | largest error, N |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        count = f"{row.parameters}{'' if row.settled else '*'}"
        outside, between = heldout_text(row.heldout), heldout_text(row.between)
        lines.append(f"| `{row.law}` | {count} | {row.rmse:.2f} | {outside} | {between} | {row.largest:.1f} |")
    return [*lines, ""]


def heldout_text(newtons: float) -> str:
    """One decimal; a law that runs away outside the data is told in powers of ten."""
    if math.isnan(newtons):
        return "-"
    return f"{newtons:.1f}" if newtons < 1e3 else f"10^{math.floor(math.log10(newtons))}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markdown", type=Path, metavar="FILE")
    target = parser.parse_args().markdown
    text = "\n".join(line for record in records(REALDATA) for line in table_of(record))
    print(text)
    if target is not None:
        page = target.read_text(encoding="utf-8") if target.is_file() else OPEN + CLOSE
        before, after = page.split(OPEN, 1)[0], page.split(CLOSE, 1)[1]
        target.write_text(f"{before}{OPEN}{text}\n{CLOSE}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
