"""Of which rows the track tells no state."""

import numpy as np

from pam_ident.core import Specimen
from pam_ident.diagnosis.track import TrackError
from pam_ident.records import build_record

MUSCLE = Specimen("weights", 200.0, 10.0, 25.4, 1.5)


def test_a_load_that_friction_still_holds_tells_of_no_sliding():
    """Ramps of the pressure under a weight: after each turn the length waits until twice the friction is overcome."""
    rng = np.random.default_rng(4)
    ramp = np.r_[np.linspace(0.15, 0.45, 120), np.linspace(0.45, 0.15, 120)]
    p = np.tile(ramp, 6)
    load, friction = np.repeat([150.0, 300.0], 720), 12.0
    low, high = (MUSCLE.ideal_contraction(p, load + sign * friction) for sign in (1.0, -1.0))
    e = np.empty(len(p))
    now = low[0]
    for k in range(len(p)):  # it slides at either end of what friction can hold, and rests between
        now = e[k] = min(max(now, low[k]), high[k])
    stuck = np.abs(np.diff(e, prepend=e[0] - 1.0)) < 1e-12
    seen, time = e + 0.05 / 200.0 * rng.standard_normal(len(e)), np.arange(len(p)) * 0.2
    record = build_record("w", MUSCLE, p, seen, load, time=time, said_kind="isotonic")
    unread = TrackError.of(record, record).unread
    assert 0.03 < stuck.mean() < 0.3
    assert np.mean(unread[stuck]) > 0.9 and np.mean(unread[~stuck]) < 0.05
