"""Seconds from a click to its answer on the page, in a real browser: adding, undoing, removing, another
law, and adding the likeliest candidate.

    python benchmarks/workbench.py [--record NAME]

`shown` is until the error and its figures are the new ones, `named` until what is missing is said of them, `worked` the
seconds of a processor that the program needed for it, whatever else runs.
Needs a chromium: PAM_IDENT_CHROMIUM, or one on the path.
"""

import argparse
import contextlib
import os
import re
import shutil
import statistics
import subprocess
import sys
import time

import psutil
from playwright.sync_api import Page, sync_playwright

EFFECTS = (
    "Friction in proportion to pressure",
    "Coulomb friction",
    "Presliding hysteresis",
    "Viscous damping",
    "Creep and stress relaxation",
)
LAWS = (
    "Modified Chou–Hannaford law",
    "Six-parameter law of Sárosi",
    "Braid in rubber of Martens and Boblan",
    "Area and membrane spring of Hildebrandt",
    "Polynomial slope and intercept over pressure",
)
"""Each once: what was asked before is not asked again, and would take no time."""
LOOKED_S = 5.0
"""How long a person looks at the candidates before choosing the likeliest."""


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    asked.add_argument("--record", default="hidden_effect")
    given = asked.parse_args()
    words = [sys.executable, "-m", "pam_ident", "workbench", given.record, "--no-browser", "--port", "0"]
    with (
        subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server,
        contextlib.ExitStack() as last,
        sync_playwright() as playwright,
    ):
        last.callback(server.kill)  # Popen waits for its end, where a browser is missing, too
        assert server.stdout is not None
        address = re.search(r"http://127\.0\.0\.1:\d+", server.stdout.readline())
        assert address is not None
        chromium = os.environ.get("PAM_IDENT_CHROMIUM") or shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        page = browser.new_page(viewport={"width": 1400, "height": 1000})
        page.goto(address.group())
        page.get_by_label("Another effect").wait_for()
        idle(page)
        found: dict[str, list[tuple[float, ...]]] = {}
        program = psutil.Process(server.pid)
        for effect in EFFECTS:
            page.get_by_label("Another effect").select_option(effect)
            for name, button in (
                ("add", "Add this effect"),
                ("undo", "Undo"),
                ("redo", "Redo"),
                ("remove", f"Remove {effect}"),
            ):
                act = page.get_by_role("button", name=re.compile(f"^{button}"))
                found.setdefault(name, []).append(timed(page, program, act.click))
        for law in LAWS:
            choose = page.get_by_label("Force law")
            found.setdefault("law", []).append(timed(page, program, lambda c=choose, law=law: c.select_option(law)))
            likeliest = page.get_by_role("group", name="Candidates").get_by_role("button").first
            time.sleep(LOOKED_S)
            found.setdefault("likeliest", []).append(timed(page, program, likeliest.click))
        browser.close()
    for name, times in found.items():
        shown, named, worked = (statistics.median(each) for each in zip(*times, strict=True))
        print(f"{name:9} shown {shown:.2f} s, named {named:.2f} s, worked {worked:.2f} s (median of {len(times)})")


def timed(page: Page, program: psutil.Process, act) -> tuple[float, float, float]:
    """Seconds until the error is another and until something is named, and of the processor until then."""
    error = page.locator("dl.facts div", has_text="error now").locator("dd")
    before, worked, begun = error.text_content(), sum(program.cpu_times()[:2]), time.perf_counter()
    act()
    while error.text_content() == before:
        time.sleep(0.005)
    shown = time.perf_counter() - begun
    page.locator("p.lead b").wait_for(timeout=120_000)
    named, worked = time.perf_counter() - begun, sum(program.cpu_times()[:2]) - worked
    idle(page)
    return shown, named, worked


def idle(page: Page) -> None:
    """Wait until the workbench has nothing more to find."""
    page.locator("[data-state='']").wait_for(state="attached", timeout=120_000)
    page.locator("p.lead b").wait_for(timeout=120_000)


if __name__ == "__main__":
    main()
