"""What CONTRIBUTING.md says of one thing in one file, done: each of its files is put into a copy of the package."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from pam_ident.records.datasets import dataset_record

RECORD = """
import numpy as np
from pam_ident.core import Specimen
from pam_ident.records import build_record
rng = np.random.default_rng(4)
time = np.arange(1500) * 0.1
x = 20.0 - 20.0 * np.cos(2.0 * np.pi * time / 30.0)
pressure = np.where(time < 75.0, 0.3, 0.4)
specimen = Specimen("bench", 200.0, 10.0, 25.4, 1.5)
def loops(hidden):
    force = 400.0 - 5.0 * x + hidden + rng.standard_normal(1500)
    return build_record("loop", specimen, pressure, x / 200.0, force, time=time)
"""
DONE = {
    "effects": """
import sys
from pam_ident.effects import catalogue
from pam_ident.validation.effect_contract import EFFECT_CHECKS, FORM_CHECKS
from pam_ident.validation.check_effects import clean_record
effect, record = catalogue()["spindle_ripple"], clean_record()
print([said for check in EFFECT_CHECKS for said in check(effect, record)])
from pam_ident.cli import main
sys.argv[1:] = ["effects", "show", "spindle_ripple"]
main()
""",
    "laws": """
import sys
from pam_ident.cli import main
sys.argv[1:] = ["fit", RECORD_PATH, "--law", "parabola", "--json", "-"]
main()
""",
    "patterns": RECORD
    + """
from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
found = diagnose(Model.build("polynomial"), loops(6.0 * (x / 5.3 - np.floor(x / 5.3) - 0.5)))
print(found.verdict, found.pattern.kind, found.pattern.coordinate, found.pattern.text)
""",
    "noises": """
import numpy as np
from scipy.signal import lfilter
from pam_ident.diagnosis.noises import catalogue, likelier_colour
white = np.random.default_rng(2).standard_normal((3, 4000)) * np.sqrt([[0.4], [0.4], [0.2]])
wanders = [lfilter([np.sqrt(1.0 - r * r)], [1.0, -r], one) for r, one in zip(np.exp([-1.0 / 3.0, -1.0 / 400.0]), white)]
z = sum(wanders) + white[2]
asked = z / np.std(z), [np.ones(4000)], np.full(4000, np.exp(-1.0 / 40.0)), 0.9
both, _ = likelier_colour(*asked)
del catalogue()["two_wanders"]
print("gained", both - likelier_colour(*asked)[0])
""",
}
SHOWS = {
    "effects": r"^\[\]\nspindle_ripple: ripple of the spindle",
    "laws": r'"f2": \{\s+"value"',
    "patterns": r"^unknown_effect periodic displacement a sawtooth every 5\.(29|3) mm \(alike on both branches\)",
    "noises": r"^gained [1-9]\d",
}


def files(root):
    """Path and text of each file that the page shows."""
    page = (root / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return dict(re.findall(r"```python\n# (pam_ident/\S+)\n(.*?)```", page, re.S))


def test_the_page_shows_one_file_of_each_kind(root):
    elsewhere = {"formats", "targets"}  # tests/records/test_new_format.py, tests/export/test_new_target.py
    assert {path.split("/")[-2] for path in files(root)} == set(DONE) | elsewhere


@pytest.mark.long
@pytest.mark.parametrize("kind", DONE)
def test_one_new_file_is_all_it_takes(root, tmp_path, kind):
    shutil.copytree(root / "pam_ident", tmp_path / "pam_ident", ignore=shutil.ignore_patterns("__pycache__"))
    ((path, text),) = ((p, t) for p, t in files(root).items() if p.split("/")[-2] == kind)
    assert not (tmp_path / path).exists()
    (tmp_path / path).write_text(text, encoding="utf-8")
    script = f"RECORD_PATH = {str(dataset_record('paper_laws'))!r}\n" + DONE[kind]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", script], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert re.search(SHOWS[kind], done.stdout), done.stdout + done.stderr
