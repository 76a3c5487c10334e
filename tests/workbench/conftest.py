"""A record with friction in it, on disk, and what is made of it."""

import numpy as np
import pytest

SPECIMEN = """[specimen]
name = "made"
initial_length_mm = 200.0
initial_radius_mm = 10.0
braid_angle_deg = 25.4
wall_thickness_mm = 1.5
"""


def friction_rows(friction=12.0, seed=7):
    """time, pressure, displacement, force of a saw-tooth test: k1 p (1 − ε)² − k2, dry friction, 1 N of noise."""
    rng, rows, t = np.random.default_rng(seed), [], 0.0
    for p in (0.2, 0.3, 0.4):
        for v in (3.0, 30.0):
            for start, end in ((0.0, 24.0), (24.0, 0.0)) * 2:
                span, sign = 24.0 / v, np.sign(end - start)
                rows += [(t + span * k / 40, p, start + (end - start) * k / 40, sign) for k in range(40)]
                t += span
                rows += [(t + 0.2 * k, p, end, sign) for k in range(10)]
                t += 2.0
        t += 10.0
    time, p, x, sign = np.array(rows).T
    e = x / 200.0
    force = 40.0 + 2600.0 * p - (900.0 + 5500.0 * p) * e + (20.0 + 690.0 * p) * np.exp(-45.0 * e)
    return np.column_stack([time, p, x, force - friction * sign + rng.normal(0.0, 1.0, len(e))])


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """record.csv with 12 N of dry friction, specimen.toml beside it."""
    path = tmp_path_factory.mktemp("bench")
    lines = [",".join(f"{value:.5f}" for value in row) for row in friction_rows()]
    text = "\n".join(["time_s,pressure_MPa,displacement_mm,force_N", *lines]) + "\n"
    (path / "record.csv").write_text(text)
    (path / "specimen.toml").write_text(SPECIMEN)
    return path


@pytest.fixture(scope="session")
def begun(folder):
    """The record on the bench with the exponential law, diagnosed."""
    from pam_ident.workbench.bench import Bench
    from pam_ident.workflow.setup import Setup

    setup = Setup("exponential_law")
    path = folder / "record.csv"
    return Bench.begin(setup.read(path), str(path), setup).diagnosed()
