"""Write reconstructed.csv: the paper's printed laws (4) and (5) evaluated on a grid. Not a measurement.

python datasets/paper_laws/make.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

PRESSURES_MPA = (0.1, 0.2, 0.3, 0.4, 0.5)
POINTS = 51
MU = 45.0


def law_4(p: float, e: float) -> float:
    """Contraction: force in N for p in MPa and contraction ratio e."""
    return 2442 * p - 197.8 - (5464 * p + 1735) * e + (688.3 * p - 9.3) * np.exp(-MU * e)


def law_5(p: float, e: float) -> float:
    """Extension: force in N for p in MPa and contraction ratio e."""
    return 2554 * p - 344.5 - (8430 * p - 43.2) * e + (899.2 * p + 43.24) * np.exp(-MU * e)


def stroke(p: float) -> float:
    """Contraction, to 0.0001, up to which both laws pull at a pressure in MPa: a muscle cannot push."""
    e = np.arange(0.0, 0.25, 1e-4)
    pulls = np.array([min(law_4(p, x), law_5(p, x)) > 0.0 for x in e])
    return float(e[int(np.argmin(pulls)) - 1])


def main(folder: Path) -> None:
    """Write FOLDER/reconstructed.csv, forces with all digits of a double."""
    lines = ["pressure_MPa,contraction,force_N,branch"]
    for branch, law in (("contraction", law_4), ("extension", law_5)):
        for p in PRESSURES_MPA:
            steps = np.round(np.linspace(0.0, stroke(p), POINTS), 6).tolist()
            lines += [f"{p},{e},{float(law(p, e))!r},{branch}" for e in steps]
    (folder / "reconstructed.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
