"""Where a model fails is counted right."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import compare, heldout_rmse
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record

SPECIMEN = Specimen("bench", 200.0, 10.0, 25.4, 1.5)
MODEL = Model.build("modified_chou_hannaford")


def motion(extra):
    """Two isobars, four cycles each, of the ideal braid plus `extra(direction, e, p)` N."""
    time = np.linspace(0.0, 160.0, 3201)
    p = np.where(time < 80.0, 0.2, 0.4)
    e = 0.1 - 0.1 * np.cos(2.0 * np.pi * time / 20.0)
    clean = build_record("loop", SPECIMEN, p, e, np.zeros_like(e), time=time)
    ideal = np.pi * 100.0 * p * (SPECIMEN.a * (1.0 - e) ** 2 - SPECIMEN.b)
    return replace(clean, force=ideal + extra(clean.inputs.direction, e, p))


def test_friction_is_all_odd_and_the_shares_sum_to_one():
    result = compare(fit(MODEL, motion(lambda d, e, p: -10.0 * d)))
    assert result.odd == pytest.approx(1.0, abs=0.02) and result.even < 0.02
    assert np.nansum(result.share) == pytest.approx(1.0)
    for bins in result.by.values():
        assert sum(b.share for b in bins) == pytest.approx(1.0)
    assert "changes sign with the branch" in result.sentence


def test_friction_is_odd_where_the_drive_is_slower_one_way():
    time = np.linspace(0.0, 160.0, 3201)
    part = time % 20.0
    e = 0.2 * np.where(part < 5.0, part / 5.0, 1.0 - (part - 5.0) / 15.0)
    p = np.where(time < 80.0, 0.2, 0.4)
    clean = build_record("loop", SPECIMEN, p, e, np.zeros_like(e), time=time)
    ideal = np.pi * 100.0 * p * (SPECIMEN.a * (1.0 - e) ** 2 - SPECIMEN.b)
    found = compare(fit(MODEL, replace(clean, force=ideal - 10.0 * clean.inputs.direction)))
    assert found.odd == pytest.approx(0.8, abs=0.01) and found.odd + found.even > 0.99  # of + 7.5 and − 2.5 N


def test_a_bump_is_even_and_found_in_its_place():
    bump = 20.0
    result = compare(fit(MODEL, motion(lambda d, e, p: bump * (p > 0.3) * np.exp(-(((e - 0.15) / 0.01) ** 2)))))
    assert result.even > 0.7 and result.odd < 0.02
    top = result.worst[0]
    assert top.pressure_MPa == 0.4 and top.contraction[0] <= 0.15 <= top.contraction[1] + 0.02


def test_held_out_error_is_that_of_predicting_each_fold():
    rng = np.random.default_rng(8)
    record = motion(lambda d, e, p: rng.standard_normal(len(e)))
    blocks = np.unique(record.block)
    ends = np.isin(record.block, blocks[[0, -1]])  # are never held out
    square = np.sum(fit(MODEL, record).residual[ends] ** 2)
    for k in range(5):
        out = np.isin(record.block, blocks[1:-1][k::5])
        part = fit(MODEL, record, ~out)
        square += np.sum(part.residual[out] ** 2)
    assert heldout_rmse(MODEL, record) == pytest.approx(np.sqrt(square / len(record)), rel=1e-4)
