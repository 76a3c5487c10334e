"""A record of the exponential law with noise of a chosen colour, and the law itself, written out by hand."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.records import build_record

SPECIMEN = Specimen("bench", 200.0, 10.0, 25.4, 1.5)
TRUTH = np.array([-197.8, 2442.0, 1735.0, 5464.0, -9.3, 688.3, 45.0])


def _law(x, p, e):
    return x[0] + x[1] * p - (x[2] + x[3] * p) * e + (x[4] + x[5] * p) * np.exp(-x[6] * e)


def _record(n=1000, sigma=2.0, seed=5, rho=0.0):
    """Five isobars, six strokes each, on a measured (uneven) axis."""
    rng = np.random.default_rng(seed)
    phase = np.tile(np.linspace(0.0, 6.0, n // 5, endpoint=False), 5)
    x = 40.0 * np.abs((phase + 1.0) % 2.0 - 1.0) + rng.normal(0.0, 0.02, n)
    level = np.repeat([0.1, 0.2, 0.3, 0.4, 0.5], n // 5)
    p = level + rng.normal(0.0, 2e-4, n)
    noise = rng.standard_normal(n)
    for i in range(1, n):
        noise[i] = rho * noise[i - 1] + np.sqrt(1.0 - rho**2) * noise[i]
    return build_record(
        "bench", SPECIMEN, p, x / 200.0, _law(TRUTH, p, x / 200.0) + sigma * noise, time=0.1 * np.arange(n), level=level
    )


@pytest.fixture(scope="session")
def record():
    """Makes records: n samples, noise of sigma N, correlated by rho from sample to sample."""
    return _record


@pytest.fixture(scope="session")
def law():
    """Force in N of parameters (7,) at pressures and contractions."""
    return _law


@pytest.fixture(scope="session")
def truth():
    """The parameters behind the records."""
    return TRUTH


@pytest.fixture(scope="session")
def specimen():
    """The muscle behind the records."""
    return SPECIMEN
