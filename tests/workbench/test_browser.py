"""The workbench as a process, used in a real browser: the whole story, and nothing that leaves the machine."""

import http.client
import json
import os
import re
import signal
import subprocess
import sys
import urllib.request

import pytest

pytest.importorskip("panel")
pytestmark = pytest.mark.browser
SOON = 60_000
"""Milliseconds that a fit and a diagnosis may take on a busy machine."""


@pytest.fixture(scope="module")
def address(root, tmp_path_factory):
    """A workbench without a record, on a port of its own."""
    place = tmp_path_factory.mktemp("served")
    words = [sys.executable, "-m", "pam_ident", "workbench", "--no-browser", "--port", "0"]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    with (
        (place / "errors.txt").open("w") as errors,
        subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=errors, text=True, cwd=place, env=environment
        ) as process,
    ):
        assert process.stdout is not None
        yield re.search(r"http://127\.0\.0\.1:\d+", process.stdout.readline()).group()
        process.send_signal(signal.SIGINT)
        assert process.wait(20) in (0, 130)
    assert "Traceback" not in (place / "errors.txt").read_text() and list(place.iterdir()) == [place / "errors.txt"]


@pytest.fixture
def opened(chromium, address):
    """The page, opened; in the end nothing was complained of, and nobody but this machine was asked for anything."""
    sync_api = pytest.importorskip("playwright.sync_api")
    complaints, asked = [], []
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        page = browser.new_context(viewport={"width": 1400, "height": 1000}).new_page()
        page.set_default_timeout(SOON)
        page.on("console", lambda m: complaints.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.on("websocket", lambda socket: asked.append(socket.url))
        page.goto(address)
        page.get_by_role("heading", name="pam-ident workbench").wait_for()
        yield page
        browser.close()
    foreign = [url for url in asked if not re.match(rf"(blob:)?(http|ws)://{address.partition('//')[2]}/", url)]
    assert complaints == [] and foreign == []


def drop(page, folder, *names):
    """Give files to the page."""
    page.locator("input[type=file]").set_input_files([folder / name for name in names])


def error_now(page):
    """The present error in N, as the page tells it."""
    fact = page.locator("dl.facts div", has_text="error now").locator("dd")
    return float(re.match(r"[\d.]+", fact.text_content()).group())


def test_the_whole_story(opened, folder, tmp_path):
    drop(opened, folder, "record.csv", "specimen.toml")
    opened.get_by_text("Effect missing").wait_for()
    assert error_now(opened) == pytest.approx(12.0, rel=0.1)
    assert "Missing: coulomb_friction" in opened.locator("p.lead").text_content()
    opened.get_by_role("button", name="Add coulomb_friction").click()
    opened.get_by_text("Adequate").wait_for()
    assert error_now(opened) == pytest.approx(1.0, rel=0.1)
    assert opened.locator("svg[aria-label='Rms error as effects are added']").is_visible()
    command = opened.locator("pre").text_content()
    assert re.fullmatch(r"pam-ident add record\.csv --law exponential_law --effect coulomb_friction\S*", command)
    for tab, seen in (
        ("Where it fails", "Mean error over pressure and contraction, by branch"),
        ("Trace of the effects", "Error over the record before and after the effects were added"),
    ):
        opened.locator(".bk-tab", has_text=tab).click()
        opened.locator(f"svg[aria-label='{seen}'], img[alt='{seen}']").wait_for()
    with opened.expect_download() as download:
        opened.get_by_text("Save the report").click()
    download.value.save_as(tmp_path / "report.html")
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "coulomb_friction" in report and len(report) < 3_000_000
    opened.get_by_role("button", name="Remove coulomb_friction").click()
    opened.get_by_text("Effect missing").wait_for()
    assert error_now(opened) == pytest.approx(12.0, rel=0.1)


def test_a_bad_file_is_told_and_does_no_harm(opened, folder, tmp_path):
    drop(opened, folder, "record.csv", "specimen.toml")
    opened.get_by_text("Effect missing").wait_for()
    (tmp_path / "<img src=x onerror=alert(1)>.csv").write_text("time_s,<b>force</b>\n0,1\n")
    opened.locator("input[type=file]").set_input_files(
        [tmp_path / "<img src=x onerror=alert(1)>.csv", folder / "specimen.toml"]
    )
    alert = opened.get_by_role("alert")
    alert.wait_for()
    assert "csv" in alert.text_content() and opened.locator("p.error img, p.error b").count() == 0
    assert error_now(opened) == pytest.approx(12.0, rel=0.1)


def test_axe_finds_no_serious_fault(opened, folder):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    drop(opened, folder, "record.csv", "specimen.toml")
    opened.get_by_text("Effect missing").wait_for()
    opened.get_by_text("Specimen", exact=True).click()
    found = axe.run(opened).response["violations"]
    told = [(one["id"], one["impact"], [n["html"][:200] for n in one["nodes"]]) for one in found]
    assert [one for one in told if one[1] in ("serious", "critical", "moderate")] == [], json.dumps(told, indent=1)


def test_only_this_machine_and_this_page_are_answered(address):
    import socket

    host = next((a[4][0] for a in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)), "127.0.0.1")
    port = address.rpartition(":")[2]
    if not host.startswith("127."):
        with pytest.raises(OSError):
            urllib.request.urlopen(f"http://{host}:{port}/", timeout=5)
    key = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "AAAA"}
    door = http.client.HTTPConnection("127.0.0.1", int(port), timeout=5)
    door.request("GET", "/ws", headers={**key, "Origin": "http://evil.example"})
    assert door.getresponse().status == 403
    door.close()
