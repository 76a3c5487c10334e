"""Where the leg leaves what the fit has seen, in degrees of the gait."""

import re
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.leg.trouble import outside

WIDE = {"pressure_MPa": [0.0, 0.7], "contraction": [-0.1, 0.4], "speed_mm_s": [1.0, 500.0]}


@pytest.fixture
def asked(example, course):
    """Doubts of a model that has seen WIDE but for what is said, the pair at 0.3 MPa but for what is said."""
    pair, _ = example
    count = course.judged.stop - course.judged.start

    def told(pressure=None, **seen):
        held = np.full((count, 2), 0.3) if pressure is None else pressure
        return outside(pair, replace(pair.muscle, seen=WIDE | seen), course, held)

    return told, pair, course


def test_within_the_range_and_of_an_unknown_range_nothing_is_said(asked):
    told, pair, course = asked
    assert told() == [] and outside(pair, pair.muscle, course, np.zeros((200, 2))) == []
    assert told(pressure=np.full((200, 2), -0.013)) == []  # within a fiftieth of the range


def test_a_pressure_below_the_range_is_told_with_its_share_and_degrees(asked):
    told, _, course = asked
    pressure = np.full((200, 2), 0.3)
    pressure[40:60, 1] = 0.03
    (doubt,) = told(pressure, pressure_MPa=[0.1, 0.6])
    knee = np.degrees(course.gait.at(course.time[course.judged]).knee.angle)[40:60]
    assert doubt.code == "outside_range" and doubt.column == "pressure_MPa" and not doubt.grave
    assert "extensor at 0.03 to 0.3 MPa" in doubt.text and "10 % of the time" in doubt.text
    assert f"knee at {knee.min():.0f}° to {knee.max():.0f}°" in doubt.text and "20 to 29 % of the stride" in doubt.text


def test_a_stroke_beyond_the_range_is_told_of_both_muscles(asked):
    """The flexor is short where the knee is bent, the extensor long there: 0.028 + R s/L0 and 0.2155 − R s/L0."""
    told, pair, course = asked
    low, high = 0.1, 0.3
    doubts = told(contraction=[low, high])
    knee = course.gait.at(course.time[course.judged]).knee.angle
    turned = pair.leg.sprocket_radius_m * pair.leg.knee.at(knee).sprocket / 0.2
    for doubt, name, values in zip(doubts, ("flexor", "extensor"), (0.028 + turned, 0.2155 - turned), strict=True):
        left = np.degrees(knee)[values < low - 0.004]
        assert doubt.text.startswith(name) and f"knee at {left.min():.0f}° to {left.max():.0f}°" in doubt.text
        share = int(re.search(r"(\d+) % of the time", doubt.text)[1])
        assert share == round(100.0 * len(left) / len(knee))


def test_slow_motion_is_no_extrapolation_and_fast_motion_is(asked):
    told, _, _ = asked
    doubts = told(speed_mm_s=[50.0, 100.0])
    assert [doubt.column for doubt in doubts] == ["speed_mm_s"] * 2
    assert all("where the fit has seen 50 to 100 mm/s" in doubt.text for doubt in doubts)
    assert told(speed_mm_s=[50.0, 500.0]) == []
