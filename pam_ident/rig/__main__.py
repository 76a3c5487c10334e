"""python -m pam_ident.rig FOLDER --n 60 --seed 1 [--only tier2]: writes a sealed challenge set."""

from __future__ import annotations

import argparse
import sys

from .challenge import SHARES, make_challenge


def main(arguments: list[str] | None = None) -> int:
    """Entry point; exit code 2 where the request makes no sense."""
    parser = argparse.ArgumentParser(prog="python -m pam_ident.rig", description=__doc__)
    parser.add_argument("folder")
    parser.add_argument("--n", type=int, default=60, help="number of cases (60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=list(SHARES), help="cases of one kind only")
    parser.add_argument("--quiet", action="store_true")
    a = parser.parse_args(arguments)
    try:
        truth = make_challenge(
            a.folder, a.n, a.seed, a.only, None if a.quiet else lambda line: print(line, file=sys.stderr)
        )
    except (ValueError, OSError) as problem:
        print(problem, file=sys.stderr)
        return 2
    print(f"{len(truth)} cases in {a.folder}, answers in truth.json")
    return 0


if __name__ == "__main__":
    sys.exit(main())
