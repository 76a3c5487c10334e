"""Seconds from a click to its answer on the page, in a real browser: adding, undoing, removing, another
law, and adding the likeliest candidate.

    python benchmarks/workbench.py [--record NAME] [--markdown FILE]

On the clock until the error and its figures are the new ones, and until what is missing is said of them; then the
seconds of a processor that the program needed until then, whatever else runs. Medians. `--markdown` puts the table into
FILE, between its lines <!-- workbench --> and <!-- /workbench -->.
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
from pathlib import Path

import psutil
from playwright.sync_api import Page, sync_playwright
from real_records import put_tables

EFFECTS = (
    "Friction that grows with pressure",
    "Coulomb friction",
    "Presliding hysteresis",
    "Viscous damping",
    "Creep and stress relaxation",
)
LAWS = (
    "Modified Chou–Hannaford law",
    "Six-parameter law of Sárosi",
    "Rubber law of Martens and Boblan",
    "Area-and-spring law of Hildebrandt",
    "Polynomial law over pressure",
)
"""Each once: what was asked before is not asked again, and would take no time."""
LOOKED_S = 5.0
"""How long a person looks at the candidates before choosing the likeliest."""


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    asked.add_argument("--record", default="hidden_effect")
    asked.add_argument("--markdown", type=Path)
    given, begun = asked.parse_args(), os.getloadavg()[0]
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
        rows = page.get_by_text(re.compile(r"^\d+ samples")).first.inner_text().partition(" at ")[0]
        found: dict[str, list[tuple[float, ...]]] = {}
        program = psutil.Process(server.pid)
        for effect in EFFECTS:
            page.get_by_label("Another effect").select_option(effect)
            for name, button in (
                ("add another effect", "Add this effect"),
                ("undo", "Undo"),
                ("redo", "Redo"),
                ("remove", f"Remove {effect}"),
            ):
                act = page.get_by_role("button", name=re.compile(f"^{button}", re.I))
                found.setdefault(name, []).append(timed(page, program, act.click))
        for law in LAWS:
            choose = page.get_by_label("Force law")
            found.setdefault("another law", []).append(
                timed(page, program, lambda c=choose, law=law: c.select_option(law))
            )
            likeliest = page.get_by_role("group", name="Candidates").get_by_role("button").first
            time.sleep(LOOKED_S)
            found.setdefault("add the likeliest, after a look of 5 s", []).append(timed(page, program, likeliest.click))
        browser.close()
    lines = ["| step | error and figures | what is missing | of a processor |", "|---|---:|---:|---:|"]
    for name, times in found.items():
        medians = (statistics.median(each) for each in zip(*times, strict=True))
        lines.append(f"| {name} | {' | '.join(f'{seconds:.2f} s' for seconds in medians)} |")
    machine = f"{os.cpu_count()} cores, load {' to '.join(f'{one:.1f}' for one in (begun, os.getloadavg()[0]))}"
    text = "\n".join([f"`{given.record}`, {rows}; {machine}; medians of {len(LAWS)}.", "", *lines])
    print(text)
    if given.markdown:
        put_tables(text, given.markdown, "<!-- workbench -->\n", "<!-- /workbench -->")


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
