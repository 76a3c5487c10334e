"""The test that all the awkward files of this folder hold, so that what is read can be compared with numbers."""

import numpy as np

SPECIMEN = """[specimen]
name = "m1"
initial_length_mm = 200.0
initial_radius_mm = 10.0
braid_angle_deg = 25.4
wall_thickness_mm = 1.5
"""
ROWS = 24
TIME = 0.1 * np.arange(ROWS)
PRESSURE = np.repeat([0.3, 0.45], ROWS // 2)
DISPLACEMENT = 2.5 * np.tile(np.arange(ROWS // 2), 2)
FORCE = 1400.25 - 12.5 * np.arange(ROWS)
HEADERS = ("time_s", "pressure_MPa", "displacement_mm", "force_N")


def values():
    """Time in s, pressure in MPa, displacement in mm, force in N, a row a sample."""
    return np.column_stack([TIME, PRESSURE, DISPLACEMENT, FORCE])


def as_text(headers=HEADERS, rows=None, sep=",", decimal=".", end="\n", last="", first=""):
    """A table as text; `last` is put behind each line, `first` before it."""
    lines = [first + sep.join(headers) + last] if headers else []
    for row in values() if rows is None else rows:
        cells = [cell if isinstance(cell, str) else f"{cell:.6g}".replace(".", decimal) for cell in row]
        lines.append(first + sep.join(cells) + last)
    return end.join(lines) + end


def assert_right(record):
    """The record holds the test's numbers."""
    np.testing.assert_allclose(record.inputs.time - record.inputs.time[0], TIME, atol=1e-9)
    np.testing.assert_allclose(record.inputs.pressure, PRESSURE, rtol=1e-7)
    np.testing.assert_allclose(record.inputs.displacement_mm, DISPLACEMENT, atol=1e-7)
    np.testing.assert_allclose(record.force, FORCE, rtol=1e-7)
