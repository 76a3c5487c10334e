"""The report in a real browser, opened as a file: the whole story clicked through, and the page asks for nothing."""

import io
import json
import re
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.image import imread

from pam_ident.core.digits import newtons
from pam_ident.diagnosis import compare
from pam_ident.diagnosis.against import against
from pam_ident.diagnosis.nouns import Ladder, Rung
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.plot import failure_map
from pam_ident.report import Section, Story, render
from pam_ident.report.against import render_against

pytestmark = pytest.mark.browser
LAW = "modified_chou_hannaford"


@pytest.fixture(scope="module")
def file(tmp_path_factory, record, diagnosis):
    """A report of two records, the first with a ladder of three rungs, written to disk."""
    third = fit(Model.build(LAW, ("coulomb_friction", "viscous_damping")), record)
    rungs = (Rung(diagnosis.base, 8.3, "alone"), Rung(diagnosis.best, 0.55, "halves it"), Rung(third, 0.54, "a bit"))
    found = Section(record, compare(diagnosis.base), diagnosis, compare(diagnosis.best), Ladder(rungs, 0.5, diagnosis))
    path = tmp_path_factory.mktemp("browser") / "report.html"
    story = Story("Browser", (found, found), {"date (UTC)": "2026-01-02", "command": "pam-ident report"})
    path.write_text(render(story), encoding="utf-8")
    return path


@pytest.fixture
def opened(watched, file):
    """The page, opened."""
    watched.emulate_media(reduced_motion="reduce")
    watched.goto(file.as_uri())
    watched.locator("figure.live").nth(9).wait_for(state="attached")
    assert not watched.locator("details[open]").count()
    return watched


@pytest.fixture
def unfolded(opened):
    """The page with its details and its contents open."""
    for summary in opened.locator(".rest > summary").all():
        summary.click()
    return opened


def shown(page):
    """Headings of the rungs in view in the first record."""
    return [h.text_content() for h in page.locator(".steps").first.locator("h4").all() if h.is_visible()]


@pytest.mark.parametrize("width", [1400, 500])
def test_it_opens_with_the_answer_and_nothing_else(opened, width):
    """The first screen: what is missing, its trace before and after; nothing is cut at either width."""
    opened.set_viewport_size({"width": width, "height": 900})
    assert opened.get_by_role("heading", name="Missing: Coulomb friction or friction").first.is_visible()
    figures = opened.locator(".first").first.locator("figure svg")
    assert figures.count() == 3
    inside = 3 if width == 1400 else 1
    for k in range(3):
        box = figures.nth(k).bounding_box()
        assert box["width"] > 300 and box["x"] >= 0 and box["x"] + box["width"] <= width
        assert k >= inside or box["y"] + box["height"] <= 900
        sizes = figures.nth(k).evaluate(
            "one => [...one.querySelectorAll('text')].map(t => t.getBoundingClientRect().height)"
        )
        assert min(sizes) > 8.0
    sure = opened.get_by_text("How sure: ").first.bounding_box()
    assert width < 1400 or sure["y"] + sure["height"] <= 900
    told = opened.locator(".opening").first.locator("h3, .lead, figcaption").all_inner_texts()
    assert len(told) > 3 and not any("_" in one for one in told), "no names of the code"
    assert opened.evaluate("document.documentElement.scrollHeight") < 6000, "the details are folded"
    opened.wait_for_function("document.documentElement.scrollWidth <= window.innerWidth")


def test_it_unfolds_every_figure_and_part(unfolded, diagnosis):
    opened = unfolded
    assert opened.title() and opened.locator("h1").count() == 1
    assert opened.get_by_text(diagnosis.sentence).first.is_visible()
    figures = opened.locator("figure svg:visible, figure img:visible")
    assert figures.count() >= 10
    for k in range(figures.count()):
        box = figures.nth(k).bounding_box()
        assert box is not None and box["width"] > 200 and box["height"] > 80
    opened.wait_for_function("document.documentElement.scrollWidth <= window.innerWidth")
    for link in opened.locator("nav a").all():
        link.click()
        assert opened.locator(f"[id='{opened.url.partition('#')[2]}']").is_visible()


OPENED = "document.querySelectorAll('details').forEach(one => one.open = true)"
CUT = """(drawing) => {
  const whole = drawing.getBoundingClientRect()
  const beyond = (one) => one.left < whole.left - 1 || one.right > whole.right + 1
  const boxes = [...drawing.querySelectorAll("svg, img, text")].map((one) => one.getBoundingClientRect())
  return drawing.scrollWidth - drawing.clientWidth > 1 || boxes.some((one) => one.width && beyond(one))
}"""


def test_at_500_px_no_figure_of_any_fold_or_rung_is_cut_or_scrolls(opened):
    opened.set_viewport_size({"width": 500, "height": 900})
    opened.evaluate(OPENED)
    for rung in opened.locator(".steps").first.get_by_role("radio").all():
        rung.click()
        opened.wait_for_function("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
        drawings = [one for one in opened.locator(".drawing").all() if one.is_visible()]
        assert len(drawings) >= 10 and [one.get_attribute("aria-label") for one in drawings if one.evaluate(CUT)] == []


def test_the_rungs_are_stepped_through_by_mouse_and_by_keyboard(unfolded):
    opened = unfolded
    choice = opened.locator(".steps fieldset").first.get_by_role("radio")
    assert choice.count() == 3
    names = ["Step 0", "Step 1: + Coulomb friction", "Step 2: + viscous damping"]
    for k in (1, 2, 0):
        choice.nth(k).click()
        (head,) = shown(opened)
        assert head.startswith(names[k])
    opened.keyboard.press("ArrowRight")
    assert shown(opened)[0].startswith(names[1])
    ring = "getComputedStyle(document.querySelector('fieldset :focus-visible + label')).outlineStyle"
    assert opened.evaluate(ring) == "solid"
    opened.keyboard.press("ArrowDown")
    opened.keyboard.press("ArrowDown")
    assert shown(opened)[0].startswith(names[0])
    other = opened.locator(".steps").nth(1).locator("h4:visible")
    assert other.count() == 1 and "Step 0" in other.text_content()


def test_a_rung_is_zoomed_into_and_pointed_at_and_is_one_of_its_own(unfolded):
    unfolded.get_by_role("radio").nth(2).click()
    figure = unfolded.locator(".steps").first.locator("figure.live:visible")
    assert figure.count() == 1 and figure.locator(".bk-Figure").count() == 2
    words = figure.locator(".bk-label").all_text_contents()
    assert [one for one in words if one.startswith("error before: 0.")], "before is the step below, not the law"
    ends = "Bokeh.documents[0].roots().map((one) => one.children[0].x_range.end)"
    before = unfolded.evaluate(ends)
    figure.get_by_role("button", name="Zoom in").press("Enter")
    changed = [now != then for now, then in zip(unfolded.evaluate(ends), before, strict=True)]
    assert changed.count(True) == 1
    figure.scroll_into_view_if_needed()
    frame = figure.locator(".bk-CartesianFrame").first.bounding_box()
    unfolded.mouse.move(frame["x"] + frame["width"] / 2, frame["y"] + frame["height"] / 2, steps=3)
    unfolded.locator(".bk-Tooltip:visible").get_by_text("measured:", exact=True).wait_for()


def test_the_map_tells_its_numbers_under_the_pointer_and_in_a_table(unfolded, diagnosis):
    opened = unfolded
    figure = opened.locator("figure.live", has_text="Mean error (N) in each cell").first
    shown = failure_map.data(compare(diagnosis.base))
    cells, frames = failure_map.cells(shown), figure.locator(".bk-CartesianFrame")
    assert frames.count() == len(shown.branches) and not figure.get_by_role("button").count()
    for cell in (cells[0], cells[-1]):
        branch, pressure, place = cell.place
        frames.nth(branch).scroll_into_view_if_needed()
        box = frames.nth(branch).bounding_box()
        x = box["x"] + box["width"] * (place + 0.5) / (len(shown.edges) - 1)
        opened.mouse.move(x, box["y"] + box["height"] * (1 - (pressure + 0.5) / len(shown.pressures)), steps=3)
        mean, read = newtons(cell.mean).replace("-", "−"), opened.locator(".bk-Tooltip:visible")
        for word in (f"{cell.pressure_MPa:.3g} MPa", mean, newtons(cell.rms), str(cell.n)):
            read.get_by_text(word, exact=True).first.wait_for()
    table = opened.locator("details details table").first
    assert not table.is_visible()
    opened.locator("details details summary").first.focus()
    opened.keyboard.press("Enter")
    assert table.is_visible() and table.locator("tbody tr").count() == len(cells)


def test_the_first_tab_skips_to_the_verdict(opened):
    opened.keyboard.press("Tab")
    assert opened.evaluate("document.activeElement.textContent") == "Skip to the verdict"
    assert opened.locator(".skip").bounding_box()["x"] >= 0
    opened.keyboard.press("Enter")
    assert opened.evaluate("document.activeElement.id") == "main"


def test_paper_holds_every_rung_and_the_folded_table(opened):
    opened.emulate_media(media="print")
    assert len(shown(opened)) == 3 and opened.locator("details details table").first.is_visible()
    assert not opened.locator("nav:visible").count() and not opened.locator("fieldset").first.is_visible()
    pdf = opened.pdf(prefer_css_page_size=True)
    assert pdf.startswith(b"%PDF-") and len(pdf) < 3_000_000


def test_a_screen_reader_is_told_the_verdict_first_and_every_figure_and_table_by_name(unfolded):
    """Chromium's accessibility tree, in reading order, is what such a reader speaks."""
    opened = unfolded
    told = opened.locator("main").aria_snapshot().splitlines()
    roles = [line.strip().removeprefix("- ").strip("'\"") for line in told]
    where = {role: [k for k, line in enumerate(roles) if line.startswith(role)] for role in ("heading", "img", "table")}
    assert roles[where["heading"][1]].startswith(
        'heading "Missing: Coulomb friction or friction that grows with pressure." [level=3]'
    )
    spoken = next(k for k, line in enumerate(roles) if "With that added" in line)
    assert where["heading"][1] < spoken < min(where["img"][0], where["table"][0])
    levels = [int(re.search(r"level=(\d)", roles[k])[1]) for k in where["heading"]]
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert len(where["img"]) >= 10 and all(re.match(r'img "[^"]{10,}', roles[k]) for k in where["img"])
    for table in opened.locator("table:visible").all():
        assert table.get_by_role("columnheader").count() >= 2


def test_a_dark_screen_darkens_page_and_figures_alike_and_paper_neither(unfolded):
    figures, ground = unfolded.locator("figure svg:visible"), "getComputedStyle(document.body).backgroundColor"
    for media, dark in (("screen", True), ("print", False)):
        unfolded.emulate_media(media=media, color_scheme="dark")
        paper = [int(part) for part in re.findall(r"\d+", unfolded.evaluate(ground))]
        assert (max(paper) < 40) if dark else (paper == [255, 255, 255])
        for k in range(3):
            seen = imread(io.BytesIO(figures.nth(k).screenshot()), "png")[..., :3].reshape(-1, 3)
            assert np.abs(255 * seen[0] - paper).max() <= 1.0, "a figure stands on the page, not on a card"
            words = seen.min(1).max() if dark else seen.max(1).min()
            assert abs(words - seen[0].mean()) > 0.6, "its words are as far from the ground as on paper"


@pytest.mark.long
@pytest.mark.parametrize(
    ("width", "rungs", "scheme"),
    [(1400, (0, 2), "light"), (500, (1,), "light"), (1400, (2,), "dark"), (500, (0,), "dark")],
)
def test_axe_finds_no_fault_of_weight(opened, width, rungs, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    opened.emulate_media(color_scheme=scheme)
    opened.set_viewport_size({"width": width, "height": 900})
    opened.wait_for_function("document.documentElement.scrollWidth <= window.innerWidth")
    opened.evaluate(OPENED)
    for rung in rungs:
        opened.get_by_role("radio").nth(rung).click()
        found = axe.run(opened).response["violations"]
        told = [(one["id"], one["impact"], [n["html"][:200] for n in one["nodes"]]) for one in found]
        assert [one for one in told if one[1] in ("serious", "critical", "moderate")] == [], json.dumps(told, indent=1)


@pytest.mark.long
def test_two_records_beside_each_other_open_with_what_differs_and_no_figure_is_cut(page, diagnosis, tmp_path):
    path = tmp_path / "ab.html"
    path.write_text(render_against(against(diagnosis, diagnosis), {}), encoding="utf-8")
    page.set_viewport_size({"width": 500, "height": 900})
    page.goto(path.as_uri())
    assert page.get_by_role("heading", name="What differs").bounding_box()["y"] < 300
    page.locator("figure.live").nth(1).wait_for(state="attached")
    assert page.get_by_role("button", name="Zoom in").count() == 2, "the trace of each is zoomed into"
    for drawing in page.locator(".drawing").all():
        assert not drawing.evaluate(CUT)
    page.wait_for_function("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
    assert all(one.bounding_box()["width"] <= 468 for one in page.locator("caption").all()), "a table may scroll"
    page.set_viewport_size({"width": 1400, "height": 900})
    assert page.locator(".drawing svg").last.bounding_box()["width"] < 700, "words no larger than those of the text"


@pytest.mark.long
def test_the_name_of_a_record_alone_stands_once_above_its_answer(page, record, diagnosis, tmp_path):
    path, one = tmp_path / "one.html", Section(record, compare(diagnosis.base), diagnosis)
    path.write_text(render(Story(f"{record.name}: a law", (one,), {})), encoding="utf-8")
    page.goto(path.as_uri())
    boxes = [one.bounding_box() for one in page.get_by_role("heading", name=record.name).all()]
    assert [box["width"] > 1 for box in boxes] == [True, False], "the second is for a screen reader"
