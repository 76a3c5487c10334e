"""Digits that solvers reach on NIST's 27 certified problems of nonlinear regression, from both of NIST's starts.

    python benchmarks/nist_digits.py [--markdown FILE]

Prints a table; `--markdown` writes it between the marks in FILE. The problems come from the folder PAM_IDENT_NIST
(default ../shared/nist). Every solver gets the same residual, and NIST's start; tolerances are those a user
gets without asking. scipy and lmfit make their own derivatives by forward differences.
"""

import argparse
import os
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "nist")]

import lmfit
from scipy.optimize import least_squares
from strd import MODELS, read_certified

from pam_ident.fitting import LevenbergMarquardt, Problem, VariableProjection

MARKS = ("<!-- nist-digits -->", "<!-- /nist-digits -->")


def by_scipy(method: str):
    """scipy's least_squares over all parameters."""

    def values(problem: Problem) -> dict[str, float]:
        names = list(problem.start)
        found = least_squares(
            lambda x: problem.residual(dict(zip(names, x, strict=True))), list(problem.start.values()), method=method
        )
        return dict(zip(names, map(float, found.x), strict=True))

    return values


def by_lmfit(problem: Problem) -> dict[str, float]:
    """lmfit's minimize, method leastsq."""
    parameters = lmfit.Parameters()
    for name, value in problem.start.items():
        parameters.add(name, value=value)
    found = lmfit.minimize(lambda p: problem.residual(p.valuesdict()), parameters, calc_covar=False)
    return dict(found.params.valuesdict())


SOLVERS = {
    "pam-ident": lambda problem: VariableProjection().solve(problem).values,
    "optimistix LM": lambda problem: LevenbergMarquardt().solve(problem).values,
    "scipy lm": by_scipy("lm"),
    "scipy trf": by_scipy("trf"),
    "lmfit leastsq": by_lmfit,
}


def reached(folder: Path) -> dict[str, list[list[float]]]:
    """Digits by problem: from start 1 and from start 2, a figure a solver."""
    table: dict[str, list[list[float]]] = {}
    for name in MODELS:
        one = read_certified(folder / f"{name}.dat")
        table[name] = []
        for start in (1, 2):
            with np.errstate(all="ignore"):
                table[name].append([one.digits(solve(one.problem(start))) for solve in SOLVERS.values()])
    return table


def markdown(table: dict[str, list[list[float]]]) -> str:
    """The table, and how many of the 54 fits reached six and four digits."""
    rows = ["| problem | " + " | ".join(SOLVERS) + " |", "|---|" + "---:|" * len(SOLVERS)]
    for name, (first, second) in table.items():
        cells = [f"{a:.1f} / {b:.1f}" for a, b in zip(first, second, strict=True)]
        rows.append(f"| {name} | " + " | ".join(cells) + " |")
    all_fits = np.array([row for both in table.values() for row in both])
    for least in (6, 4):
        counts = np.sum(all_fits >= least, axis=0)
        rows.append(f"| **fits with {least} digits** | " + " | ".join(f"{n} of {len(all_fits)}" for n in counts) + " |")
    return "\n".join(rows)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--markdown", type=Path)
    target = parser.parse_args().markdown
    folder = Path(os.environ.get("PAM_IDENT_NIST", ROOT.parent / "shared" / "nist"))
    if not (folder / "Misra1a.dat").is_file():
        print(f"no NIST problems at {folder}; set PAM_IDENT_NIST", file=sys.stderr)
        return 2
    text = markdown(reached(folder))
    print(text)
    if target is not None:
        page = target.read_text(encoding="utf-8")
        before, after = page.split(MARKS[0])[0], page.split(MARKS[1])[1]
        target.write_text(f"{before}{MARKS[0]}\n{text}\n{MARKS[1]}{after}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
