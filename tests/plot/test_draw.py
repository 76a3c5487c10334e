"""Every figure can be drawn without a warning, says its units, and leaves matplotlib as it was."""

from dataclasses import replace

import pytest

from pam_ident import plot
from pam_ident.diagnosis.compare import compare
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.plot.style import running_mean, signed, spread, thin


def test_the_same_figure_gives_the_same_file(diagnosis):
    assert plot.to_svg(plot.candidates.draw(diagnosis)) == plot.to_svg(plot.candidates.draw(diagnosis))


@pytest.mark.long
def test_tables_and_odd_texts_can_be_drawn(table, diagnosis):
    one = fit(Model.build("modified_chou_hannaford"), table)
    plot.to_svg(plot.measured_against_model.draw(one))
    plot.to_svg(plot.failure_map.draw(compare(one)))
    plot.to_svg(plot.signature.draw(one, one))
    odd = replace(diagnosis.ranking[0], label="$x_{ <b>")
    svg = plot.to_svg(plot.candidates.draw(replace(diagnosis, ranking=(odd,))))
    assert "$x_{ &lt;b&gt;" in svg
    plot.to_svg(plot.candidates.draw(replace(diagnosis, ranking=())))


def test_a_held_out_error_beyond_all_measure_leaves_the_bars_their_scale(diagnosis):
    odd = replace(diagnosis.ranking[0], heldout_rmse_after=1.63e9)
    figure = plot.candidates.draw(replace(diagnosis, ranking=(odd, *diagnosis.ranking[1:])))
    assert figure.axes[0].get_xlim()[1] < 2.1 * diagnosis.base.rmse
    assert "over a million N →" in [text.get_text() for text in figure.axes[0].texts]


def test_isobar_labels_do_not_overlap(diagnosis):
    figure = plot.measured_against_model.draw(diagnosis.base)
    plot.to_png(figure, 72)
    axes = figure.axes[0]
    boxes = [t.get_window_extent() for t in axes.texts if t.get_text().endswith("MPa")]
    assert len(boxes) == 2
    assert not boxes[0].overlaps(boxes[1])


def test_helpers():
    assert list(thin(5, 10)) == [0, 1, 2, 3, 4]
    assert list(thin(101, 3)) == [0, 50, 100]
    assert list(running_mean(thin(5, 5).astype(float), 3)) == [0.5, 1.0, 2.0, 3.0, 3.5]
    moved = spread(thin(3, 3) * 0.0, 2.0)
    assert sorted(moved) == pytest.approx([-2.0, 0.0, 2.0], abs=1e-6)
    assert [signed(v) for v in (12.34, -1.26, 0.123, 0.001)] == ["+12", "−1.3", "+0.12", "0"]
