"""Write this folder's record and its twin in ../nothing_hidden with the virtual rig.

python datasets/hidden_effect/make.py [DATASETS]
"""

import sys
from pathlib import Path

from pam_ident.rig import demo_plans, make_record, write_case


def main(datasets: Path) -> None:
    """Write DATASETS/hidden_effect and DATASETS/nothing_hidden: record.csv and specimen.toml in each."""
    for name, plan in zip(("hidden_effect", "nothing_hidden"), demo_plans(), strict=True):
        write_case(datasets / name, make_record(plan))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1])
