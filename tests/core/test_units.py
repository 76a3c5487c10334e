"""Units at the border."""

import pytest

from pam_ident.core import DataError
from pam_ident.core.units import TO_INTERNAL, conversion, split_header

KNOWN = [
    ("time", "ms", 250.0, 0.25),
    ("time", "sec", 3.0, 3.0),
    ("time", "min", 2.0, 120.0),
    ("time", "h", 2.0, 7200.0),
    ("time", "day", 2.0, 172800.0),
    ("pressure", "MPa", 0.3, 0.3),
    ("pressure", "kPa", 300.0, 0.3),
    ("pressure", "Pa", 3e5, 0.3),
    ("pressure", "bar", 3.0, 0.3),
    ("pressure", "mbar", 3000.0, 0.3),
    ("pressure", "hPa", 3000.0, 0.3),
    ("pressure", "psi", 100.0, 0.689475729),
    ("length", "mm", 12.0, 12.0),
    ("length", "cm", 1.2, 12.0),
    ("length", "m", 0.012, 12.0),
    ("length", "um", 12000.0, 12.0),
    ("length", "in", 1.0, 25.4),
    ("force", "N", 7.0, 7.0),
    ("force", "kN", 0.5, 500.0),
    ("force", "mN", 500.0, 0.5),
    ("force", "lbf", 100.0, 444.82216),
    ("force", "kgf", 10.0, 98.0665),
    ("force", "daN", 4.0, 40.0),
    ("force", "kg", 10.0, 98.0665),
    ("temperature", "C", 21.5, 21.5),
    ("temperature", "degC", 21.5, 21.5),
    ("temperature", "K", 294.65, 21.5),
    ("temperature", "degF", 70.7, 21.5),
    ("ratio", "pct", 12.5, 0.125),
    ("ratio", "%", 12.5, 0.125),
    ("ratio", "1", 0.125, 0.125),
    ("ratio", "-", 0.125, 0.125),
    ("time", "s", 3.0, 3.0),
]


@pytest.mark.parametrize(("dimension", "unit", "given", "internal"), KNOWN)
def test_a_unit_converts_to_its_known_value(dimension, unit, given, internal):
    factor, offset = conversion(dimension, unit, "x")
    assert factor * given + offset == pytest.approx(internal, rel=1e-8)


def test_every_unit_the_table_offers_is_checked_against_a_known_value():
    offered = {(dimension, unit) for dimension, units in TO_INTERNAL.items() for unit in units}
    assert offered == {(dimension, unit) for dimension, unit, _, _ in KNOWN}


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("force_N", "force", "N"),
        ("pressure_MPa", "pressure", "MPa"),
        ("pressure_set_MPa", "pressure_set", "MPa"),
        ("Pressure [bar]", "pressure", "bar"),
        ("Force (kN)", "force", "kN"),
        ("Pressure set [kPa]", "pressure_set", "kPa"),
        (" Temperature [°C] ", "temperature", "C"),
        ("contraction", "contraction", None),
        ("Time, s", "time", "s"),
        ("Load, cell", "load,_cell", None),
        ("contraction_pct", "contraction", "pct"),
        ("Contraction [%]", "contraction", "%"),
        ("length_mm", "length", "mm"),
        ("Force()", "force", None),
        ("load_cell_id", "load_cell_id", None),
    ],
)
def test_a_header_is_split_into_name_and_unit(header, name, unit):
    assert split_header(header) == (name, unit)


def test_units_are_read_whatever_their_case_where_that_is_unambiguous():
    assert conversion("pressure", "Bar", "x") == conversion("pressure", "bar", "x")
    assert conversion("pressure", "KPA", "x") == conversion("pressure", "kPa", "x")
    assert conversion("pressure", "mpa", "x") == conversion("pressure", "MPa", "x")
    assert conversion("force", "mN", "x") != conversion("force", "kN", "x")


@pytest.mark.parametrize("unit", ["stone", "N", "", None])
def test_an_unknown_or_missing_unit_is_refused_with_the_known_ones(unit):
    with pytest.raises(DataError, match=r"file.csv, column 'p'.*expected one of MPa, kPa, Pa, bar") as caught:
        conversion("pressure", unit, "file.csv, column 'p'")
    assert caught.value.exit_code == 4
