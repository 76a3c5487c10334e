"""The figures that the paper prints, as they stand in datasets/paper_laws."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass

from pam_ident.records.datasets import dataset_path

BRANCHES = ("contraction", "extension")


@dataclass(frozen=True)
class PrintedLaw:
    """A law as an equation of the paper prints it: `values` are parameters of exponential_law, in N and N/MPa."""

    equation: str
    branch: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class PrintedRow:
    """A row of Table 1 or 2: `values` are k0 (1), k1 (1) and k2 (N) of modified_chou_hannaford at one pressure."""

    branch: str
    pressure_MPa: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class Printed:
    """All of it; `correlation` is Table 3, branch → a, b, c → correlation coefficient with pressure."""

    laws: tuple[PrintedLaw, ...]
    rows: tuple[PrintedRow, ...]
    correlation: Mapping[str, Mapping[str, float]]

    def law(self, branch: str) -> PrintedLaw:
        """The branch's law where it is printed first: equation (4) or (5)."""
        return next(law for law in self.laws if law.branch == branch)


def read_printed() -> Printed:
    """The figures of the paper. Raises UsageError where the data sets were not installed."""
    laws = tuple(PrintedLaw(line.pop("equation"), line.pop("branch"), _floats(line)) for line in _lines("laws.csv"))
    rows = tuple(
        PrintedRow(line.pop("branch"), float(line.pop("pressure_MPa")), _floats(line))
        for line in _lines("tables_1_2.csv")
    )
    return Printed(laws, rows, {line.pop("branch"): _floats(line) for line in _lines("table_3.csv")})


def _lines(name: str) -> list[dict[str, str]]:
    text = (dataset_path("paper_laws") / name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def _floats(line: Mapping[str, str]) -> dict[str, float]:
    return {key: float(value) for key, value in line.items()}
