"""Weights from the sensors, and a loss that outliers do not rule."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from pam_ident.core import DataError, Sensors, UsageError
from pam_ident.fitting import fit
from pam_ident.fitting.weigh import Weighing
from pam_ident.model import Model
from pam_ident.records import read_record

LAW = Model.build("exponential_law")


def with_sensors(one, sensors):
    specimen = replace(one.specimen, sensors=sensors)
    return replace(one, inputs=replace(one.inputs, specimen=specimen), steady=replace(one.steady, specimen=specimen))


def test_huber_is_that_of_scipy(record, law, truth):
    spoiled = record()
    force = spoiled.force.copy()
    force[::25] += 150.0
    one = fit(LAW, replace(spoiled, force=force), weighing=Weighing(loss="huber"))
    scale = np.median(np.abs(one.residual)) / 0.6745
    p, e = spoiled.inputs.pressure, spoiled.inputs.contraction
    scipys = least_squares(
        lambda x: law(x, p, e) - force, truth, loss="huber", f_scale=1.345 * scale, x_scale=np.abs(truth), xtol=1e-12,
        ftol=1e-14,
    )  # fmt: skip
    np.testing.assert_allclose([one.values[e.name] for e in one.estimates], scipys.x, rtol=1e-4, atol=0.02)
    plain = fit(LAW, replace(spoiled, force=force))
    off = [np.abs((np.array([f.values[e.name] for e in f.estimates]) - truth) / truth)[:4].max() for f in (plain, one)]
    assert off[0] > 3.0 * off[1]


def test_sensors_weigh_each_sample_by_what_their_errors_make_of_its_force(record, law, truth):
    one = with_sensors(record(), Sensors(0.5, 0.002, 0.1))
    weighed = fit(LAW, one, weighing=Weighing(sensors=True))
    p, e = one.inputs.pressure, one.inputs.contraction
    x = np.array([weighed.values[n] for n in ("a0", "a1", "b0", "b1", "c0", "c1", "mu")])
    by_p = x[1] - x[3] * e + x[5] * np.exp(-x[6] * e)
    by_e = -(x[2] + x[3] * p) - x[6] * (x[4] + x[5] * p) * np.exp(-x[6] * e)
    deviation = np.sqrt(0.5**2 + (0.002 * by_p) ** 2 + (0.1 / 200.0 * by_e) ** 2)
    np.testing.assert_allclose(weighed.weights, np.median(deviation) ** 0 / deviation * np.median(deviation), rtol=0.02)
    again = least_squares(
        lambda v: (law(v, p, e) - one.force) / deviation, truth, x_scale=np.abs(truth), xtol=1e-12, ftol=1e-14
    )
    np.testing.assert_allclose(x, again.x, rtol=1e-4, atol=1e-3)


def test_weights_without_sensors_are_refused_with_what_to_do(record):
    with pytest.raises(UsageError, match=r"no table \[sensors\].*force_N"):
        fit(LAW, record(), weighing=Weighing(sensors=True))
    with pytest.raises(UsageError, match="loss 'tukey'"):
        Weighing(loss="tukey")


def test_sensors_are_read_from_the_specimens_file(tmp_path, root):
    folder = root / "datasets" / "nothing_hidden"
    text = (folder / "specimen.toml").read_text()
    path = tmp_path / "specimen.toml"
    path.write_text(text + "\n[sensors]\nforce_N = 2.0\npressure_MPa = 0.0002\n")
    assert read_record(folder / "record.csv", path).specimen.sensors == Sensors(2.0, 0.0002, 0.0)
    assert read_record(folder / "record.csv").specimen.sensors is None
    for bad, match in (
        ("pressure_MPa = 0.1", "needs force_N"),
        ("force_N = -1.0", "force_N = -1.0"),
        ('force_N = "x"', "expected a number"),
        ("force_N = 1.0\nvolts = 2", r"\[sensors\] needs force_N and may hold"),
    ):
        path.write_text(f"{text}\n[sensors]\n{bad}\n")
        with pytest.raises(DataError, match=match):
            read_record(folder / "record.csv", path)
