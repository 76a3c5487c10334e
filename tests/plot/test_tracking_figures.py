"""What the figures of tracking and of the loop would draw, and that they can be drawn."""

import xml.etree.ElementTree as ET
from types import SimpleNamespace

import numpy as np
import pytest

from pam_ident.leg.muscle import Muscle
from pam_ident.leg.track import Tracking, TrackRung
from pam_ident.plot import loop_diagram, to_svg, tracking
from pam_ident.records.datasets import dataset_path


def run_with(error):
    time = 1.0 + 0.005 * np.arange(200)
    target = 30.0 - 30.0 * np.cos(2.0 * np.pi * time)
    both = np.zeros((200, 2))
    return Tracking(time, target, target - error * np.sin(2.0 * np.pi * time), both, both)


@pytest.fixture(scope="module")
def track():
    """Runs made up, with sines of 4°, 2°, 1°, … as errors; the models are the embedded ladder's."""
    muscles = Muscle.read(dataset_path("leg_muscle") / "ladder.json")[:3]
    bands = (None, (0.3, 0.5), (0.1, 0.2))
    rungs = tuple(TrackRung(m, run_with(0.5**k), band) for k, (m, band) in enumerate(zip(muscles, bands, strict=True)))
    return SimpleNamespace(pid_by_hand=run_with(4.0), pid=run_with(2.0), rungs=rungs)


def test_it_shows_both_pids_and_the_first_and_last_rung(track):
    shown = tracking.data(track)
    assert list(shown.runs) == [
        "PID, tuned by hand",
        "PID, tuned automatically",
        "PID + ideal law of Chou and Hannaford",
        "PID + ideal law of Chou and Hannaford with 2 effects",
    ]
    for run, size in zip(shown.runs.values(), (4.0, 2.0, 1.0, 0.25), strict=True):
        assert run.flexion + run.error == pytest.approx(shown.target)
        assert np.max(np.abs(run.error)) == pytest.approx(size, rel=1e-3)
    assert shown.time[0] == 0.0 and shown.time[-1] == pytest.approx(0.995)


def test_rungs_have_the_error_of_a_sine_and_their_bands(track):
    shown = tracking.data(track)
    assert shown.rms == pytest.approx(np.array([1.0, 0.5, 0.25]) / np.sqrt(2.0))
    assert shown.pid_rms == pytest.approx(2.0 / np.sqrt(2.0))
    assert np.isnan(shown.band[0]).all() and shown.band[1:] == pytest.approx(np.array([[0.3, 0.5], [0.1, 0.2]]))
    assert len(shown.rungs) == 3 and "viscous damping" in shown.rungs[2]


def test_a_single_rung_is_drawn_once(track):
    track = SimpleNamespace(pid_by_hand=track.pid_by_hand, pid=track.pid, rungs=track.rungs[:1])
    assert len(tracking.data(track).runs) == 3


def test_it_can_be_drawn_and_says_its_units(track):
    svg = to_svg(tracking.draw(track))
    assert ET.fromstring(svg).tag.endswith("svg")
    for words in ("knee flexion (°)", "time (s)", "error, wanted − reached (°)", "rms tracking error (°)", "0.71°"):
        assert words in svg


def test_the_loop_names_its_blocks():
    svg = to_svg(loop_diagram.draw())
    assert ET.fromstring(svg).tag.endswith("svg")
    for words in ("PID", "inverse of the", "pressure", "two muscles", "four-bar", "angle sensor", "p wanted"):
        assert words in svg
