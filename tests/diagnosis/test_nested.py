"""Held-out error with the selection repeated: nothing of the held-out rows is in what predicts them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from pam_ident.cli import app
from pam_ident.core import Param, Specimen, UsageError
from pam_ident.diagnosis import heldout_rmse
from pam_ident.diagnosis.nested import anew, masks_of, nested, usual
from pam_ident.diagnosis.nouns import Ladder, Rung
from pam_ident.effects import AddsForce, Effect
from pam_ident.fitting import fit
from pam_ident.model import Model, Term
from pam_ident.records import build_record, read_record

MUSCLE = Specimen("m", 200.0, 10.0, 25.0, 1.5)
SIGMA = 3.0
LAW = Model.build("polynomial")


def ripple(k):
    """A ripple over displacement that no muscle has."""
    size = Param("A", "N", "amplitude", scale=10.0)
    form = AddsForce(
        "textbook", "ripple", (size,), lambda inputs, shape, force: np.sin(k * inputs.displacement_mm)[:, None]
    )
    return Effect(f"ripple_{k}", "Ripple", "this test", (form,), "-")


RIPPLES = [Term(effect, effect.forms[0]) for effect in (ripple(k) for k in range(1, 40))]


@pytest.fixture(scope="module")
def table():
    """Twelve lengths at six pressures, of a polynomial and noise."""
    e, p = (grid.ravel() for grid in np.meshgrid(np.linspace(0.0, 0.22, 12), np.linspace(0.1, 0.6, 6)))
    noise = SIGMA * np.random.default_rng(3).standard_normal(len(e))
    return build_record("t", MUSCLE, p, e, 1500.0 * p - 5000.0 * p * e - 30.0 + noise)


def best_ripple(record):
    """The law, and the law with that ripple which fits best."""
    fits = [fit(LAW.adding(term), record, detail=False) for term in RIPPLES]
    return [fit(LAW, record, detail=False), min(fits, key=lambda one: one.rmse)]


def in_time(levels=(0.1, 0.3)):
    """Four cycles at each pressure."""
    t = np.arange(400) * 0.05
    x = 20.0 * (1.0 - np.cos(2.0 * np.pi * t / 5.0))
    time = np.concatenate([t + 100.0 * k for k in range(len(levels))])
    x, p = np.tile(x, len(levels)), np.repeat(levels, len(t))
    return build_record("r", MUSCLE, p, x / 200.0, 1500.0 * p - x, time=time)


def test_a_choice_that_has_seen_the_held_out_rows_looks_better_than_it_is(table):
    masks = masks_of(table, "length")
    chosen = best_ripple(table)[1].model
    refitted = heldout_rmse(chosen, table, masks=masks)
    law, honest = anew(table, masks, best_ripple, 2)
    assert refitted < law < honest
    assert law == pytest.approx(heldout_rmse(LAW, table, masks=masks), rel=1e-6)


def test_the_ladder_ends_where_nothing_predicts_better_and_says_so(table):
    fits = best_ripple(table)
    rungs = tuple(Rung(one, heldout_rmse(one.model, table), "") for one in fits)
    found = nested(Ladder(rungs, SIGMA, "top"), best_ripple, lambda model: model)
    assert [rung.effects for rung in found.rungs] == [()] and found.last == LAW
    assert found.nested.by == "length" and found.nested.parts == 5
    assert f"({fits[1].model.labels[0]}) would make it" in found.nested.text and "is left out" in found.nested.text
    assert found.rungs[0].refit_rmse == rungs[0].heldout_rmse


def test_what_predicts_better_stays_and_a_better_law_is_recommended(table):
    poor = Model.build("chou_hannaford")
    term = Term(RIPPLES[0].effect, RIPPLES[0].form)
    force = table.force + 400.0 * np.sin(table.inputs.displacement_mm)
    rippled = replace(table, force=force)

    def again(part):
        return [fit(poor, part, detail=False), fit(poor.adding(term), part, detail=False)]

    rungs = tuple(Rung(one, heldout_rmse(one.model, rippled), "") for one in again(rippled))
    found = nested(Ladder(rungs, SIGMA, "top"), again, lambda model: model)
    assert len(found.rungs) == 2 and found.last == "top"
    best, (count, error) = next(iter(found.nested.beside.items()))
    assert list(found.nested.beside.values()) == sorted(found.nested.beside.values(), key=lambda one: one[1])
    assert error < found.rungs[1].heldout_rmse / 1.05
    assert f"({best}) alone, with {count} parameters, predicts better" in found.nested.text
    assert "mean over pressure" in found.nested.beside and "chou_hannaford" not in found.nested.beside


def test_where_the_choice_of_a_law_is_what_errs_it_says_so(table):
    poor = Model.build("chou_hannaford")
    rung = Rung(fit(LAW, table), heldout_rmse(LAW, table), "")
    found = nested(Ladder((rung,), SIGMA, "top"), lambda part: [fit(poor, part, detail=False)], lambda model: model)
    error = found.nested.beside[LAW.law.name][1]
    assert error < found.rungs[0].heldout_rmse and error == min(one[1] for one in found.nested.beside.values())
    assert "What errs is the choice of a law" in found.nested.text and "take that one" not in found.nested.text


def test_no_pressure_is_held_out_without_which_one_is_left():
    with pytest.raises(UsageError, match="one pressure is left"):
        masks_of(in_time((0.1, 0.3)), "pressure")
    assert len(masks_of(in_time((0.1, 0.3, 0.5)), "pressure")) == 3


def test_each_block_is_held_out_once_and_whole(table):
    record = in_time((0.1, 0.3, 0.5))
    for one, by, block, parts in (
        (table, "length", table.inputs.contraction, 5),
        (table, "pressure", table.level, 5),
        (record, "pressure", record.level, 3),
        (record, "cycle", record.block, 5),
        (record, "length", np.digitize(record.inputs.contraction, [0.04, 0.08, 0.12, 0.16]), 5),
    ):
        masks = masks_of(one, by)
        assert len(masks) == parts and np.all(np.sum(masks, axis=0) == 1)
        for b in np.unique(block):
            assert sum(bool(mask[block == b].any()) for mask in masks) == 1


def test_locked_lengths_that_creep_are_one_length_each():
    p = np.tile(np.linspace(0.05, 0.5, 100), 3)  # up and up again
    e = np.repeat([0.0, 0.05, 0.1], 100) + 0.001 * p
    record = build_record("r", MUSCLE, p, e, 1000.0 * p, time=np.arange(300.0), said_kind="isometric")
    assert len(masks_of(record, "length")) == 3


def test_what_suits_the_kind_of_test_is_held_out(table):
    assert usual(table) == "length"
    assert usual(in_time()) == "cycle"
    assert usual(replace(in_time(), said_kind="isometric")) == "length"


@pytest.mark.parametrize("by", ["run", "muscle", "cycle"])
def test_what_a_record_has_not_two_of_cannot_be_held_out(table, by):
    with pytest.raises(UsageError, match=f"{by}.*less than two"):
        masks_of(table, by)


def test_runs_and_muscles_of_a_folder_are_held_out(tmp_path):
    (tmp_path / "specimen.toml").write_text(
        '[specimen]\nname = "m"\ninitial_length_mm = 200\ninitial_radius_mm = 10\nbraid_angle_deg = 25\n'
    )
    (tmp_path / "columns.toml").write_text(
        '[runs."a.csv"]\ninitial_length_mm = 200\n[runs."b.csv"]\ninitial_length_mm = 250\n'
        '[runs."c.csv"]\ninitial_length_mm = 250\n'
    )
    for name in "abc":
        rows = [f"{k},{0.1 + 0.01 * k},{k % 7},{100 + 13 * k}" for k in range(30)]
        (tmp_path / f"{name}.csv").write_text("time_s,pressure_MPa,displacement_mm,force_N\n" + "\n".join(rows) + "\n")
    record = read_record(tmp_path)
    assert [int(mask.sum()) for mask in masks_of(record, "run")] == [30, 30, 30]
    assert [int(mask.sum()) for mask in masks_of(record, "muscle")] == [30, 60]
    assert len(masks_of(record.take(np.arange(45)), "run")) == 2


def test_an_unknown_word_ends_before_anything_is_read():
    result = CliRunner().invoke(app, ["ladder", "nowhere.csv", "--heldout", "colour"])
    assert result.exit_code == 2 and "length, pressure, run, cycle, muscle" in " ".join(result.stderr.split())


@pytest.mark.long
def test_the_ladder_of_the_measured_map_says_that_a_law_alone_predicts_better(tmp_path):
    out = tmp_path / "ladder.json"
    words = ["ladder", "dmsp20_300", "--law", "chou_hannaford", "--free-geometry", "--json", str(out)]
    result = CliRunner().invoke(app, words)
    found = json.loads(out.read_text())
    last = found["rungs"][-1]
    assert result.exit_code == 0 and found["heldout"] == "nested" and found["nested"]["by"] == "length"
    assert last["heldout_rmse_N"] > 1.5 * last["refit_rmse_N"]
    best = found["nested"]["beside"][0]
    assert best["law"] == "martens_boblan" and best["heldout_rmse_N"] < 0.7 * last["heldout_rmse_N"]
    assert "take that one" in found["nested"]["text"] and found["nested"]["text"] in " ".join(result.output.split())
