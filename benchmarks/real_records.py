"""The measured muscles at hand as records; what the benchmarks on real data share.

The static map is bundled. The other measurements are read from the folder PAM_IDENT_REALDATA (default
../shared/realdata beside the checkout).
"""

import math
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from pam_ident.core import Specimen
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
        said_kind="dynamic",  # no load to speak of: a law is held against the force, not against the length
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


def heldout_text(newtons: float) -> str:
    """One decimal; a law that runs away outside the data is told in powers of ten."""
    if math.isnan(newtons):
        return "-"
    return f"{newtons:.1f}" if newtons < 1e3 else f"10^{math.floor(math.log10(newtons))}"


def put_tables(text: str, page: Path, begin: str = OPEN, end: str = CLOSE) -> None:
    """Write `text` into a page, between its lines `begin` and `end` where it has them."""
    old = page.read_text(encoding="utf-8") if page.is_file() else begin + end
    before, after = old.split(begin, 1)[0], old.split(end, 1)[1]
    page.write_text(f"{before}{begin}{text}\n{end}{after}", encoding="utf-8")
