"""What each figure would draw, against numbers worked out here."""

import math

import numpy as np
import pytest

from pam_ident.diagnosis.compare import compare
from pam_ident.diagnosis.drivers import DRIVERS
from pam_ident.diagnosis.nouns import Follows, Pattern
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.plot import (
    candidates,
    failure_map,
    follows,
    measured_against_model,
    profiles,
    residual_pattern,
    signature,
)
from pam_ident.plot import (
    ladder as ladder_figure,
)


def test_measured_curves_are_the_record_s_samples(diagnosis):
    curves = measured_against_model.data(diagnosis.base, diagnosis.best)
    assert [(c.pressure_MPa, c.branch) for c in curves] == [
        (0.3, "contraction"),
        (0.3, "extension"),
        (0.5, "contraction"),
        (0.5, "extension"),
    ]
    record = diagnosis.base.record
    rows = (record.level == 0.5) & (record.inputs.direction == -1.0)
    last = curves[-1]
    assert sorted(last.measured) == pytest.approx(sorted(record.force[rows]))
    assert np.mean(last.before) == pytest.approx(diagnosis.base.residual[rows].mean())
    assert last.after is not None
    assert np.mean(last.after) == pytest.approx(diagnosis.best.residual[rows].mean())
    assert np.mean(last.before) > 5.0 > abs(np.mean(last.after))
    # All samples lie at 41 lengths, so each vertex of the line is the model's mean at one length.
    assert len(last.line) == 41
    third = rows & (np.abs(record.inputs.contraction - 0.01) < 1e-9)
    assert last.line[2] == pytest.approx(0.01)
    assert last.line_force[2] == pytest.approx(diagnosis.best.force[third].mean())


@pytest.mark.parametrize("limit", [4, 30, 100, 656, 1500])
def test_measured_points_stay_below_the_limit(diagnosis, limit):
    curves = measured_against_model.data(diagnosis.base, limit=limit)
    total = sum(len(c.measured) for c in curves)
    assert total <= limit
    assert total >= min(limit, len(diagnosis.base.record)) / 2
    assert all(c.after is None for c in curves)


def test_a_table_s_line_is_the_law_itself(table):
    one = fit(Model.build("modified_chou_hannaford"), table)
    curves = measured_against_model.data(one)
    assert [c.branch for c in curves] == ["static"] * 3
    curve = curves[1]
    assert curve.line[[0, -1]] == pytest.approx([0.0, 0.2])
    expected = one.model.law.force(np.full(60, 0.4), curve.line, table.specimen, one.values)
    assert curve.line_force == pytest.approx(expected)


def test_the_band_of_a_line_is_its_interval_and_the_widest_is_shown(table):
    one = fit(Model.build("modified_chou_hannaford"), table)
    curves = measured_against_model.data(one)
    _, low, high = one.band(table.inputs)
    for curve in curves:
        rows = (table.level == curve.pressure_MPa) & (table.inputs.contraction == table.inputs.contraction.max())
        assert curve.half[-1] == pytest.approx(0.5 * (high - low)[rows][0], rel=1e-6)
    _, half = measured_against_model.widest(curves)
    assert half[-1] == pytest.approx(max(c.half[-1] for c in curves))


def test_failure_map_is_the_comparison_s(diagnosis):
    comparison = compare(diagnosis.base)
    shown = failure_map.data(comparison)
    record = diagnosis.base.record
    assert shown.mean.shape == (2, 2, 10)
    rows = (record.inputs.direction > 0) & (record.level == 0.3) & (record.inputs.contraction < 0.02 + 1e-9)
    assert shown.mean[0, 0, 0] == pytest.approx(diagnosis.base.residual[rows].mean())
    assert shown.limit == pytest.approx(np.max(np.abs(comparison.mean)))
    b, p, c = shown.marked[0]
    assert shown.share[b, p, c] == pytest.approx(np.nanmax(comparison.share))
    assert len(shown.marked) == sum(r.share >= 0.01 for r in comparison.worst)


def test_profiles_have_one_entry_a_coordinate_that_varies(diagnosis, table):
    found = {p.key: p for p in profiles.data(compare(diagnosis.base))}
    assert set(found) == {"pressure_MPa", "contraction", "speed_mm_s", "cycle", "time_s"}
    record, residual = diagnosis.base.record, diagnosis.base.residual
    assert found["pressure_MPa"].centre == pytest.approx([0.3, 0.5])
    assert found["pressure_MPa"].rms[1] == pytest.approx(np.sqrt(np.mean(residual[record.level == 0.5] ** 2)))
    assert found["cycle"].mean[0] == pytest.approx(residual[record.inputs.cycle == 1].mean())
    assert found["speed_mm_s"].centre == pytest.approx([4.0, 16.0], rel=0.02)
    assert sum(found["time_s"].n) == len(record)
    flat = profiles.data(compare(fit(Model.build("modified_chou_hannaford"), table)))
    assert [p.key for p in flat] == ["pressure_MPa", "contraction"]


def test_ladder_names_what_each_rung_adds(ladder, diagnosis):
    shown = ladder_figure.data(ladder)
    assert shown.names == ("modified Chou–Hannaford law", "+ Coulomb friction")
    assert shown.rmse == pytest.approx([diagnosis.base.rmse, diagnosis.best.rmse])
    assert list(shown.heldout) == [8.3, 0.55]
    assert shown.noise_floor == 0.5


def test_candidates_put_the_likely_first_and_the_unseen_last(diagnosis):
    shown = candidates.data(diagnosis)
    assert [b.label for b in shown.bars] == [
        "coulomb_friction",
        "creep",
        "viscous_damping:power",
        "force_bias",
        "thermal_softening",
    ]
    assert [b.selected for b in shown.bars] == [True, False, False, False, False]
    assert shown.bars[0].rmse_after == diagnosis.best.rmse
    assert math.isnan(shown.bars[2].heldout)
    assert [b.note for b in shown.bars[3:]] == ["absorbed by the law", "not shown by this record"]
    assert all(math.isnan(b.rmse_after) for b in shown.bars[3:])
    assert shown.before == diagnosis.base.rmse
    assert [b.label for b in candidates.data(diagnosis, limit=1).bars][1:] == ["force_bias", "thermal_softening"]


def test_signature_is_the_change_of_the_model(diagnosis):
    shown = signature.data(diagnosis.base, diagnosis.best)
    assert shown.effect == pytest.approx(diagnosis.best.force - diagnosis.base.force)
    assert shown.before - shown.after == pytest.approx(shown.effect)
    assert shown.axis.startswith("sample in order of time")
    half = shown.window // 2
    assert shown.before_mean[100] == pytest.approx(diagnosis.base.residual[100 - half : 101 + half].mean())
    assert [round(level, 3) for _, _, level in shown.isobars] == [0.3, 0.5]
    assert shown.isobars[0][:2] == (1.0, 328.0)
    assert len(signature.data(diagnosis.base, diagnosis.best, limit=50).x) == 50


def test_no_line_goes_through_a_pause():
    x = np.r_[np.arange(0.0, 10.0, 0.1), np.arange(70.0, 80.0, 0.1)]
    place, line = signature._in_pieces(x, 2.0 * x)
    assert np.flatnonzero(np.isnan(place)).tolist() == np.flatnonzero(np.isnan(line)).tolist() == [100]
    assert place[~np.isnan(place)].tolist() == x.tolist()
    assert len(signature._in_pieces(x[:100], x[:100])[0]) == 100


def test_signature_of_a_table_is_sorted(table):
    one = fit(Model.build("modified_chou_hannaford"), table)
    shown = signature.data(one, one)
    order = np.lexsort((table.inputs.contraction, table.level))
    assert shown.before == pytest.approx(one.residual[order])
    assert shown.effect == pytest.approx(0.0)
    assert shown.window == 1


def test_pattern_by_branch_in_millimetres(diagnosis):
    shown = residual_pattern.data(diagnosis.base, Pattern("local", "contraction", 12.0, "mm", 0.2, ""), bins=8)
    record, residual = diagnosis.base.record, diagnosis.base.residual
    assert [s.branch for s in shown.series] == ["contraction", "extension"]
    assert shown.axis == "contraction (mm)"
    assert shown.marks == (12.0,)
    x = record.inputs.displacement_mm
    part = residual[(record.inputs.direction > 0) & (x > 5 - 1e-9) & (x < 10 - 1e-9)]
    first = shown.series[0]
    assert first.centre[1] == pytest.approx(7.5)
    assert first.n[1] == len(part)
    assert first.mean[1] == pytest.approx(part.mean())
    assert first.error[1] == pytest.approx(part.std(ddof=1) / math.sqrt(len(part)))


def test_pattern_in_time_and_folded(diagnosis):
    record = diagnosis.base.record
    step = residual_pattern.data(diagnosis.base, Pattern("step", "time", 50.0, "s", 0.2, ""))
    assert step.axis == "time (s)"
    assert [s.branch for s in step.series] == ["all"]
    assert sum(step.series[0].n) == len(record)
    ripple = residual_pattern.data(diagnosis.base, Pattern("periodic", "contraction", 10.0, "mm", 0.2, ""))
    assert not ripple.folded
    assert ripple.marks == pytest.approx((10.0, 20.0, 30.0))
    fine = residual_pattern.data(diagnosis.base, Pattern("periodic", "contraction", 1.5, "mm", 0.2, ""))
    assert fine.folded
    assert max(fine.series[0].centre) < 1.5


def test_the_bar_of_what_the_error_follows_fills_its_length_in_the_order_given(diagnosis):
    found = compare(diagnosis.base).follows
    pieces = follows.data(found)
    assert pieces[0].text == "the direction of motion" and pieces[-1].text == "noise"
    assert pieces[0].share == pytest.approx(1.0 - 0.5**2 / diagnosis.base.rmse**2, abs=0.01)
    assert [piece.begin for piece in pieces] == pytest.approx([0.0, pieces[0].share], abs=0.01)
    assert sum(piece.share for piece in pieces) == pytest.approx(1.0, abs=0.01)
    few = follows.data([Follows("map", 0.6, "a"), Follows("way", 0.001, "b"), Follows("noise", 0.399, "c")])
    assert [piece.text for piece in few] == ["a", "c"]
    drivers = {driver.what for driver in DRIVERS}
    assert set(follows.COLOUR) == drivers | {"step", "repeats", "noise"}
    assert len(set(follows.COLOUR.values())) == len(follows.COLOUR)
    assert follows.draw(()).axes  # an answer that nobody split
