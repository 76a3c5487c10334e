"""README and pages show pictures, and what stands on a picture is what the program says now."""

import importlib.util
import re

import pytest

SHOWN = {
    "README.md": "report",
    "docs/index.md": "report",
    "docs/tutorial.md": "tutorial",
    "docs/workbench.md": "workbench",
    "docs/report.md": "report",
    "docs/measured.md": "readme",
}
"""Pages, and a picture that each must show."""


@pytest.fixture(scope="module")
def maker(root):
    """What makes the pictures."""
    pytest.importorskip("playwright.sync_api")
    spec = importlib.util.spec_from_file_location("make_screenshots", root / "docs" / "make_screenshots.py")
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    return maker


@pytest.mark.parametrize("page", SHOWN)
def test_a_page_shows_a_picture_that_is_there_and_says_what_is_on_it(page, root):
    place = root / page
    shown = re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", place.read_text(encoding="utf-8"))
    assert SHOWN[page] in [name.rpartition("/")[2].removesuffix(".png") for _, name in shown]
    for words, name in shown:
        assert len(words) > 30 and (place.parent / name).stat().st_size > 20_000, name


@pytest.mark.browser
@pytest.mark.long
@pytest.mark.parametrize("name", sorted({*SHOWN.values()}))
def test_a_picture_says_what_the_program_says_now(name, maker, root, page, agree):
    page.set_viewport_size(maker.SIZE)
    page.context.set_offline(False)  # the workbench is this machine's
    _, now = getattr(maker, name)(page)
    shown = maker.words_of(root / "docs" / f"{name}.png")
    assert len(shown) > 200 and agree(" ".join(shown.split()), " ".join(now.split())), "run docs/make_screenshots.py"
