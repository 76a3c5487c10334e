"""First screens of the workbench, the report and the README for these pages: `python docs/make_screenshots.py`.

Needs a chromium: PAM_IDENT_CHROMIUM, or one on the path.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from markdown_it import MarkdownIt
from playwright.sync_api import Page, sync_playwright

DOCS = Path(__file__).parent
RECORD, SIZE = "hidden_effect", {"width": 1400, "height": 900}
LOOK = """<style>body { font: 16px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto } img { max-width: 100% }
pre, code { background: #f3f4f6 } pre { padding: 1rem }</style>"""
PROGRAM = [sys.executable, "-m", "pam_ident"]


def workbench(page: Page) -> None:
    """The workbench with a candidate pointed at."""
    words = [*PROGRAM, "workbench", RECORD, "--no-browser", "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            address = re.search(r"http://\S+:\d+", server.stdout.readline())
            assert address is not None
            page.goto(address.group())
            page.locator(".card .bar").first.wait_for(timeout=120_000)
            page.locator(".card.named").first.hover()
            page.wait_for_timeout(500)
            page.screenshot(path=DOCS / "workbench.png")
        finally:
            server.kill()


def report(page: Page) -> None:
    """The first screen of a report."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place, "report.html")
        subprocess.run([*PROGRAM, "report", RECORD, "--law", "exponential_law", "--out", out], check=True)
        page.goto(out.as_uri())
        page.screenshot(path=DOCS / "report.png")


def readme(page: Page) -> None:
    """The first screen of the README, as a host of code would show it."""
    text = MarkdownIt("commonmark").enable("table").render((DOCS.parent / "README.md").read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as place:
        shown = Path(place, "readme.html")
        shown.write_text(f'<meta charset="utf-8"><base href="{DOCS.parent.as_uri()}/">{LOOK}{text}', encoding="utf-8")
        page.goto(shown.as_uri())
        page.screenshot(path=DOCS / "readme.png")


if __name__ == "__main__":
    with sync_playwright() as playwright:
        chromium = os.environ.get("PAM_IDENT_CHROMIUM") or shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        for picture in (workbench, report, readme):
            picture(browser.new_page(viewport=SIZE))
        browser.close()
