"""The ladder from the ideal law on every measured muscle at hand, beside laws that only describe.

    python benchmarks/ladders_on_real_data.py [--markdown FILE]

Radius and braid angle are fitted, and counted. The static map is bundled. The other measurements are read from the
folder PAM_IDENT_REALDATA (default ../shared/realdata beside the checkout) and passed over where it is absent.
`--markdown` puts the tables into FILE, between its lines <!-- tables --> and <!-- /tables --> where it has them.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from real_records import REALDATA, heldout_text, plateaus, put_tables, records, slices

from pam_ident.diagnosis import climb, heldout_rmse
from pam_ident.diagnosis.nouns import Ladder
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import Record

__all__ = ["BESIDE", "ladder_of", "plateaus", "slices", "table_of"]
FIRST = "chou_hannaford"
BESIDE = ("polynomial", "hildebrandt", "martens_boblan")
"""Laws without named effects whose held-out errors stand beside the ladder's."""


def ladder_of(record: Record) -> Ladder:
    """From the ideal law up, its geometry free."""
    return climb(Model.build(FIRST, free_geometry=True), record)


def table_of(record: Record) -> list[str]:
    """A Markdown table with a line a rung, then the laws beside it, then what is left."""
    ladder = ladder_of(record)
    kind = "every fifth cycle" if record.inputs.time is not None else f"one {record.block_kind}"
    lines = [
        f"**{record.name}**: {len(record)} samples, {record.force.min():.0f} to {record.force.max():.0f} N; "
        f"held out: {kind}",
        "",
        "| model | parameters | rmse, N | held out, N |",
        "|---|---:|---:|---:|",
    ]
    for rung in ladder.rungs:
        name = f"`{rung.effects[-1]}`" if rung.effects else f"`{FIRST}`"
        count = len(rung.fit.model.params)
        lines.append(
            f"| {'+ ' * bool(rung.effects)}{name} | {count} | {rung.fit.rmse:.2f} | {heldout_text(rung.heldout_rmse)} |"
        )
    for law in BESIDE:
        model = Model.build(law)
        found = fit(model, record)
        heldout = heldout_text(heldout_rmse(model, record, found))
        lines.append(f"| beside: `{law}` | {len(model.params)} | {found.rmse:.2f} | {heldout} |")
    return [*lines, "", left(ladder), ""]


def left(ladder: Ladder) -> str:
    """Verdict of the last rung, the noise floor, and what stands above it."""
    last = ladder.last
    words = {"adequate": "nothing that the record could show", "missing_effect": ", ".join(last.labels)}
    rest = last.pattern.text if last.pattern else words[last.verdict]
    return f"Verdict `{ladder.verdict}`, noise floor {ladder.noise_floor:.2f} N. What is left: {rest}."


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markdown", type=Path, metavar="FILE")
    target = parser.parse_args().markdown
    tables = []
    for record in records(REALDATA):
        tables.append("\n".join(table_of(record)))
        print(tables[-1], flush=True)
    if target is not None:
        put_tables("\n".join(tables), target)


if __name__ == "__main__":
    main()
