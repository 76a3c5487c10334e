"""Numbers read the same wherever they are shown."""

import math

import pytest

from pam_ident.core.digits import interval, known_to, percent


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


def test_what_is_not_nothing_is_not_0_percent():
    assert [percent(share) for share in (0.0, 0.003, 0.01, 0.997, 1.0)] == ["0 %", "< 1 %", "1 %", "> 99 %", "100 %"]
