"""The demo's report in a real browser: the whole story is on the page, and the page asks for nothing."""

import pytest

from pam_ident.diagnosis import compare
from pam_ident.report import Section, Story, render

pytestmark = pytest.mark.browser


def test_the_report_opens_offline_without_a_complaint(page, tmp_path, record, diagnosis, ladder):
    section = Section(record, compare(diagnosis.base), diagnosis, compare(diagnosis.best), ladder)
    file = tmp_path / "report.html"
    file.write_text(render(Story("Browser", (section,), {"command": "pam-ident report"})), encoding="utf-8")
    complaints, asked = [], []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(file.as_uri())
    assert page.title() and page.locator("h1").count() == 1
    assert page.get_by_text(diagnosis.sentence).first.is_visible()
    figures = page.locator("figure svg:visible, figure img:visible")
    assert figures.count() >= 5
    for k in range(figures.count()):
        box = figures.nth(k).bounding_box()
        assert box is not None and box["width"] > 200 and box["height"] > 100
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    assert complaints == [] and asked == [file.as_uri()]
