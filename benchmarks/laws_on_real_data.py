"""Every force law on every measured muscle at hand: parameters, error, error on held-out data, largest error.

    python benchmarks/laws_on_real_data.py [--markdown FILE]

The static map is bundled. The other measurements are read from the folder PAM_IDENT_REALDATA (default
../shared/realdata beside the checkout) and passed over where it is absent. `--markdown` puts the tables into FILE,
between its lines <!-- tables --> and <!-- /tables --> where it has them.
"""

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from real_records import (
    REALDATA,
    heldout_text,
    plateaus,
    put_tables,
    records,
    sine,
    slices,
    static_map,
)

from pam_ident.core import Specimen
from pam_ident.diagnosis import heldout_rmse
from pam_ident.fitting import Fit, fit
from pam_ident.laws import Law, catalogue
from pam_ident.model import Model
from pam_ident.records import Record

__all__ = ["heldout_between", "judge", "leans_on_the_braid", "plateaus", "records", "sine", "slices", "static_map"]


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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markdown", type=Path, metavar="FILE")
    target = parser.parse_args().markdown
    text = "\n".join(line for record in records(REALDATA) for line in table_of(record))
    print(text)
    if target is not None:
        put_tables(text, target)


if __name__ == "__main__":
    main()
