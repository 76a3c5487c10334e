"""Of which samples nobody knows whether the muscle rests, or which way it slides."""

import numpy as np

from pam_ident.core import Specimen
from pam_ident.diagnosis.steady import steadied
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 1.5)


def unread(x):
    """The record of a track in mm at 10 Hz and one pressure, and its samples of unknown state."""
    t, p = 0.1 * np.arange(len(x)), np.full(len(x), 0.3)
    rng = np.random.default_rng(2)
    record = build_record("r", MUSCLE, p, (x + 0.01 * rng.standard_normal(len(x))) / 200.0, 300.0 - 4.0 * x, time=t)
    found = fit(Model.build("modified_chou_hannaford"), record)
    return record, steadied(record, found.model, found.values)[1].unread


def test_a_rest_of_few_rows_at_a_turn_may_be_the_slow_part_of_a_smooth_motion():
    once = 25.0 * (1.0 - np.cos(2.0 * np.pi * np.arange(1, 171) / 170.0))
    record, unknown = unread(np.tile(np.r_[once, np.zeros(25)], 4))
    top = ~record.inputs.moving & (record.inputs.displacement_mm > 40.0)
    assert top.sum() >= 4
    assert np.all(unknown[top])


def test_a_hold_at_a_turn_is_known_to_rest():
    up = np.linspace(0.0, 30.0, 40)
    record, unknown = unread(np.tile(np.r_[up, np.full(20, 30.0), up[::-1], np.zeros(20)], 3))
    rest = ~record.inputs.moving
    assert rest.sum() > 100
    assert unknown[rest].sum() <= 12  # the first and the last of each
