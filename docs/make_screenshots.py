"""The pictures of these pages and of the README: `python docs/make_screenshots.py`.

First screens of the workbench, the report and the README, and the map of the tutorial. Each picture holds the words
that stand on it, so that a test can tell whether it is current.

Needs a chromium: PAM_IDENT_CHROMIUM, or one on the path.
"""

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from markdown_it import MarkdownIt
from PIL import Image
from PIL.PngImagePlugin import PngInfo
from playwright.sync_api import Page, sync_playwright

DOCS = Path(__file__).parent
RECORD, SIZE, WORDS = "hidden_effect", {"width": 1400, "height": 900}, "Description"
LOOK = """<style>body { font: 16px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto } img { max-width: 100% }
pre, code { background: #f3f4f6 } pre { padding: 1rem }</style>"""
PROGRAM = [sys.executable, "-m", "pam_ident"]


def workbench(page: Page) -> tuple[bytes, str]:
    """The workbench with a candidate pointed at."""
    words = [*PROGRAM, "workbench", RECORD, "--law", "exponential_law", "--no-browser", "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            address = re.search(r"http://\S+:\d+", server.stdout.readline())
            assert address is not None
            page.goto(address.group())
            page.locator(".card .bar").first.wait_for(timeout=120_000)
            page.locator("[data-state='']").wait_for(state="attached", timeout=120_000)
            page.locator(".card.named").first.hover()
            page.wait_for_timeout(1000)
            told = page.locator("p.lead, .card, .shares + p").all_text_contents()
            return page.screenshot(), " ".join(told)
        finally:
            server.kill()


def report(page: Page) -> tuple[bytes, str]:
    """The first screen of a report."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place, "report.html")
        subprocess.run([*PROGRAM, "report", RECORD, "--law", "exponential_law", "--out", out], check=True)
        page.goto(out.as_uri())
        page.locator("figure.live").first.wait_for()
        page.wait_for_timeout(1000)
        return page.screenshot(), page.locator(".first").inner_text()


def tutorial(page: Page) -> tuple[bytes, str]:
    """Where the model of the tutorial fails."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place, "map.svg")
        subprocess.run([*PROGRAM, "compare", RECORD, "--law", "exponential_law", "--out", out], check=True)
        page.goto(out.as_uri())
        drawn = page.locator("svg")
        return drawn.screenshot(), " ".join(drawn.locator("text").all_text_contents())


def readme(page: Page) -> tuple[bytes, str]:
    """The first screen of the README, as a host of code would show it."""
    text = MarkdownIt("commonmark").enable("table").render((DOCS.parent / "README.md").read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as place:
        shown = Path(place, "readme.html")
        shown.write_text(f'<meta charset="utf-8"><base href="{DOCS.parent.as_uri()}/">{LOOK}{text}', encoding="utf-8")
        page.goto(shown.as_uri())
        return page.screenshot(), page.locator("pre").first.inner_text()


def words_of(picture: Path) -> str:
    """What stands on a picture."""
    with Image.open(picture) as opened:
        return opened.info.get(WORDS, "")


PICTURES = (workbench, report, tutorial, readme)

if __name__ == "__main__":
    with sync_playwright() as playwright:
        chromium = os.environ.get("PAM_IDENT_CHROMIUM") or shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        for picture in PICTURES:
            drawn, told = picture(browser.new_page(viewport=SIZE))
            known = PngInfo()
            known.add_itxt(WORDS, told)
            Image.open(io.BytesIO(drawn)).save(DOCS / f"{picture.__name__}.png", optimize=True, pnginfo=known)
        browser.close()
