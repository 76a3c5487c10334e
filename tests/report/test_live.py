"""The report's figures in a real browser: zoomed into, pointed at, switched; and the pictures where they are not."""

import io
import re

import numpy as np
import pytest
from matplotlib.image import imread

from pam_ident.diagnosis import compare
from pam_ident.report import Section, Story, render

pytestmark = pytest.mark.browser
ENDS = """(k) => {
  const panels = Bokeh.documents[0].roots()[k].children
  return panels.map((one) => [one.x_range.start, one.x_range.end, one.y_range.start, one.y_range.end])
}"""
SEEN = """(k) => Bokeh.documents[0].roots()[k].children.map(
  (one) => one.renderers.filter((part) => part.visible).map((part) => part.name))"""


@pytest.fixture(scope="module")
def file(tmp_path_factory, record, diagnosis):
    """A report of one record, written to disk."""
    path = tmp_path_factory.mktemp("live") / "report.html"
    section = Section(record, compare(diagnosis.base), diagnosis, compare(diagnosis.best))
    path.write_text(render(Story("Live", (section,))), encoding="utf-8")
    return path


@pytest.fixture
def opened(watched, file):
    """The page with its details open and its figures live."""
    watched.set_viewport_size({"width": 1400, "height": 900})
    watched.goto(file.as_uri())
    watched.locator("figure.live").nth(1).wait_for(state="attached")
    watched.locator(".rest > summary").first.click()
    return watched


def live(page, k):
    """A figure, in sight and drawn."""
    found = page.locator("figure.live").nth(k)
    found.scroll_into_view_if_needed()
    page.wait_for_timeout(300)
    return found


@pytest.mark.parametrize("k", [0, 1])
def test_buttons_zoom_and_pan_all_panels_of_a_figure_and_no_other(opened, k):
    figure = live(opened, k)
    first, other = opened.evaluate(ENDS, k), opened.evaluate(ENDS, 1 - k)
    figure.get_by_role("button", name="Zoom in").press("Enter")
    zoomed = opened.evaluate(ENDS, k)
    assert all(one[0] > whole[0] and one[1] < whole[1] for one, whole in zip(zoomed, first, strict=True))
    assert len({tuple(one[:2]) for one in zoomed}) == 1
    figure.get_by_role("button", name="Right").click()
    assert opened.evaluate(ENDS, k)[0][0] > zoomed[0][0]
    figure.get_by_role("button", name="Whole record").click()
    assert opened.evaluate(ENDS, k) == first and opened.evaluate(ENDS, 1 - k) == other


def test_a_frame_that_is_dragged_becomes_the_whole(opened):
    box = live(opened, 0).locator(".panels").bounding_box()
    first = opened.evaluate(ENDS, 0)
    opened.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.15 * box["height"])
    opened.mouse.down()
    opened.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.2 * box["height"], steps=5)
    opened.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 0.3 * box["height"], steps=5)
    opened.mouse.up()
    opened.wait_for_function(f"({ENDS})(0)[0][0] > {first[0][0]}")
    for (low, high, *_), whole in zip(opened.evaluate(ENDS, 0), first, strict=True):
        assert high - low == pytest.approx(0.3 * (whole[1] - whole[0]), rel=0.2)


@pytest.mark.parametrize("k", [0, 1])
def test_a_pointer_reads_measured_model_and_error(opened, k, record):
    box = live(opened, k).locator(".bk-CartesianFrame").first.bounding_box()
    left, right, low, high = opened.evaluate(ENDS, k)[0]
    sample = np.argmax(record.force)
    x, y = (left + right) / 2, high
    if k == 1:
        x, y = record.inputs.contraction[sample], record.force[sample]
    opened.mouse.move(
        box["x"] + (x - left) / (right - left) * box["width"],
        box["y"] + 2 + (high - y) / (high - low) * box["height"],
        steps=3,
    )
    opened.get_by_text("measured:", exact=True).first.wait_for()
    for word in ("model:", "error:", "at:", "time:"):
        assert opened.locator(".bk-Tooltip").get_by_text(word, exact=True).first.is_visible()
    read = opened.locator(".bk-Tooltip:visible").get_by_text(re.compile(r"^[-−]?[\d.]+ N$"))
    measured, model, error = (float(read.nth(j).text_content().split()[0].replace("−", "-")) for j in range(3))
    assert measured - model == pytest.approx(error, abs=0.11)
    assert k == 0 or measured == pytest.approx(record.force[sample], abs=3.0)


def test_isobars_and_traces_are_switched(opened):
    figure = live(opened, 1)
    names = {name for panel in opened.evaluate(SEEN, 1) for name in panel}
    assert names == {"isobar-1", "isobar-2"}
    figure.get_by_label("0.3 MPa").uncheck()
    opened.wait_for_function(f"({SEEN})(1).every((panel) => panel.length && new Set(panel).size === 1)")
    figure.get_by_label("0.3 MPa").check()
    before = len(opened.evaluate(SEEN, 0)[0])
    live(opened, 0).locator(".bk-label", has_text="what is added").click()
    assert len(opened.evaluate(SEEN, 0)[0]) == before - 1


def test_paper_has_the_pictures(opened):
    opened.emulate_media(media="print")
    for figure in opened.locator("figure.live").all():
        assert not figure.locator(".panels").is_visible()
        drawing = figure.locator(".drawing")
        assert drawing.evaluate("(one) => getComputedStyle(one).opacity") == "1"
        assert drawing.locator("svg").bounding_box()["height"] > 200
    assert not opened.get_by_role("button").count()


def test_a_reader_without_a_screen_has_the_pictures_and_tab_passes_the_figures(opened):
    told = opened.locator("main").aria_snapshot()
    assert 'img "Error over the record before and after adding' in told and "canvas" not in told
    opened.locator("figure.live").first.get_by_role("button", name="Whole record").focus()
    opened.keyboard.press("Tab")
    inside = "(one) => one.contains(document.activeElement)"
    assert not opened.locator("figure.live").first.evaluate(inside)


def test_a_narrow_dark_page_holds_the_figures(opened):
    opened.emulate_media(color_scheme="dark")
    opened.set_viewport_size({"width": 500, "height": 900})
    for k in (0, 1):
        box = live(opened, k).locator(".panels").bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= 500 and box["height"] > 250
        inks = opened.evaluate(
            "(k) => Bokeh.documents[0].roots()[k].children.map((one) => one.left[0].major_label_text_color)", k
        )
        assert set(inks) == {"#e6e9ed"}
    opened.wait_for_function("document.documentElement.scrollWidth <= window.innerWidth")


def test_a_figure_that_changes_its_size_leaves_nothing_where_it_was(opened):
    def seen():
        opened.wait_for_timeout(700)
        return imread(io.BytesIO(live(opened, 0).locator(".panels").screenshot()), "png")[..., :3]

    before = seen()
    for width in (1100, 1400):
        opened.set_viewport_size({"width": width, "height": 900})
        after = seen()
    assert np.mean(np.abs(after - before).max(2) > 0.02) < 3e-4


def test_without_scripts_the_pictures_stand(browser, file):
    with browser.new_context(offline=True, java_script_enabled=False) as context:
        page = context.new_page()
        page.goto(file.as_uri())
        page.wait_for_timeout(500)
        assert not page.locator("figure.live").count() and not page.get_by_role("button").count()
        drawing = page.locator(".drawing").first
        assert drawing.evaluate("(one) => getComputedStyle(one).opacity") == "1"
        assert drawing.locator("svg").bounding_box()["width"] > 300
        page.locator(".rest > summary").first.click()
        cells = page.locator("figure", has_text="Mean error (N) in each cell").locator("svg g:has(> title)")
        for cell in (cells.first, cells.last):
            cell.hover()  # fails where anything lies over the cell
            text = page.locator("g:hover > title").last.text_content()
            assert re.search(r"MPa, ε .* mean error [+−0].* N, rms .* of the squared error, n = \d+$", text)
