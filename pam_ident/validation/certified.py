"""Certified problems of nonlinear regression: figures to hold a solver against.

NIST Statistical Reference Datasets, nonlinear regression, https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml,
computed there in 128-bit arithmetic. Each problem names where its data were published first.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..core import Array, Param
from ..fitting import Problem

Values = Mapping[int, float]
Columns = Callable[[Array, Values], list[Array]]
"""x and the nonlinear parameters by number → a column per linear parameter, and one more for a fixed part."""


@dataclass(frozen=True, eq=False)
class Certified:
    """A problem with parameters b1 to bk in order: two starts, certified values and their standard deviations.

    `linear` numbers the parameters that multiply `columns`; x has m rows, y shape (m,). `sigma` is the residual
    standard deviation, where it is wanted.
    """

    name: str
    source: str
    formula: str
    linear: tuple[int, ...]
    columns: Columns
    x: Array
    y: Array
    starts: tuple[tuple[float, ...], tuple[float, ...]]
    values: tuple[float, ...]
    stderr: tuple[float, ...]
    sigma: float = float("nan")

    def problem(self, start: int) -> Problem:
        """The separable problem from start 1 or 2 and no other; bounds are open, scales those of the start."""
        begin = {f"b{k}": value for k, value in enumerate(self.starts[start - 1], 1)}
        params = {k: Param(f"b{k}", "1", "", scale=abs(begin[f"b{k}"])) for k in range(1, len(begin) + 1)}
        linear = tuple(params[k] for k in self.linear)
        curved = tuple(p for k, p in params.items() if k not in self.linear)

        def design(values: Mapping[str, float]) -> tuple[Array, Array]:
            with np.errstate(all="ignore"):
                columns = self.columns(self.x, {int(name[1:]): value for name, value in values.items()})
            fixed = columns[len(linear)] if len(columns) > len(linear) else np.zeros(len(self.y))
            return np.reshape(columns[: len(linear)], (len(linear), len(self.y))).T, fixed

        return Problem(linear, curved, design, self.y, begin)

    def digits(self, values: Mapping[str, float]) -> float:
        """Digits of parameter values b1 to bk that agree with the certified ones."""
        return agreement([values[f"b{k}"] for k in range(1, len(self.values) + 1)], self.values)

    def digits_stderr(self, errors: Mapping[str, float]) -> float:
        """Digits of standard errors of b1 to bk that agree with the certified ones."""
        return agreement([errors[f"b{k}"] for k in range(1, len(self.values) + 1)], self.stderr)


def agreement(found: Array | list[float], certified: tuple[float, ...]) -> float:
    """−log10 of the largest relative error of values (k,); 0 where that is no number, at most the 11 certified."""
    worst = float(np.max(np.abs(np.array(found) / np.array(certified) - 1.0)))
    return float(np.clip(-np.log10(max(worst, 1e-11)), 0.0, 11.0)) if np.isfinite(worst) else 0.0


def _rise(x: Array, b: Values) -> list[Array]:
    return [-np.expm1(-b[2] * x)]


PROBLEMS = (
    Certified(
        "DanWood",
        "Daniel & Wood 1980, Fitting Equations to Data, 2nd ed., Wiley, 428–431",
        "b1 x^b2",
        (1,),
        lambda x, b: [x ** b[2]],
        np.array((1.309, 1.471, 1.49, 1.565, 1.611, 1.68)),
        np.array((2.138, 3.421, 3.597, 4.34, 4.882, 5.66)),
        ((1.0, 5.0), (0.7, 4.0)),
        (0.76886226176, 3.8604055871),
        (0.01828197386, 0.051726610913),
    ),
    Certified(
        "BoxBOD",
        "Box, Hunter & Hunter 1978, Statistics for Experimenters, Wiley, 483–487",
        "b1 (1 − exp(−b2 x))",
        (1,),
        _rise,
        np.array((1.0, 2.0, 3.0, 5.0, 7.0, 10.0)),
        np.array((109.0, 149.0, 149.0, 191.0, 213.0, 224.0)),
        ((1.0, 1.0), (100.0, 0.75)),
        (213.80940889, 0.54723748542),
        (12.354515176, 0.10455993237),
    ),
    Certified(
        "Rat42",
        "Ratkowsky 1983, Nonlinear Regression Modeling, Marcel Dekker, 61 and 88",
        "b1 / (1 + exp(b2 − b3 x))",
        (1,),
        lambda x, b: [1.0 / (1.0 + np.exp(b[2] - b[3] * x))],
        np.array((9.0, 14.0, 21.0, 28.0, 42.0, 57.0, 63.0, 70.0, 79.0)),
        np.array((8.93, 10.8, 18.59, 22.33, 39.35, 56.11, 61.73, 64.62, 67.08)),
        ((100.0, 1.0, 0.1), (75.0, 2.5, 0.07)),
        (72.462237576, 2.6180768402, 0.067359200066),
        (1.7340283401, 0.088295217536, 0.0034465663377),
    ),
    Certified(
        "MGH09",
        "Kowalik & Osborne 1978, Methods for Unconstrained Optimization Problems, Elsevier",
        "b1 (x² + b2 x) / (x² + b3 x + b4)",
        (1,),
        lambda x, b: [(x**2 + x * b[2]) / (x**2 + x * b[3] + b[4])],
        np.array((4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625)),
        np.array((0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246)),
        ((25.0, 39.0, 41.5, 39.0), (0.25, 0.39, 0.415, 0.39)),
        (0.19280693458, 0.19128232873, 0.12305650693, 0.13606233068),
        (0.011435312227, 0.19633220911, 0.080842031232, 0.090025542308),
    ),
    Certified(
        "Misra1a",
        "Misra 1978, NIST, Dental Research Monomolecular Adsorption Study",
        "b1 (1 − exp(−b2 x))",
        (1,),
        _rise,
        np.array((77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0)),
        np.array((10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.4, 75.47, 81.78)),
        ((500.0, 0.0001), (250.0, 0.0005)),
        (238.94212918, 0.00055015643181),
        (2.7070075241, 7.2668688436e-06),
    ),
    Certified(
        "MGH10",
        "Meyer 1970, in Rosen, Mangasarian & Ritter, Nonlinear Programming, Academic Press, 465–486",
        "b1 exp(b2 / (x + b3))",
        (1,),
        lambda x, b: [np.exp(b[2] / (x + b[3]))],
        np.arange(50.0, 126.0, 5.0),
        np.array(
            (34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147, 4427, 3820, 3307, 2872),
            float,
        ),
        ((2.0, 400000.0, 25000.0), (0.02, 4000.0, 250.0)),
        (0.005609636471, 6181.3463463, 345.22363462),
        (0.00015687892471, 23.309021107, 0.78486103508),
    ),
)
