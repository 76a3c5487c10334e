"""Ten good records with one column in a wrong unit, sign or zero: is anything false named?

    python benchmarks/unit_slips.py [--markdown docs/measured.md] [--quick]

Every slip goes through the gate and, where that lets it pass, through the diagnosis. `stopped`: nothing is named and
the exit code is not 0. `none`: it passed, and what is named is named of the good record too. `NAMED`: something is
named that the good record does not show. `--markdown` puts the table into the page; `--quick` asks the gate alone.
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

sys.path.insert(0, str(Path(__file__).parent))
from real_records import put_tables

from pam_ident.core import PamError
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record
from pam_ident.rig import Plan, Secret, make_record, write_case
from pam_ident.tasks.diagnose import diagnose_record
from pam_ident.tasks.gate import may_name
from pam_ident.tasks.setup import Setup

FACTORS = (10.0, 14.5, 100.0, 1000.0, 25.4, 4.448)
PHYSICAL = ("time", "pressure", "displacement", "length", "contraction", "force", "temperature")
ATMOSPHERE = {"MPa": 0.101325, "kPa": 101.325}


@dataclass(frozen=True)
class Good:
    """A record that is right, the law it is asked with, and its file."""

    name: str
    law: str
    path: Path


def good_records(folder: Path) -> list[Good]:
    """Five that are bundled, five of the rig with other muscles, laws and effects."""
    found = [
        Good("dmsp20_300", "exponential_law", dataset_record("dmsp20_300")),
        Good("catalogue", "exponential_law", dataset_record("festo_dmsp20_catalogue")),
        Good("nothing_hidden", "exponential_law", dataset_record("nothing_hidden")),
        Good("hidden_effect", "exponential_law", dataset_record("hidden_effect")),
        Good("leg_muscle", "exponential_law", dataset_record("leg_muscle")),
    ]
    plans = (
        ("exponential_law", "coulomb_friction", 11),
        ("exponential_law", "creep", 12),
        ("modified_chou_hannaford", "viscous_damping", 13),
        ("modified_chou_hannaford", "bladder_elasticity", 14),
        ("modified_chou_hannaford", None, 15),
    )
    for law, effect, seed in plans:
        place = folder / f"rig{seed}"
        write_case(place, make_record(Plan(seed, law, (Secret(effect, "textbook", 3.0),) if effect else ())))
        found.append(Good(f"rig, {effect or 'nothing'}", law, place / "record.csv"))
    return found


def slips(table: pd.DataFrame) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Column, what is done to it, and the table then."""
    for column in table:
        what, _, unit = str(column).partition("_")
        if what not in PHYSICAL or unit in ("set_MPa", "pct"):
            continue
        for factor in FACTORS:
            yield what, f"× {factor:g}", table.assign(**{column: table[column] * factor})
            yield what, f"÷ {factor:g}", table.assign(**{column: table[column] / factor})
        yield what, "sign", table.assign(**{column: -table[column]})
        if what == "pressure":
            yield what, "absolute", table.assign(**{column: table[column] + ATMOSPHERE[unit]})
        if what == "temperature":
            yield what, "kelvin", table.assign(**{column: table[column] + 273.15})


def read_table(path: Path) -> pd.DataFrame:
    """A record's file, its comments left out."""
    return pd.read_csv(path, comment="#")


def answer(path: Path, law: str, quick: bool) -> tuple[str, ...] | str:
    """The names that are given, or `stopped` with why."""
    try:
        setup = Setup(law)
        record = read_record(path)
        if quick:
            may_name(record, setup.model)
            return ()
        return diagnose_record(record, setup).selected
    except PamError as error:
        return f"stopped: {error}"


def outcome(path: Path, good: Good, names: tuple[str, ...], quick: bool) -> str:
    """`stopped`, `none` or `NAMED` with the false names."""
    found = answer(path, good.law, quick)
    if isinstance(found, str):
        return "stopped"
    false = [name for name in found if name not in names]
    return f"NAMED {', '.join(false)}" if false else "none"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--records", type=int, default=10)
    asked = parser.parse_args()
    counts: dict[tuple[str, str], list[str]] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for good in good_records(folder)[: asked.records]:
            names = answer(good.path, good.law, asked.quick)
            print(f"{good.name} ({good.law}): {names}", flush=True)
            assert not isinstance(names, str), "a false stop"
            (folder / "specimen.toml").write_text(good.path.with_name("specimen.toml").read_text())
            for column, what, table in slips(read_table(good.path)):
                table.to_csv(folder / "record.csv", index=False)
                told = outcome(folder / "record.csv", good, names, asked.quick)
                counts.setdefault((column, what), []).append(told)
                if told != "stopped":
                    print(f"  {column} {what}: {told}", flush=True)
    text = "\n".join(lines(counts))
    print(text)
    if asked.markdown:
        put_tables(text, asked.markdown)


def lines(counts: dict[tuple[str, str], list[str]]) -> Iterator[str]:
    """The table as Markdown."""
    yield "| column | slip | records | stopped | passed, nothing false named | named falsely |"
    yield "|---|---|---|---|---|---|"
    for (column, what), told in counts.items():
        false = [one.removeprefix("NAMED ") for one in told if one.startswith("NAMED")]
        passed = told.count("none")
        yield f"| {column} | {what} | {len(told)} | {told.count('stopped')} | {passed} | {'; '.join(false) or 0} |"


if __name__ == "__main__":
    main()
