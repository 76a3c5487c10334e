"""The sample at a corner of the motion: whether it rests is told by the force."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
from pam_ident.records.record import build_record

SPECIMEN = Specimen("made", 200.0, 10.0, 25.0)
RUN, HOLD, PASSES = 30, 6, 4


def record(begun, friction, seed=3, noise_N=1.0):
    """Strokes at constant speed between holds, at four pressures. The last sample of a hold lies at the corner, where
    the friction is that of the stroke if it has `begun`; `friction` takes contraction to newtons."""
    rng = np.random.default_rng(seed)
    columns = []
    for pressure in (0.15, 0.25, 0.4, 0.5):
        for speed in (4.0, 12.0, 40.0):
            for _ in range(PASSES):
                for sign in (1.0, -1.0):
                    way = np.linspace(0.0, 1.0, RUN + 1)[1:]
                    x = np.r_[40.0 * (way if sign > 0.0 else 1.0 - way), np.full(HOLD, 40.0 * (sign > 0.0))]
                    step = np.r_[np.full(RUN, 40.0 / speed / RUN), np.full(HOLD, 0.5)]
                    side = np.full(len(x), sign)
                    side[-1] = -sign if begun else sign
                    columns.append((step, x, side, np.full(len(x), pressure)))
    step, x, side, pressure = (np.concatenate(parts) for parts in zip(*columns, strict=True))
    contraction = x / SPECIMEN.initial_length_mm
    force = Model.build("modified_chou_hannaford").force
    true = {"k0": 0.9, "k1": 1.2, "k2": 5.0}
    made = build_record("made", SPECIMEN, pressure, contraction, 0.0 * x, time=np.cumsum(step))
    pull = force(made.inputs, true) - side * friction(contraction)
    return build_record(
        "made",
        SPECIMEN,
        pressure + 1e-4 * rng.standard_normal(len(x)),
        (x + 0.01 * rng.standard_normal(len(x))) / SPECIMEN.initial_length_mm,
        pull + noise_N * rng.standard_normal(len(x)),
        time=np.cumsum(step),
        level=pressure,
    )


def corners(made):
    """Rows at the end of a hold that another stroke follows."""
    every = np.arange(RUN + HOLD - 1, len(made), RUN + HOLD)
    return every[:-1][np.diff(made.level[every]) == 0.0]


@pytest.mark.parametrize("begun", [True, False])
def test_the_force_tells_whether_the_corner_rests(begun):
    made = record(begun, lambda contraction: 6.0 + 0.0 * contraction)
    assert made.inputs.moving[corners(made)].mean() == pytest.approx(float(begun), abs=0.02)


def test_friction_that_grows_with_contraction_is_no_presliding():
    made = record(False, lambda contraction: 4.0 * (1.0 + 3.0 * (contraction / 0.2 - 0.1) ** 2))
    found = diagnose(Model.build("modified_chou_hannaford"), made)
    assert found.selected == ("coulomb_friction",)
    assert found.best.rmse == pytest.approx(1.0, rel=0.1)
