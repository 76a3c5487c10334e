"""Forces that follow what an effect follows, by curves that no form of it has, in strokes between holds."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
from pam_ident.records.record import build_record

SPECIMEN = Specimen("made", 200.0, 10.0, 25.0)
LAW, TRUE = Model.build("modified_chou_hannaford"), {"k0": 0.9, "k1": 1.2, "k2": 5.0}
RUN, HOLD, STROKE_MM = 30, 6, 40.0
NOISE_N, NOISE_MM, NOISE_MPA = 1.0, 0.01, 1e-4


def strokes(hidden, begun=False, speeds=(4.0, 12.0, 40.0), times=4, seed=3):
    """At four pressures, `times` there and back at each of the speeds in mm/s. The last sample of a hold lies at the
    corner, and there the friction is that of the stroke if it has `begun`. `hidden` takes pressure in MPa, contraction
    over the largest, the side (±1, kept in holds) and velocity in mm/s (0 in holds) to the force in N."""
    rng, columns = np.random.default_rng(seed), []
    for pressure in (0.15, 0.25, 0.4, 0.5):
        for speed in speeds:
            for sign in (1.0, -1.0) * times:
                way = np.linspace(0.0, 1.0, RUN + 1)[1:]
                x = np.r_[way if sign > 0.0 else 1.0 - way, np.full(HOLD, float(sign > 0.0))]
                step = np.r_[np.full(RUN, STROKE_MM / speed / RUN), np.full(HOLD, 0.5)]
                side, velocity = np.full(len(x), sign), np.r_[np.full(RUN, sign * speed), np.zeros(HOLD)]
                side[-1] = -sign if begun else sign
                columns.append((step, x, side, velocity, np.full(len(x), pressure)))
    step, x, side, velocity, pressure = (np.concatenate(parts) for parts in zip(*columns, strict=True))
    time, contraction = np.cumsum(step), STROKE_MM * x / SPECIMEN.initial_length_mm
    pull = LAW.force(build_record("made", SPECIMEN, pressure, contraction, 0.0 * x, time=time).inputs, TRUE)
    return build_record(
        "made",
        SPECIMEN,
        pressure + NOISE_MPA * rng.standard_normal(len(x)),
        contraction + NOISE_MM * rng.standard_normal(len(x)) / SPECIMEN.initial_length_mm,
        pull + hidden(pressure, x, side, velocity) + NOISE_N * rng.standard_normal(len(x)),
        time=time,
        level=pressure,
    )


def corners(record):
    """Rows at the end of a hold that another stroke follows."""
    every = np.arange(RUN + HOLD - 1, len(record), RUN + HOLD)
    return every[:-1][np.diff(record.level[every]) == 0.0]


HIDDEN = {
    "coulomb_friction": lambda p, e, side, v: -4.0 * side * (1.0 + 3.0 * (e - 0.1) ** 2),
    "pressure_friction": lambda p, e, side, v: -9.0 * side * p**0.7 * (1.0 + 1.5 * e),
    "stribeck_friction": lambda p, e, side, v: (
        -2.0 * side * (0.7 + 2.3 / (1.0 + (np.abs(v) / 6.4) ** 2)) * (1.2 - 0.6 * e) * (v != 0.0)
    ),
    "viscous_damping": lambda p, e, side, v: -3.0 * np.sign(v) * (np.abs(v) / 10.0) ** 0.67 * np.where(v > 0, 1.0, 0.5),
}


@pytest.mark.parametrize("begun", [True, False])
def test_the_force_tells_whether_a_corner_rests(begun):
    made = strokes(lambda p, e, side, v: -6.0 * side, begun)
    assert made.inputs.moving[corners(made)].mean() == pytest.approx(float(begun), abs=0.02)


@pytest.mark.parametrize("name", HIDDEN)
def test_a_name_rests_on_what_the_force_follows(name):
    record = strokes(HIDDEN[name], speeds=(1.0, 4.0, 15.0, 50.0), times=3)
    found = diagnose(LAW, record)
    assert set(found.selected) == {name}, found.sentence
    assert found.base.rmse > 1.5 * NOISE_N and found.best.rmse < 1.1 * NOISE_N
