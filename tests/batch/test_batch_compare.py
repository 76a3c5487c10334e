"""What the page says of many muscles, against figures worked out by hand."""

import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pam_ident.batch.compare import spreads, trends
from pam_ident.batch.run import run_batch
from pam_ident.parallel.executor import Executor
from pam_ident.plot import batch_spread, batch_trend, to_svg
from pam_ident.tasks.setup import Setup

sys.path.insert(0, str(Path(__file__).parent))
from batch_tree import frame, write_tree

UNITS = {"k": "N", "k_stderr": "N"}


def made(k, length, **more):
    """A table of one parameter k over muscles of some length."""
    n = len(k)
    columns = {
        "record": [f"r{i:02d}" for i in range(n)],
        "branch": ["together"] * n,
        "rmse_N": np.ones(n),
        "k": k,
        "k_stderr": np.full(n, 0.5),
        "error": [None] * n,
        "specimen_initial_length_mm": length,
        "specimen_diameter_mm": np.full(n, 20.0),
        "specimen_serial_number": np.full(n, np.nan),
    }
    return pd.DataFrame(columns | more)


def test_median_width_and_outliers():
    # Deviations from the median 5 are 4 3 2 1 0 1 2 3 95: their median is 2, so 3.5 · 1.4826 · 2 = 10.4.
    table = made(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 100.0]), np.full(9, 200.0))
    rmse, k = spreads(table, UNITS)
    assert (k.quantity, k.unit, k.median, k.width) == ("k", "N", 5.0, pytest.approx(2.9652))
    assert list(k.records[k.outlier]) == ["r08"] and k.stderr_median == 0.5
    assert rmse.quantity == "rmse_N" and not rmse.outlier.any() and np.isnan(rmse.stderr_median)


def test_rows_with_an_error_take_no_part_and_few_muscles_have_no_outliers():
    k = np.array([1.0, 1.1, 0.9, 50.0, 1.0])
    found = spreads(made(k, np.full(5, 200.0), error=[None, None, None, None, "bad"]), UNITS)[1]
    assert len(found.value) == 4 and not found.outlier.any()


def test_a_trend_is_the_line_of_theil_and_sen_with_holms_correction():
    length = np.array([100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0])
    k = 3.0 + 0.02 * length
    k[4] += 40.0  # an outlier, which a least-squares line would follow
    table = made(k, length, rmse_N=np.array([1.0, 1.2, 0.9, 1.1, 1.0, 0.8, 1.3, 1.05]))
    first, second = trends(table, spreads(table, UNITS))
    assert first.spread.quantity == "k" and first.over == "length (mm)"
    assert (first.slope, first.intercept) == (pytest.approx(0.02), pytest.approx(3.0, abs=0.6))
    # Ranks: the fifth of eight moves to the top, so Σd² = 3² + 3 · 1² and ρ = 1 − 6 · 12 / (8 · 63).
    assert first.correlation == pytest.approx(1.0 - 6.0 * 12.0 / 504.0)
    assert first.p_all == pytest.approx(2.0 * first.p) and second.p_all == pytest.approx(second.p)
    assert first.p < second.p and not second.found


def test_what_all_muscles_share_and_what_is_unknown_makes_no_trend():
    table = made(np.arange(6.0), np.full(6, 200.0))
    assert trends(table, spreads(table, UNITS)) == ()


@pytest.mark.long
def test_a_planted_trend_and_an_odd_muscle_are_named_on_the_page(tmp_path):
    tree = write_tree(tmp_path / "tree", 15)
    path = tree / "muscle07" / "run.csv"
    rows = pd.read_csv(path)
    rows["force_N"] *= 1.2
    rows.to_csv(path, index=False)
    found = run_batch(tree, Setup("exponential_law"), tmp_path / "out", executor=Executor.of_cores(2))
    table = frame(found.folder)
    a1 = next(t for t in trends(table, spreads(table, table.attrs["units"])) if t.found)
    assert (a1.spread.quantity, a1.over) == ("a1", "length (mm)") and a1.slope == pytest.approx(5.0, rel=0.2)
    odd = {s.quantity: list(s.records[s.outlier]) for s in spreads(table, table.attrs["units"])}
    assert odd["c1"] == ["muscle07/run.csv"]
    page = found.page.read_text(encoding="utf-8")
    assert page.count("<figure ") == 2 and "muscle07/run.csv" in page and "follows it" in page
    assert len(re.findall(r'<th scope="row" id="m\d+">muscle\d\d/run.csv</th>', page)) == 15, "every muscle is listed"
    assert re.search(r'<a href="#m\d+">muscle07/run.csv</a>', page), "and linked where it is named"
    assert "<script" not in page and "src=" not in page and 'href="http' not in page


def test_figures_show_every_outlier_and_at_most_so_many_points():
    rng = np.random.default_rng(1)
    value, outlier = rng.normal(size=2000), np.zeros(2000, bool)
    outlier[[17, 1300]] = True
    panel = batch_spread.data("k", "N", value, np.full(2000, 0.1), outlier, limit=100)
    assert 100 <= len(panel.value) <= 102 and panel.outlier.sum() == 2
    assert np.all(np.diff(panel.value) >= 0) and panel.share[0] == pytest.approx(0.5 / 2000)
    points = batch_trend.data("k (N)", "length (mm)", "ρ 0", np.arange(2000.0), value, outlier, (2.0, 1.0), limit=100)
    assert points.outlier.sum() == 2 and list(points.line_y) == [1.0, 1.0 + 2.0 * 1999.0]
    assert "length (mm)" in to_svg(batch_trend.draw([points])) and "k (N)" in to_svg(batch_spread.draw([panel]))
