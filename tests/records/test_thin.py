"""A long record read thinly keeps its reversals, pressures and cycles."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.records import build_record, thinned

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)


def loops(cycles, per_cycle, pressures=(0.2, 0.3, 0.4)):
    """Triangles of 30 mm at each pressure, 10 s a cycle, 20 s between the pressures."""
    n = cycles * per_cycle
    time = np.concatenate(
        [np.arange(n) * (10.0 / per_cycle) + k * (cycles * 10.0 + 20.0) for k in range(len(pressures))]
    )
    phase = np.tile(np.arange(n) % per_cycle / per_cycle, len(pressures))
    x = 30.0 * (1.0 - np.abs(1.0 - 2.0 * phase))
    pressure = np.repeat(pressures, n)
    return build_record("loops", MUSCLE, pressure, x / 200.0, 400.0 - 5.0 * x, time=time)


def test_a_short_record_is_left_alone():
    record = loops(2, 100)
    assert thinned(record, 1000) is record


def test_dense_strokes_keep_their_ends_and_an_even_spacing():
    record = loops(3, 2000)
    thin = thinned(record, 1800)
    assert 1800 <= len(thin) <= 2000
    x, kept = record.inputs.displacement_mm, thin.inputs.displacement_mm
    assert kept.min() == x.min() and kept.max() == x.max()
    np.testing.assert_array_equal(np.unique(thin.stroke), np.unique(record.stroke))
    assert np.max(np.abs(np.diff(kept))) < 1.5 * 2 * 30.0 / 200.0 * 2
    np.testing.assert_array_equal(np.sort(thin.inputs.time), thin.inputs.time)


@pytest.mark.long
def test_what_counts_from_the_start_of_the_test_still_does():
    """Drift and warming are counted from the first sample, and the softening is largest in the first cycles."""
    record = loops(400, 60)
    thin = thinned(record, 6000)
    first = record.inputs.time <= thin.inputs.time[thin.inputs.segment == 0].max()
    assert thin.inputs.time[0] == record.inputs.time[0]
    np.testing.assert_array_equal(np.unique(thin.stroke[thin.inputs.segment == 0]), np.unique(record.stroke[first]))


@pytest.mark.long
def test_of_many_cycles_whole_ones_are_kept_at_every_pressure():
    record = loops(400, 60)
    thin = thinned(record, 6000)
    assert 3000 < len(thin) < 9000
    np.testing.assert_array_equal(thin.levels, record.levels)
    last = thin.inputs.segment.max()
    assert last >= 8
    for k in range(last + 1):
        part = thin.inputs.segment == k
        assert len(np.unique(thin.level[part])) == 1
        inside = np.diff(thin.inputs.time[part])
        assert inside.max() < 1.0  # no gap within a stretch
        cycles, rows = np.unique(thin.inputs.cycle[part], return_counts=True)
        assert np.all(rows >= 40) and np.all(np.diff(cycles) == 1.0)
