"""Figures of a notebook's cells in a real browser: zoomed into where a kernel asked for them, pictures elsewhere."""

import re
from types import SimpleNamespace

import pytest

from pam_ident.diagnosis import compare
from pam_ident.notebook import live

LARGE = 400_000
"""Letters that only Bokeh has."""


@pytest.fixture
def kernel(monkeypatch):
    """A kernel of Jupyter that runs one cell after another; a cell is run by its name."""
    pytest.importorskip("bokeh")
    parent = {"metadata": {}}
    shell = SimpleNamespace(kernel=None, execution_count=0, get_parent=lambda: parent)
    monkeypatch.setattr(live, "_kernel", lambda: shell)
    monkeypatch.setattr(live, "_brought", None)

    def run(cell):
        shell.execution_count += 1
        parent["metadata"] = {"cellId": cell} if cell else {}

    return run


@pytest.fixture
def html(kernel, shown, diagnosis):
    """What three cells show."""
    found = []
    for result in (diagnosis.best, diagnosis, compare(diagnosis.base)):
        kernel(None)
        found.append(shown(result)["text/html"])
    return found


@pytest.mark.long
def test_one_cell_brings_bokeh_for_all_and_again_when_it_is_run_again(kernel, shown, diagnosis):
    told = []
    for cell in ("a", "b", "a", None):
        kernel(cell)
        twice = [shown(diagnosis)["text/html"] for _ in range(2)]
        told.append([len(one) > LARGE for one in twice])
    assert told == [[True, False], [False, False], [True, False], [False, False]]


@pytest.mark.long
def test_outside_of_a_kernel_and_without_bokeh_there_is_no_script(kernel, shown, diagnosis, monkeypatch):
    monkeypatch.setattr(live, "available", lambda: False)
    assert "<script" not in shown(diagnosis)["text/html"]
    monkeypatch.undo()
    assert "<script" not in shown(diagnosis)["text/html"]


@pytest.mark.browser
def test_cells_hold_figures_to_zoom_and_to_point_at(page, html, tmp_path):
    path, complaints, asked = tmp_path / "notebook.html", [], []
    path.write_text("<!DOCTYPE html><meta charset=utf-8>" + "<hr>".join(html), encoding="utf-8")
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.set_viewport_size({"width": 900, "height": 700})
    page.goto(path.as_uri())
    figures = page.locator("figure.pam-figure.live")
    figures.nth(2).wait_for(state="attached")
    assert [one.get_by_role("button").count() for one in figures.all()] == [5, 5, 0]
    for one in figures.all():
        one.scroll_into_view_if_needed()
        assert one.locator("canvas").first.bounding_box()["width"] > 500
        assert one.locator(".drawing").evaluate("(one) => getComputedStyle(one).opacity") == "0"
    end = (
        "async () => (await pamIdentBokeh).documents.flatMap((one) => one.roots())"
        ".reduce((sum, one) => sum + one.children[0].x_range.end, 0)"
    )
    before = page.evaluate(end)
    figures.nth(1).get_by_role("button", name="Zoom in").click()
    assert page.evaluate(end) < before
    frame = figures.nth(1).locator(".bk-CartesianFrame").first.bounding_box()
    page.mouse.move(frame["x"] + frame["width"] / 2, frame["y"] + frame["height"] / 2, steps=3)
    page.locator(".bk-Tooltip:visible").get_by_text("measured:", exact=True).wait_for()
    assert page.evaluate("typeof Bokeh") == "undefined", "Panel in a later cell would take it for its own, and wait"
    assert complaints == [] and [one for one in asked if not one.startswith("data:")] == [path.as_uri()]
    page.emulate_media(media="print")
    assert figures.first.locator(".drawing").evaluate("(one) => getComputedStyle(one).opacity") == "1"


@pytest.mark.browser
def test_where_the_cell_with_bokeh_is_gone_or_scripts_do_not_run_the_pictures_stand(browser, html, tmp_path):
    for cells, scripts in ((html[1:], True), (html, False)):
        path = tmp_path / "notebook.html"
        path.write_text("<!DOCTYPE html><meta charset=utf-8>" + "".join(cells), encoding="utf-8")
        with browser.new_context(offline=True, java_script_enabled=scripts) as context:
            page = context.new_page()
            page.goto(path.as_uri())
            page.wait_for_timeout(500)
            assert not page.locator("figure.live").count()
            for drawing in page.locator(".pam-figure .drawing").all():
                assert drawing.evaluate("(one) => getComputedStyle(one).opacity") == "1"
                assert drawing.locator("img").bounding_box()["width"] > 300
    assert all(re.search(r"<script>(?!.*https?://)", one, re.S) for one in html[1:]), "nothing is loaded"
