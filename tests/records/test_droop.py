"""A regulator that droops while the muscle moves still holds one pressure."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.records import build_record

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 1.5)


def loops(pressures, droop):
    """Two slow and two fast loops with rests at each pressure, which falls by `droop` in MPa on each fast way out."""
    there, rest = np.linspace(0.0, 30.0, 40), np.ones(15)
    loop = np.concatenate([there, 30.0 * rest, there[::-1], 0.0 * rest])
    out = np.concatenate([np.ones(40), 0.0 * rest, -np.ones(40), 0.0 * rest])
    x, way = np.tile(loop, 4), np.tile(out, 4) * np.repeat((0.0, 0.0, 1.0, 1.0), len(loop))
    step = np.where(way != 0, 0.02, 0.2)
    time = np.cumsum(np.tile(step, len(pressures))) + np.repeat(1000.0 * np.arange(len(pressures)), len(x))
    p = np.concatenate([level - droop * way for level in pressures])
    x = np.tile(x, len(pressures))
    return build_record("r", MUSCLE, p, x / 200.0, 1000.0 * p - 4.0 * x, time=time)


@pytest.mark.parametrize("droop", [0.0, 0.007, 0.015])
def test_a_drooping_regulator_makes_no_more_isobars(droop):
    record = loops((0.2, 0.3), droop)
    assert record.levels == pytest.approx([0.2, 0.3])
    assert len(np.unique(record.block)) == len(np.unique(loops((0.2, 0.3), 0.0).block))


def test_close_isobars_that_are_driven_alike_stay_apart():
    assert loops((0.2, 0.215, 0.23), 0.0).levels == pytest.approx([0.2, 0.215, 0.23])
