"""The 27 problems of nonlinear regression of NIST's Statistical Reference Datasets, as separable least squares.

Data, starts and certified values are read from NIST's own .dat files (https://www.itl.nist.gov/div898/strd/nls/);
the models are written out here. A parameter's `scale` is the magnitude of its start, its bounds are open.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pam_ident.core import Param
from pam_ident.fitting.problem import Problem

Array = np.ndarray


@dataclass(frozen=True)
class Model:
    """y = columns(x, b) · linear: names of the linear parameters, and columns at the curved ones in b (b[1] is b1)."""

    linear: tuple[int, ...]
    columns: Callable[[Array, Mapping[int, float]], list[Array]]


def _exponentials(x: Array, *rates: float) -> list[Array]:
    return [np.exp(-rate * x) for rate in rates]


def _waves(x: Array, period: float) -> list[Array]:
    return [np.cos(2 * np.pi * x / period), np.sin(2 * np.pi * x / period)]


def _gauss(x: Array, b: Mapping[int, float]) -> list[Array]:
    return [np.exp(-b[2] * x), np.exp(-(((x - b[4]) / b[5]) ** 2)), np.exp(-(((x - b[7]) / b[8]) ** 2))]


def _rational(x: Array, above: int, *below: float) -> list[Array]:
    bottom = 1 + sum(c * x ** (k + 1) for k, c in enumerate(below))
    return [x**k / bottom for k in range(above + 1)]


_CHWIRUT = Model((), lambda x, b: [np.exp(-b[1] * x) / (b[2] + b[3] * x)])
_GAUSS = Model((1, 3, 6), _gauss)
_LANCZOS = Model((1, 3, 5), lambda x, b: _exponentials(x, b[2], b[4], b[6]))
_CUBIC = Model((1, 2, 3, 4), lambda x, b: _rational(x, 3, b[5], b[6], b[7]))
_RISE = Model((1,), lambda x, b: [-np.expm1(-b[2] * x)])
MODELS = {
    "Bennett5": Model((1,), lambda x, b: [(b[2] + x) ** (-1 / b[3])]),
    "BoxBOD": _RISE,
    "Chwirut1": _CHWIRUT,
    "Chwirut2": _CHWIRUT,
    "DanWood": Model((1,), lambda x, b: [x ** b[2]]),
    "ENSO": Model((1, 2, 3, 5, 6, 8, 9), lambda x, b: [x**0, *_waves(x, 12.0), *_waves(x, b[4]), *_waves(x, b[7])]),
    "Eckerle4": Model((1,), lambda x, b: [np.exp(-0.5 * ((x - b[3]) / b[2]) ** 2) / b[2]]),
    "Gauss1": _GAUSS,
    "Gauss2": _GAUSS,
    "Gauss3": _GAUSS,
    "Hahn1": _CUBIC,
    "Kirby2": Model((1, 2, 3), lambda x, b: _rational(x, 2, b[4], b[5])),
    "Lanczos1": _LANCZOS,
    "Lanczos2": _LANCZOS,
    "Lanczos3": _LANCZOS,
    "MGH09": Model((1,), lambda x, b: [(x**2 + x * b[2]) / (x**2 + x * b[3] + b[4])]),
    "MGH10": Model((1,), lambda x, b: [np.exp(b[2] / (x + b[3]))]),
    "MGH17": Model((1, 2, 3), lambda x, b: [x**0, *_exponentials(x, b[4], b[5])]),
    "Misra1a": _RISE,
    "Misra1b": Model((1,), lambda x, b: [1 - (1 + b[2] * x / 2) ** -2]),
    "Misra1c": Model((1,), lambda x, b: [1 - (1 + 2 * b[2] * x) ** -0.5]),
    "Misra1d": Model((1,), lambda x, b: [b[2] * x / (1 + b[2] * x)]),
    "Nelson": Model((1, 2), lambda x, b: [x[:, 0] ** 0, -x[:, 0] * np.exp(-b[3] * x[:, 1])]),
    "Rat42": Model((1,), lambda x, b: [1 / (1 + np.exp(b[2] - b[3] * x))]),
    "Rat43": Model((1,), lambda x, b: [(1 + np.exp(b[2] - b[3] * x)) ** (-1 / b[4])]),
    "Roszman1": Model((1, 2), lambda x, b: [x**0, -x, -np.arctan(b[3] / (x - b[4])) / np.pi]),
    "Thurber": _CUBIC,
}
"""A column beyond the linear parameters is the fixed part."""


@dataclass(frozen=True)
class Certified:
    """One problem: data, two starts, certified values and their standard deviations by name, residual variance."""

    name: str
    x: Array
    y: Array
    starts: tuple[dict[str, float], dict[str, float]]
    values: dict[str, float]
    stderr: dict[str, float]
    sigma: float

    def problem(self, start: int) -> Problem:
        """The separable problem from start 1 or 2, with no other start named."""
        model, begin = MODELS[self.name], self.starts[start - 1]
        params = {k: Param(f"b{k}", "1", "", scale=abs(begin[f"b{k}"])) for k in range(1, len(begin) + 1)}
        linear = tuple(params[k] for k in model.linear)
        curved = tuple(p for k, p in params.items() if k not in model.linear)

        def design(values: Mapping[str, float]) -> tuple[Array, Array]:
            with np.errstate(all="ignore"):
                columns = model.columns(self.x, {int(name[1:]): value for name, value in values.items()})
            fixed = columns[len(linear)] if len(columns) > len(linear) else np.zeros(len(self.y))
            return np.reshape(columns[: len(linear)], (len(linear), len(self.y))).T, fixed

        return Problem(linear, curved, design, self.y, begin)


def read_certified(path: Path) -> Certified:
    """One of NIST's .dat files; of Nelson the logarithm of y, as certified."""
    text = path.read_text(encoding="ascii")
    found = re.findall(r"^ +b(\d+) += +(\S+) +(\S+) +(\S+) +(\S+) *$", text, re.M)
    starts = tuple({f"b{row[0]}": float(row[k]) for row in found} for k in (1, 2))
    rows = text.splitlines()
    first, last = (int(n) for n in re.findall(r"Data +\(lines +(\d+) to +(\d+)\)", text)[0])
    data = np.array([[float(word) for word in line.split()] for line in rows[first - 1 : last]])
    sigma = re.search(r"Residual Standard Deviation: +(\S+)", text)
    assert sigma and len(starts) == 2, path
    name = path.stem
    return Certified(
        name,
        data[:, 1] if data.shape[1] == 2 else data[:, 1:],
        np.log(data[:, 0]) if name == "Nelson" else data[:, 0],
        starts,
        {f"b{row[0]}": float(row[3]) for row in found},
        {f"b{row[0]}": float(row[4]) for row in found},
        float(sigma[1]),
    )


def digits(found: Mapping[str, float], certified: Mapping[str, float]) -> float:
    """−log10 of the largest relative error over the parameters, 0 where it is no number, 11 at most (as certified)."""
    errors = [abs(found[name] - value) / abs(value) for name, value in certified.items()]
    worst = max(errors)
    return float(np.clip(-np.log10(max(worst, 1e-11)), 0.0, 11.0)) if np.isfinite(worst) else 0.0
