"""The controller against sums done by hand."""

import numpy as np
import pytest

from pam_ident.leg.control import SAMPLE_S, Control, Gains, Sensor, pid, start

GAINS = Gains(2.0, 10.0, 0.1)
REACH = 2.0


def answers(errors, gains=GAINS, ahead=0.0, reach=REACH):
    """Splits of a controller that starts at the first of the errors."""
    control, found = start(np.float64(errors[0])), []
    for error in errors:
        split, control = pid(gains, control, np.float64(error), ahead, reach)
        found.append(float(split))
    return found, control


def test_three_samples_by_hand():
    """P 2·e. I 10·5 ms·Σe: 0.005, 0.015, 0.025. D: slopes of 0, 20, 0 rad/s, of which each sample takes a third."""
    found, control = answers([0.1, 0.2, 0.2])
    assert found == pytest.approx([0.205, 0.4 + 0.015 + 0.1 * 20 / 3, 0.4 + 0.025 + 0.1 * 40 / 9], rel=1e-12)
    assert control.integral == pytest.approx(0.0025) and control.slope == pytest.approx(40 / 9)


def test_the_derivative_of_a_ramp_is_its_slope_after_the_filter():
    ramp = 3.0 * SAMPLE_S * np.arange(200)
    found, control = answers(ramp, Gains(0.0, 0.0, 0.5))
    assert control.slope == pytest.approx(3.0, rel=1e-9) and found[-1] == pytest.approx(1.5, rel=1e-9)
    assert found[1] == pytest.approx(0.5)  # a third of it in the first sample after the start


def test_a_start_makes_no_jump():
    found, _ = answers([0.3], Gains(0.0, 0.0, 10.0))
    assert found == [0.0]


def test_the_integral_waits_only_where_the_limit_is_driven_into():
    """At the limit it stands still; an error the other way leaves the limit in the same sample."""
    gains = Gains(1.0, 100.0, 0.0)
    found, stuck = answers([0.5] * 40, gains, reach=1.0)
    assert found[-1] == 1.0
    # 0.5 + 100·0.005·0.5·n = 1 at n = 2; the integral stops there
    assert stuck.integral == pytest.approx(0.005, rel=1e-12)
    split, after = pid(gains, stuck, np.float64(-0.1), 0.0, 1.0)
    assert after.integral == pytest.approx(0.005 - 0.0005) and split == pytest.approx(-0.1 + 0.45)
    # at the limit, but with an error that leads away from it, the integral goes on
    over = Control(np.float64(0.02), np.float64(-0.1), np.float64(0.0))
    split, after = pid(gains, over, np.float64(-0.1), 0.0, 1.0)
    assert split == 1.0 and after.integral == pytest.approx(0.0195)


def test_feed_forward_and_correction_share_one_limit():
    gains = Gains(1.0, 0.0, 0.0)
    assert answers([0.3], gains, ahead=0.2, reach=0.25)[0] == pytest.approx([0.05])
    assert answers([-0.3], gains, ahead=0.2, reach=0.25)[0] == pytest.approx([-0.3])
    assert answers([-0.6], gains, ahead=0.2, reach=0.25)[0] == pytest.approx([-0.45])


def test_the_sensor_has_4096_steps():
    sensor = Sensor()
    step = (1.75 + 0.35) / 4096
    angles = np.linspace(-0.34, 1.74, 5001)
    seen = np.asarray(sensor.read(angles))
    assert np.max(np.abs(seen - angles)) <= step / 2 * (1 + 1e-9)
    counts = (seen + 0.35) / step
    assert counts == pytest.approx(np.round(counts), abs=1e-9)
    assert len(np.unique(np.round(np.asarray(sensor.read(np.linspace(-0.35, 1.75, 100_000))), 9))) == 4096
    assert float(sensor.read(-9.0)) == pytest.approx(-0.35)
    assert float(sensor.read(9.0)) == pytest.approx(1.75 - step)
