"""A made-up record on disk, and the program to ask about it."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

SPECIMEN = """[specimen]
name = "made"
initial_length_mm = 200.0
initial_radius_mm = 10.0
braid_angle_deg = 25.4
wall_thickness_mm = 1.5
"""
TRUTH = {"a0": -190.0, "a1": 2400.0, "b0": 900.0, "b1": 5500.0, "c0": 20.0, "c1": 690.0, "mu": 45.0}


def made_rows(friction=0.0, noise=1.0, pressures=(0.3, 0.2, 0.4), speeds=(3.0, 30.0), cycles=2, seed=5):
    """Columns time, pressure, displacement, force of a saw-tooth test with holds, the exponential law and friction."""
    rng = np.random.default_rng(seed)
    rows, t = [], 0.0
    for p in pressures:
        for v in speeds:
            for _ in range(cycles):
                for start, end in ((0.0, 24.0), (24.0, 0.0)):
                    span = abs(end - start) / v
                    sign = np.sign(end - start)
                    rows += [(t + span * k / 40, p, start + (end - start) * k / 40, sign) for k in range(40)]
                    t += span
                    rows += [(t + 0.2 * k, p, end, sign) for k in range(10)]
                    t += 2.0
        t += 10.0
    time, p, x, sign = np.array(rows).T
    e, q = x / 200.0, TRUTH
    force = q["a0"] + q["a1"] * p - (q["b0"] + q["b1"] * p) * e + (q["c0"] + q["c1"] * p) * np.exp(-q["mu"] * e)
    force = force - friction * sign + rng.normal(0.0, noise, len(e)) if noise else force - friction * sign
    return np.column_stack([time, p, x, force])


@pytest.fixture(scope="session")
def write_record(tmp_path_factory):
    """Write made-up rows (options of made_rows) or a text as a record with its specimen; the path."""

    def write(text=None, specimen=SPECIMEN, **options) -> Path:
        folder = tmp_path_factory.mktemp("record")
        path = folder / "record.csv"
        if text is None:
            text = "time_s,pressure_MPa,displacement_mm,force_N\n" + "".join(
                ",".join(f"{value:.6f}" for value in row) + "\n" for row in made_rows(**options)
            )
        path.write_text(text, encoding="utf-8")
        if specimen is not None:
            (folder / "specimen.toml").write_text(specimen, encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="session")
def truth() -> dict[str, float]:
    """Parameters of the made-up record."""
    return TRUTH


@pytest.fixture(scope="session")
def clean(write_record) -> Path:
    """The law alone with 1 N of noise."""
    return write_record()


@pytest.fixture(scope="session")
def rubbing(write_record) -> Path:
    """The same with 12 N of Coulomb friction, kept in holds."""
    return write_record(friction=12.0)


@pytest.fixture(scope="session")
def ask():
    """Run the program inside this process: exit code, stdout, stderr."""
    from pam_ident.cli import app

    def run(*words):
        result = CliRunner().invoke(app, [str(word) for word in words])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return run


@pytest.fixture
def answer(ask, tmp_path):
    """Run a command with --json: the result and what was written."""

    def run(*words):
        path = tmp_path / "answer.json"
        result = ask(*words, "--json", path)

        def refuse(word):
            raise AssertionError(f"{word} in JSON")

        return result, json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)

    return run
