"""Gait series against their tables, finite differences and made tables with known harmonics; what is refused."""

import numpy as np
import pytest

from pam_ident.core import DataError
from pam_ident.leg.arrays import jax, jnp
from pam_ident.leg.gait import read_gait, winter

HEADER = "gait_percent,knee_deg\n"


def write(folder, text):
    path = folder / "gait.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_winter_s_table_is_met_to_half_a_degree(root):
    gait = winter()
    table = np.loadtxt(root / "datasets" / "gait" / "winter_stride.csv", delimiter=",", skiprows=1)
    motion = gait.at(table[:, 0] / 100.0)
    for k, (swing, rms) in enumerate(zip(motion, gait.rms_deg, strict=True)):
        found = np.sqrt(np.mean((np.degrees(swing.angle) - table[:, k + 1]) ** 2))
        assert found == pytest.approx(rms, rel=1e-9)
        assert found < 0.5
    assert gait.harmonics == 6


def test_children_s_knee_is_met_and_the_other_joints_rest(root):
    gait = read_gait(root / "datasets" / "gait" / "knee_mean_sd.csv")
    assert gait.rms_deg[0] < 0.5 and gait.rms_deg[1:] == (0.0, 0.0)
    assert float(np.degrees(gait.at(0.725).knee.angle)) == pytest.approx(73.923, abs=1.0)
    assert float(gait.at(0.3).hip.acceleration) == 0.0


def test_derivatives_are_those_of_the_angle():
    gait, t, h = winter(0.8), np.linspace(0.0, 1.25, 40), 1e-5
    for ahead, here, behind in zip(gait.at(t + h), gait.at(t), gait.at(t - h), strict=True):
        np.testing.assert_allclose((ahead.angle - behind.angle) / (2 * h), here.rate, atol=2e-8)
        np.testing.assert_allclose((ahead.rate - behind.rate) / (2 * h), here.acceleration, atol=5e-7)


def test_cadence_stretches_time_only():
    slow, fast = winter(0.5).at(0.6), winter(1.5).at(0.2)
    assert slow.knee.angle == pytest.approx(fast.knee.angle, rel=1e-12)
    assert 3.0 * slow.knee.rate == pytest.approx(fast.knee.rate, rel=1e-12)
    assert 9.0 * slow.knee.acceleration == pytest.approx(fast.knee.acceleration, rel=1e-12)
    assert winter(0.5).at(2.6).hip.angle == pytest.approx(winter(0.5).at(0.6).hip.angle, rel=1e-12)


def test_jax_gives_the_same():
    t = np.linspace(0.0, 1.0, 11)
    for a, b in zip(jax.jit(winter().at)(jnp.asarray(t)), winter().at(t), strict=True):
        np.testing.assert_allclose(np.stack(a), np.stack(b), rtol=0, atol=1e-12)


def test_a_timed_table_gives_its_cadence_and_series(tmp_path):
    t = np.arange(40) / 40.0 * 1.6 + 5.0
    knee = 25.0 + 20.0 * np.cos(2 * np.pi * (t - 5.0) / 1.6) + 7.0 * np.sin(4 * np.pi * (t - 5.0) / 1.6)
    rows = "".join(f"{a!r},{b!r},3.0\n" for a, b in zip(t.tolist(), knee.tolist(), strict=True))
    gait = read_gait(write(tmp_path, "time_s,knee_deg,ankle_deg\n" + rows))
    assert gait.cadence_Hz == pytest.approx(1 / 1.6, rel=1e-12)
    assert gait.harmonics == 2
    np.testing.assert_allclose(np.degrees(gait.cosines[0]), [25.0, 20.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(np.degrees(gait.sines[0]), [0.0, 0.0, 7.0], atol=1e-9)
    assert float(np.degrees(gait.at(0.4).ankle.angle)) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,knee\n0,1\n", "0 columns of phase"),
        ("gait_percent,time_s,knee_deg\n0,0,1\n", "2 columns of phase"),
        ("gait_percent,hip_deg\n" + "".join(f"{k},1\n" for k in range(0, 100, 5)), "no column knee_deg, only"),
        (
            HEADER + "0,1\n50,x\n" + "".join(f"{k},1\n" for k in range(60, 100, 5)),
            "row 3, column knee_deg: 'x'; expected a number",
        ),
        (HEADER + "0,1\n50,2\n99,3\n", "3 rows; expected at least 8"),
        (
            HEADER + "".join(f"{k},1\n" for k in (0, 10, 20, 30, 30, 50, 70, 90, 99)),
            "row 6: gait_percent does not rise",
        ),
        (HEADER + "".join(f"{k},1\n" for k in range(0, 50, 5)), "from 0 to 45; expected one whole stride, 0 to 100"),
        ("", "cannot be read"),
    ],
)
def test_tables_that_hold_no_gait_are_refused(tmp_path, text, message):
    with pytest.raises(DataError, match=message):
        read_gait(write(tmp_path, text))


def test_a_cadence_that_is_no_cadence_is_refused():
    with pytest.raises(DataError, match="cadence of 0 Hz"):
        winter(0)
