"""Under held loads it is the pressure that is driven at a speed; how fast the length answers tells nothing more."""

import math

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.schedule import one_speed
from pam_ident.fitting.carried import driven
from pam_ident.model import Model
from pam_ident.records import build_record

LAW = Model.build("chou_hannaford")


def weights(rates, friction=0.0):
    """Three weights on an ideal braid whose pressure goes up and down twice at each of the rates in MPa/s, dry
    friction in N, noise of 0.02 mm."""
    slope, foot = 3.0 / math.tan(math.radians(25.0)) ** 2, 1.0 / math.sin(math.radians(25.0)) ** 2
    way, rows, t = np.linspace(0.0, 1.0, 40), [], 0.0
    for weight in (50.0, 150.0, 300.0):
        for rate in rates * 2:
            for sign, part in ((1.0, way), (-1.0, way[::-1])):
                p = 0.25 + 0.3 * part
                times = t + 0.3 / rate * way
                t = times[-1] + 0.3 / rate / 40
                pull = weight + sign * friction
                shorter = 1.0 - np.sqrt((pull / (math.pi * 100.0 * p) + foot) / slope)
                rows += zip(times, p, shorter, np.full(40, weight), strict=True)
    time, pressure, contraction, force = np.array(rows).T
    contraction += np.random.default_rng(3).normal(0.0, 1e-4, len(time))
    return build_record("made", Specimen("made", 200.0, 10.0, 25.0), pressure, contraction, force, time=time)


@pytest.mark.parametrize(("rates", "one"), [((0.05,), True), ((0.02, 0.1), False)])
def test_one_rate_is_one_speed_though_a_light_weight_goes_further(rates, one):
    record = driven(LAW, weights(rates))
    assert record.carried and record.inputs.stroke_speed is not None
    speeds = record.inputs.stroke_speed[record.inputs.moving]
    assert np.quantile(speeds, 0.9) > 1.5 * np.quantile(speeds, 0.1)
    assert one_speed(record) == one


@pytest.mark.long
def test_friction_is_not_told_from_what_follows_the_speed_at_one_rate():
    found = diagnose(LAW, weights((0.05,), friction=8.0))
    assert found.follows[0].what == "direction"
    ((first, *others),) = found.groups
    assert first == "coulomb_friction" and {"stribeck_friction", "pressure_lag"} <= set(others)
    assert found.next_experiment is not None
