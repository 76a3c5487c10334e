"""Figures 7 to 10 of the paper from any record: what they would draw, and that they can be drawn."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from pam_ident.core import UsageError
from pam_ident.fitting import fit, fit_isobars
from pam_ident.model import Model
from pam_ident.plot import coefficients, isobars, laws_compared, to_png, to_svg
from pam_ident.tasks.figures import make_folder, paper_figures, write_figures
from pam_ident.tasks.fit import FitOptions, fit_record
from pam_ident.tasks.setup import Setup

BOTH = ("contraction", "extension")


@pytest.fixture(scope="module")
def by_branch(record):
    """Two laws, each fitted to each branch alone."""
    return [
        fit(Model.build(law), record, record.branch_rows(branch))
        for law in ("chou_hannaford", "modified_chou_hannaford")
        for branch in BOTH
    ]


def test_isobars_are_the_record_s_samples_and_their_mean(record):
    curves = isobars.data(record)
    assert [(c.pressure_MPa, c.branch) for c in curves] == [(p, b) for p in (0.3, 0.5) for b in BOTH]
    last, rows = curves[-1], (record.level == 0.5) & (record.inputs.direction == -1.0)
    assert sorted(last.force) == pytest.approx(sorted(record.force[rows]))
    assert np.all(np.diff(last.contraction) >= 0)
    # All samples lie at 41 lengths, four to each: two speeds, two cycles.
    assert last.line == pytest.approx(np.arange(41) / 200.0)
    at = rows & (np.abs(record.inputs.contraction - 0.05) < 1e-9)
    assert at.sum() == 4 and last.line_force[10] == pytest.approx(record.force[at].mean())


@pytest.mark.parametrize("limit", [4, 30, 656])
def test_isobars_stay_below_the_limit_and_cover_the_stroke(record, limit):
    curves = isobars.data(record, limit)
    assert limit / 2 <= sum(len(c.force) for c in curves) <= limit
    if limit > 4:
        assert all(c.contraction.max() > 0.15 for c in curves)


def test_laws_are_compared_on_the_highest_isobar_by_default(by_branch, record):
    panels = laws_compared.data(by_branch)
    assert [(p.pressure_MPa, p.branch) for p in panels] == [(0.5, branch) for branch in BOTH]
    for panel, sign, own in zip(panels, (1.0, -1.0), (by_branch[2], by_branch[3]), strict=True):
        rows = (record.level == 0.5) & (record.inputs.direction == sign)
        assert sorted(panel.measured) == pytest.approx(sorted(record.force[rows]))
        assert [law.label for law in panel.laws] == ["chou_hannaford", "modified_chou_hannaford"]
        assert panel.laws[1].rmse == pytest.approx(np.sqrt(np.mean(own.residual[rows] ** 2)))
        ideal = np.pi * 100.0 * 0.5 * (record.specimen.a * (1 - panel.laws[0].line) ** 2 - record.specimen.b)
        assert panel.laws[0].line_force == pytest.approx(ideal)


def test_laws_are_compared_on_the_isobar_nearest_to_the_one_asked_for(by_branch):
    assert {panel.pressure_MPa for panel in laws_compared.data(by_branch, 0.25)} == {0.3}
    assert [panel.branch for panel in laws_compared.data(by_branch[1::2])] == ["extension"]


def test_a_law_is_told_by_its_effects_and_its_geometry(record):
    def name(*effects, free=False):
        return laws_compared.label(fit(Model.build("chou_hannaford", effects, free_geometry=free), record))

    assert name() == "chou_hannaford" and name("coulomb_friction") == "chou_hannaford + coulomb_friction"
    assert name(free=True) == "chou_hannaford, free geometry"
    assert name("coulomb_friction", "force_bias") == "chou_hannaford + 2 effects"


def test_coefficients_lie_on_the_line_that_scipy_draws(root):
    from scipy.stats import linregress

    record = Setup("sarosi").read(root / "datasets" / "hidden_effect" / "record.csv")
    table = fit_isobars(Model.build("exponential_law"), record, BOTH)
    shown = coefficients.data(table)
    assert [(c.name, c.branch) for c in shown] == [(name, branch) for name in "abc" for branch in BOTH]
    for one in shown:
        assert one.pressure == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5]) and one.unit == "N"
        line = linregress(one.pressure, one.value)
        assert (one.slope, one.intercept, one.r) == pytest.approx((line.slope, line.intercept, line.rvalue))
        assert one.r == pytest.approx(table.correlation[one.branch][one.name])
        assert np.all(one.stderr > 0)


def test_one_isobar_has_no_line(record):
    table = fit_isobars(Model.build("modified_chou_hannaford"), record, ("contraction",))
    one = coefficients.data(type(table)(table.rows[:1], {}, {}))
    assert [c.name for c in one] == ["k0", "k1", "k2"]
    assert all(np.isnan([c.slope, c.intercept, c.r]).all() for c in one)
    to_svg(coefficients.draw(type(table)(table.rows[:1], {}, {})))


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "effects", "branch", "names"),
    [
        ("exponential_law", (), "separate", {"measured_against_model_contraction", "measured_against_model_extension"}),
        ("modified_chou_hannaford", ("coulomb_friction",), "together", {"measured_against_model"}),
        ("sarosi", (), "extension", {"measured_against_model"}),
    ],
)
def test_all_figures_of_a_fit_say_their_units_and_do_not_overlap(record, law, effects, branch, names):
    figures = paper_figures(fit_record(record, Setup(law, effects), FitOptions(branch)))
    assert set(figures) == {"isobars", "laws_compared", "coefficients"} | names
    for figure in figures.values():
        assert ET.fromstring(to_svg(figure)).tag.endswith("svg")
        assert to_png(figure, 40).startswith(b"\x89PNG")
        labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]
        assert labels and all("(" in text for text in labels)
        for axes in figure.axes:
            boxes = [t.get_window_extent() for t in axes.texts if t.get_text().endswith("MPa")]
            assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    for axes in figures["laws_compared"].axes:
        assert not axes.get_legend().get_window_extent().overlaps(axes.patch.get_window_extent())


def test_a_law_without_parameters_has_no_coefficients(table):
    assert "coefficients" not in paper_figures(fit_record(table, Setup("chou_hannaford")))


def test_the_same_law_is_not_drawn_twice(record):
    figures = paper_figures(fit_record(record, Setup("modified_chou_hannaford")))
    (left, _) = figures["laws_compared"].axes
    texts = [text.get_text().split(":")[0] for text in left.get_legend().get_texts()]
    assert texts == ["measured", "chou_hannaford", "modified_chou_hannaford"]


def test_figures_are_written_into_a_folder_that_is_made(record, tmp_path):
    folder = make_folder(tmp_path / "new" / "figures")
    figures = {"isobars": isobars.draw(record)}
    assert write_figures(folder, figures) == [folder / "isobars.svg"]
    assert (folder / "isobars.svg").read_text(encoding="utf-8") == to_svg(isobars.draw(record))
    assert [path.name for path in folder.iterdir()] == ["isobars.svg"]
    with pytest.raises(UsageError, match=r"isobars\.svg: cannot be made a folder"):
        make_folder(folder / "isobars.svg")
