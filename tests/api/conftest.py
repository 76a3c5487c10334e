"""A record that is fitted in a moment, and figures that are shut."""

import numpy as np
import pandas as pd
import pytest

import pam_ident as pam

SPECIMEN = {"name": "made", "initial_length_mm": 200.0, "initial_radius_mm": 10.0, "braid_angle_deg": 25.4}


@pytest.fixture(scope="session")
def frame():
    """A saw-tooth test at four pressures with 9 N of friction and 1 N of noise, as a table."""
    rng = np.random.default_rng(11)
    rows, t = [], 0.0
    for p in (0.2, 0.3, 0.4, 0.5):
        for speed in (5.0, 20.0):
            for cycle in range(3):
                for start, end in ((0.0, 24.0), (24.0, 0.0)):
                    x = np.linspace(start, end, 30)
                    rows += [(t + abs(v - start) / speed, p, v, cycle + 1, np.sign(end - start)) for v in x]
                    t += 24.0 / speed + 1.0
        t += 5.0
    time, p, x, cycle, sign = np.array(rows).T
    e = x / 200.0
    force = -190 + 2400 * p - (900 + 5500 * p) * e + (20 + 690 * p) * np.exp(-45 * e) - 9.0 * sign
    force += rng.normal(0.0, 1.0, len(e))
    columns = {"time_s": time, "pressure_MPa": p, "displacement_mm": x, "force_N": force, "cycle": cycle}
    return pd.DataFrame(columns)


@pytest.fixture(scope="session")
def record(frame):
    return pam.read(frame, specimen=SPECIMEN)


@pytest.fixture(scope="session")
def fitted(record):
    return pam.fit(record, "exponential_law")


@pytest.fixture(scope="session")
def rubbing(record):
    return pam.fit(record, "exponential_law", effects=["coulomb_friction"])


@pytest.fixture(autouse=True)
def _figures_are_shut():
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")
