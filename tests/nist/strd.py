"""The 27 problems of nonlinear regression of NIST's Statistical Reference Datasets, as separable least squares.

Data, starts and certified values are read from NIST's own .dat files (https://www.itl.nist.gov/div898/strd/nls/);
the models are written out here.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pam_ident.validation.certified import Certified, Columns

Array = np.ndarray


class Model(NamedTuple):
    """y = columns(x, b) · linear: numbers of the linear parameters, and columns at the curved ones in b."""

    linear: tuple[int, ...]
    columns: Columns


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


def read_certified(path: Path) -> Certified:
    """One of NIST's .dat files; of Nelson the logarithm of y, as certified."""
    text, name = path.read_text(encoding="ascii"), path.stem
    found = np.array(re.findall(r"^ +b\d+ += +(\S+) +(\S+) +(\S+) +(\S+) *$", text, re.M), float)
    first, last = map(int, re.findall(r"Data +\(lines +(\d+) to +(\d+)\)", text)[0])
    data = np.array([line.split() for line in text.splitlines()[first - 1 : last]], float)
    formula = " ".join(re.findall(r"y\]? += +.*\n(?: +\S.*\n)*", text)[-1].split()).replace("y]", "log[y]")
    sigma = float(re.findall(r"Residual Standard Deviation: +(\S+)", text)[0])
    one, two, values, stderr = (tuple(map(float, column)) for column in found.T)
    return Certified(
        name,
        path.name,
        formula,
        *MODELS[name],
        data[:, 1] if data.shape[1] == 2 else data[:, 1:],
        np.log(data[:, 0]) if name == "Nelson" else data[:, 0],
        (one, two),
        values,
        stderr,
        sigma,
    )
