"""The ladder told rung by rung, and the map's numbers under the pointer and in a table."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from pam_ident.diagnosis.compare import compare
from pam_ident.diagnosis.nouns import Ladder, Rung
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.plot import failure_map, to_svg
from pam_ident.report import Section, Story, render, tables
from pam_ident.report.easel import Easel
from pam_ident.report.rungs import steps
from pam_ident.report.svg import inline

LAW = "modified_chou_hannaford"


@pytest.fixture(scope="module")
def tall(record, diagnosis):
    """Three rungs, the last one an effect that is not there."""
    third = fit(Model.build(LAW, ("coulomb_friction", "viscous_damping")), record)
    rungs = (
        Rung(diagnosis.base, 8.3, "the law alone"),
        Rung(diagnosis.best, 0.55, "halves the error", diagnosis),
        Rung(third, 0.54, "a little"),
    )
    return Ladder(rungs, 0.5, diagnosis)


def test_each_rung_tells_the_errors_before_and_after_and_what_convinced(tall, diagnosis):
    found = steps(tall, Easel("x", 400))
    assert [name for name, _ in found] == [
        "0: modified Chou–Hannaford law",
        "1: + Coulomb friction",
        "2: + viscous damping",
    ]
    first, second, third = (part for _, part in found)
    assert dict(first.facts)["held-out error"] == "8.30 N rms" and first.pictures == ()
    facts = dict(second.facts)
    base, best = diagnosis.base.rmse, diagnosis.best.rmse
    assert facts["error"] == f"{base:.2f} N → {best:.3f} N rms"
    assert facts["held-out error"] == "8.30 N → 0.550 N rms"
    assert facts["explained of the squared error"] == "> 99 %" and 0.99 < 1 - (best / base) ** 2 < 1
    assert facts["probability of Coulomb friction"] == "97 %"
    assert facts["free parameters"] == "3 → 4"
    assert second.text == (f"Why it was added: {diagnosis.sentence}",)
    assert second.heading == "Step 1: + Coulomb friction (coulomb_friction)"
    assert third.text == ("Why it was added: a little",) and "probability of viscous damping" not in dict(third.facts)


def test_a_rung_shows_what_it_adds_through_what_the_rung_below_leaves(tall, diagnosis):
    _, third = (part.pictures[0] for _, part in steps(tall, Easel("x", 400))[1:])
    top, low = third.figure.axes
    lines = {line.get_label(): line.get_ydata() for line in top.lines}
    below, above = tall.rungs[1].fit, tall.rungs[2].fit
    trace = lines["what is added"]
    assert len(trace) == 100
    assert trace[[0, -1]] == pytest.approx((above.force - below.force)[[0, -1]])
    assert low.get_title(loc="left").startswith("After adding viscous damping: ")


@pytest.mark.long
def test_a_page_holds_a_choice_and_a_panel_a_rung(tall, record, diagnosis):
    page = render(Story("x", (Section(record, compare(diagnosis.base), diagnosis, ladder=tall),)))
    choices = re.findall(r'<input type="radio" name="([^"]+)" id="([^"]+)"( checked)?><label for="([^"]+)"', page)
    assert [c[2] for c in choices] == [" checked", "", ""] and len({c[0] for c in choices}) == 1
    assert all(c[1] == c[3] and f'<h4 id="{c[1].removesuffix("-choice")}">' in page for c in choices)
    rules = re.findall(r"> :nth-of-type\((\d)\) > :checked\) > section:nth-of-type\((\d)\)", page)
    assert rules == [("1", "1"), ("2", "2"), ("3", "3")]
    bare = render(Story("x", (Section(record, compare(diagnosis.base), diagnosis),)))
    assert 'type="radio"' not in bare and "> :checked) > section" not in bare


def test_the_cells_of_the_map_hold_every_sample_once(diagnosis):
    comparison = compare(diagnosis.base)
    found = failure_map.cells(failure_map.data(comparison))
    one = diagnosis.base
    assert sum(cell.n for cell in found) == len(one.record)
    assert sum(cell.share for cell in found) == pytest.approx(1.0)
    for cell in found:  # the share of the squares is n times the mean square
        assert cell.share * np.sum(one.residual**2) == pytest.approx(cell.n * cell.rms**2)
    record = one.record
    low, high = found[0].contraction
    rows = (record.inputs.direction > 0) & (record.level == 0.5) & (record.inputs.contraction < high)
    assert (found[0].branch, found[0].pressure_MPa, found[0].n) == ("contraction", 0.5, rows.sum())
    assert found[0].mean == pytest.approx(one.residual[rows].mean())
    assert found[0].text.startswith(f"contraction, 0.5 MPa, ε {low:.4g} to {high:.4g}: mean error −")
    assert found[0].text.endswith(f"n = {rows.sum()}")


def test_a_cell_s_numbers_appear_where_the_pointer_rests_on_it_and_in_the_table(table):
    comparison = compare(fit(Model.build(LAW), table))
    found = failure_map.cells(failure_map.data(comparison))
    assert len(found) == 15 and all(cell.n == 1 for cell in found)
    svg = inline(to_svg(failure_map.draw(comparison)), "x", "map", {cell.gid: cell.text for cell in found})
    titles = [e.text for e in ET.fromstring(svg).iter("title")]
    assert sorted(titles) == sorted(cell.text for cell in found)
    shown = tables.cells(found)
    assert shown.folded and len(shown.rows) == 15
    assert shown.rows[0][:4] == (
        "0.600",
        " to ".join(f"{e:.4f}" for e in found[0].contraction).replace("-", "−"),
        "–",
        "1",
    )
    assert all(len(row) == len(shown.head) for row in shown.rows)


def test_tips_are_text():
    svg = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><g id="a"><path d="M 0 0"/></g></svg>'
    found = inline(svg, "x", "label", {"a": "<b>\u202e&"})
    assert '<g pointer-events="all"><title>&lt;b&gt;\ufffd&amp;</title><path' in found


def test_parameters_that_are_told_elsewhere_are_not_told_again(tall):
    whole = [part.tables for _, part in steps(tall, Easel("x", 400))]
    assert all(whole)
    told = [tall.rungs[0].fit, tall.rungs[-1].fit]
    assert [part.tables for _, part in steps(tall, Easel("x", 400), told)] == [(), *whole[1:-1], ()]
