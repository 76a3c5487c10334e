"""What the figure of the knee would draw, against the linkage's own lengths and angles, and that it can be drawn."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from pam_ident.leg.anatomy import KNEE
from pam_ident.plot import four_bar, to_svg


def test_postures_keep_the_links_lengths_and_turn_the_shank():
    shown = four_bar.data(KNEE)
    assert [p.flexion_deg for p in shown.postures] == [0.0, 25.0, 50.0, 75.0]
    crank, coupler, rocker, ground = 1e3 * np.array(KNEE.lengths)
    straight = shown.postures[0].pivots
    for posture in shown.postures:
        a, b, c, d = posture.pivots
        assert [abs(c - a), abs(d - c), abs(d - b), abs(b - a)] == pytest.approx([crank, coupler, rocker, ground])
        turned = np.degrees(np.angle((straight[3] - straight[2]) / (d - c)))
        assert turned == pytest.approx(posture.flexion_deg, abs=1e-9)


def test_ratio_integrates_to_the_crank_s_turn():
    shown = four_bar.data(KNEE)
    first, last = (four_bar.data(KNEE, (x,)).postures[0].pivots for x in four_bar.RANGE_DEG)
    turned = np.degrees(np.angle((first[2] - first[0]) / (last[2] - last[0])))
    assert np.trapezoid(shown.ratio, shown.flexion_deg) == pytest.approx(turned, abs=1e-3)


def test_centre_lies_on_both_links():
    shown = four_bar.data(KNEE, n=81)
    for posture in shown.postures:
        centre = shown.centre[np.argmin(np.abs(shown.flexion_deg - posture.flexion_deg))]
        a, b, c, d = posture.pivots
        assert ((centre - a) / (c - a)).imag == pytest.approx(0.0, abs=1e-9)
        assert ((centre - b) / (d - b)).imag == pytest.approx(0.0, abs=1e-9)


def test_it_can_be_drawn_and_says_its_units():
    svg = to_svg(four_bar.draw(KNEE))
    assert ET.fromstring(svg).tag.endswith("svg")
    for words in ("forward (mm)", "up (mm)", "knee flexion φ (°)", "ds/dφ (1)", "instantaneous centre", "75°"):
        assert words in svg
