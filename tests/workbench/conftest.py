"""The made-up record with friction in it of the command line's tests, and what the bench makes of it."""

import os
import re
import runpy
import signal
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from hand import drop, tried

SOON = 60_000
"""Milliseconds that a fit and a diagnosis may take on a busy machine."""

_cli = runpy.run_path(str(Path(__file__).parents[1] / "cli" / "conftest.py"))
write_record, rubbing = _cli["write_record"], _cli["rubbing"]


@pytest.fixture(scope="session")
def folder(rubbing) -> Path:
    """record.csv with 12 N of dry friction, specimen.toml beside it."""
    return rubbing.parent


@pytest.fixture(scope="session")
def begun(rubbing):
    """The record on the bench with the exponential law, diagnosed."""
    from pam_ident.tasks.setup import Setup
    from pam_ident.workbench.bench import Bench

    setup = Setup("exponential_law")
    return Bench.begin(setup.read(rubbing), str(rubbing), setup).diagnosed()


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
    told = (place / "errors.txt").read_text()
    assert not re.search("Traceback|Exception|closed", told) and list(place.iterdir()) == [place / "errors.txt"]


@pytest.fixture
def opened(browser, address):
    """The page; in the end nothing was complained of, and nobody but this machine was asked for anything."""
    complaints, asked = [], []
    with browser.new_context(viewport={"width": 1400, "height": 1000}) as context:
        page = context.new_page()
        page.set_default_timeout(SOON)
        page.on("console", lambda m: complaints.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.on("websocket", lambda socket: asked.append(socket.url))
        page.goto(address)
        page.get_by_role("heading", name="pam-ident workbench").wait_for()
        yield page
    foreign = [url for url in asked if not re.match(rf"(blob:)?(http|ws)://{address.partition('//')[2]}/", url)]
    assert complaints == [] and [url for url in foreign if not url.startswith("data:")] == []


@pytest.fixture
def lying(opened, folder):
    """The page with the record with friction in it, its candidates tried."""
    drop(opened, folder, "record.csv", "specimen.toml")
    tried(opened)
    return opened


@pytest.fixture(scope="module")
def foreign(folder, tmp_path_factory):
    """The record as another rig writes it: headings that say little, or of another language; no specimen."""
    import pandas as pd

    place = tmp_path_factory.mktemp("foreign")
    table = pd.read_csv(folder / "record.csv")
    names = ["time_s", "pressure_MPa", "displacement_mm", "force_N"]
    bar = table[names].assign(pressure_MPa=10.0 * table["pressure_MPa"])
    bar.set_axis(["t", "AI0", "LVDT", "LoadCell"], axis=1).to_csv(place / "rig.csv", index=False)
    german = bar.set_axis(["Zeit", "Druck [bar]", "Weg [mm]", "Kraft"], axis=1)
    german.to_csv(place / "deutsch.csv", index=False, sep=";", decimal=",")
    slip = table[names].assign(displacement_mm=table["displacement_mm"] / 1000.0)
    slip.to_csv(place / "slip.csv", index=False)  # metres, labelled mm
    return place
