"""What the figures of a challenge would draw, against numbers worked out here, and that they can be drawn."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from scipy.stats import binomtest

from pam_ident.plot import calibration, confusion, to_svg
from pam_ident.validation.calibration import reliability

COUNTS = {("creep", "creep"): 5, ("nothing", "creep"): 2, ("friction", "nothing"): 1, ("unknown", "unknown"): 3}


def test_confusion_is_a_square_matrix_with_unknown_and_nothing_last():
    shown = confusion.data(COUNTS)
    assert shown.labels == ("creep", "friction", "unknown", "nothing")
    np.testing.assert_array_equal(shown.counts, [[5, 0, 0, 0], [0, 0, 0, 1], [0, 0, 3, 0], [2, 0, 0, 0]])


def test_calibration_gives_shares_with_wilson_s_interval():
    stated, true = [0.2] * 8 + [0.95] * 20, [True, *[False] * 7, *[True] * 19, False]
    shown = calibration.data(reliability(stated, true))
    assert shown.n == (8, 20) and shown.true == pytest.approx((1 / 8, 19 / 20))
    for k, (hits, n) in enumerate(((1, 8), (19, 20))):
        expected = binomtest(hits, n).proportion_ci(0.95, method="wilson")
        assert (shown.low[k], shown.high[k]) == pytest.approx((expected.low, expected.high), abs=1e-4)
    assert shown.brier == pytest.approx((0.8**2 + 7 * 0.2**2 + 19 * 0.05**2 + 0.95**2) / 28)


@pytest.mark.parametrize(
    ("figure", "words"),
    [
        (lambda: confusion.draw(COUNTS), ("8 of 11 named as what they are", "friction", "hidden", "named")),
        (
            lambda: calibration.draw(reliability([0.01, 0.5, 0.99], [False, True, True])),
            ("3 statements", "stated probability"),
        ),
    ],
)
def test_both_can_be_drawn_and_say_what_they_show(figure, words):
    svg = to_svg(figure())
    assert ET.fromstring(svg).tag.endswith("svg")
    assert all(word in svg for word in words)
