"""What a column may be: by its name, by its unit, by its numbers."""

import numpy as np
import pytest

from pam_ident.records.guess import guess_columns, told_by, units_of

N = 400
TIME = np.arange(N) * 0.05
CONTRACTION = 20.0 * (1.0 - np.cos(2.0 * np.pi * TIME / 5.0))
PRESSURE = np.repeat([0.2, 0.3, 0.4, 0.5], N // 4)
FORCE = PRESSURE * (2500.0 - 50.0 * CONTRACTION) + np.random.default_rng(4).normal(0.0, 5.0, N)


def told(headers, *columns):
    return [(one.quantity, one.unit) for one in guess_columns(headers, columns)]


@pytest.mark.parametrize(
    ("headers", "factor", "unit"),
    [
        (["Zeit", "Druck", "Weg", "Kraft"], 10.0, "bar"),
        (["t", "PressureSensor", "stroke", "LoadCell"], 1000.0, "kPa"),
        (["time_s", "p (psi)", "LVDT [mm]", "F"], 145.0, "psi"),
        (["a", "b", "c", "d"], 1.0, "MPa"),
        (["Dev1/ai0", "Dev1/ai1", "Dev1/ai2", "Dev1/ai3"], 10.0, "bar"),
    ],
)
def test_columns_are_found_by_name_and_where_that_says_nothing_by_their_numbers(headers, factor, unit):
    found = told(headers, TIME, factor * PRESSURE, CONTRACTION, FORCE)
    assert found == [("time", "s"), ("pressure", unit), ("displacement", "mm"), ("force", "N")]
    order = [3, 1, 0, 2]
    columns = [TIME, factor * PRESSURE, CONTRACTION, FORCE]
    assert told([headers[k] for k in order], *(columns[k] for k in order)) == [found[k] for k in order]


def test_what_a_name_says_is_sure_and_what_the_numbers_say_is_not():
    found = guess_columns(["t", "AI0", "Weg [mm]", "Kraft"], [TIME, PRESSURE, CONTRACTION, FORCE])
    assert [one.sure for one in found] == [True, False, True, True]


def test_units_that_are_stated_are_taken_and_others_told_by_size():
    assert told(["P [bar abs]", "x", "F [kN]"], PRESSURE, CONTRACTION / 1000.0, FORCE / 1000.0) == [
        ("pressure", "bar_abs"),
        ("displacement", "m"),
        ("force", "kN"),
    ]
    assert told(["pressure", "contraction", "force"], PRESSURE, CONTRACTION, FORCE)[1] == ("contraction", "pct")
    assert told(["T_soll", "temperature"], np.full(N, 3.0), np.full(N, 295.0))[1] == ("temperature", "K")
    assert told(["t [s]", "T [K]"], TIME, np.full(N, 295.0)) == [("time", "s"), ("temperature", "K")]
    assert told(["t", "T [°C]"], TIME, np.full(N, 22.0))[1] == ("temperature", "C")
    assert "bar_abs" in units_of("pressure") and units_of("cycle") == ()


def test_an_extension_counts_the_other_way():
    headers = ["Time", "Pressure", "Extension [mm]", "Load"]
    found = guess_columns(headers, [TIME, PRESSURE, -CONTRACTION, FORCE])
    assert told_by(headers, headers, 2, found[2]) == 'displacement_mm = {column = "Extension [mm]", factor = -1}'
    assert [one.factor for one in found] == [1, 1, -1, 1]


def test_a_column_that_holds_no_numbers_or_never_changes_is_nothing():
    nothing = np.full(N, np.nan)
    assert told(["note", "AI0", "AI1"], nothing, np.zeros(N), TIME) == [("", ""), ("", ""), ("time", "s")]
