"""Numbers read the same wherever they are shown."""

import math

import pytest

from pam_ident.core.digits import interval, known_to, newtons, number, percent, percents


@pytest.mark.parametrize(
    ("value", "error", "low", "high", "said"),
    [
        (2434.8, 1.7, 2431.382, 2438.217, "2431.4 to 2438.2"),
        (0.957, 0.060, 0.83702, 1.0769, "0.837 to 1.077"),
        (0.0640, 0.0045, 0.0550, 0.07296, "0.0550 to 0.0730"),
        (5506.0, 27.0, 5451.8, math.inf, "5452 to open"),
    ],
)
def test_an_interval_ends_at_the_place_of_its_value(value, error, low, high, said):
    assert interval(low, high, error) == said
    places = len(known_to(value, error).partition(".")[2])
    assert len(said.split()[0].partition(".")[2]) == places


@pytest.mark.parametrize(
    ("value", "digits", "said"),
    [(0.0996, 2, "0.10"), (0.0994, 2, "0.099"), (99.6, 2, "100"), (9.999, 3, "10.0"), (-0.99996, 4, "-1.000")],
)
def test_a_number_that_is_rounded_up_to_a_power_of_ten_gets_no_digit_more(value, digits, said):
    assert number(value, digits) == said


def test_a_value_ends_where_its_error_ends():
    """`0.34 ± 0.100` was said of an error of 0.0996."""
    for error in (0.0996, 0.0994, 0.996, 0.0104, 0.00999):
        ends = [text.partition(".")[2] for text in (known_to(0.3377, error), number(error, 2))]
        assert len(ends[0]) == len(ends[1]), ends


def test_shares_of_a_whole_add_to_it():
    assert percents([0.345, 0.335, 0.32]) == ["35 %", "33 %", "32 %"]
    assert percents([0.447, 0.287, 0.146, 0.12]) == ["45 %", "29 %", "14 %", "12 %"]  # each rounded: 45, 29, 15, 12
    assert percents([0.997, 0.003]) == ["> 99 %", "< 1 %"]


def test_what_is_not_nothing_is_not_0_percent():
    assert [percent(share) for share in (0.0, 0.003, 0.01, 0.997, 1.0)] == ["0 %", "< 1 %", "1 %", "> 99 %", "100 %"]


def test_a_force_that_no_muscle_has_is_said_to_be_that():
    assert [newtons(value) for value in (1e-7, 12.34, 1.63e9)] == ["0 N", "12.3 N", "over a million N"]
