"""What a notebook shows of each result, by IPython's own formatter."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from base64 import b64decode
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import compare
from pam_ident.fitting import fit
from pam_ident.leg.muscle import Muscle
from pam_ident.leg.track import Track, Tracking, TrackRung
from pam_ident.model import Model
from pam_ident.records.datasets import dataset_path

HOSTILE = '<script>alert("x")</script> & </svg> ${y}'


def well_formed(html: str) -> ET.Element:
    return ET.fromstring(f"<div>{html}</div>")


def texts(html: str) -> str:
    return " ".join(well_formed(html).itertext()).replace("\u00a0", " ")


@pytest.fixture(scope="module")
def track():
    def run(size):
        time = 0.005 * np.arange(200)
        both = np.zeros((200, 2))
        return Tracking(time, np.zeros(200), size * np.sin(2.0 * np.pi * time), both, both)

    muscle = Muscle.read(dataset_path("leg_muscle") / "ladder.json")[0]
    return Track(None, None, None, None, run(4.0), run(2.0), (TrackRung(muscle, run(1.0), (0.3, 0.5)),), run(0.5), None)


@pytest.fixture
def results(record, table, diagnosis, ladder, track):
    return {
        "specimen": record.specimen,
        "record": record,
        "table": table,
        "fit": diagnosis.best,
        "comparison": compare(diagnosis.base),
        "diagnosis": diagnosis,
        "ladder": ladder,
        "track": track,
    }


@pytest.mark.parametrize(
    ("name", "figures", "words"),
    [
        ("specimen", 0, ["made up", "braid_angle_deg", "25"]),
        ("record", 1, ["656", "0.3, 0.5", "made.csv"]),
        ("table", 1, ["15", "0.2, 0.4, 0.6"]),
        ("fit", 1, ["coulomb_friction.F_c", "95 % interval", "N rms", "−F_c sgn(ε̇)"]),
        ("comparison", 1, []),
        ("diagnosis", 2, ["a constant gap of 16 N", "97 %", "Repeat the strokes at 0.1 MPa."]),
        ("ladder", 1, ["noise floor", "halves the error"]),
        ("track", 1, ["PID, by hand", "2.828", "0.300 to 0.500"]),
    ],
)
def test_a_result_shows_what_it_says_and_a_small_figure(shown, results, name, figures, words):
    found = shown(results[name])
    html = found["text/html"]
    root = well_formed(html)
    images = root.findall(".//img")
    assert len(images) == figures and len(html) < 300_000
    assert "<svg" not in html, "JupyterLab takes its marks out of a notebook it does not trust, and leaves its words"
    for one in images:
        drawn = ET.fromstring(b64decode(one.get("src").partition("data:image/svg+xml;base64,")[2]))
        assert drawn.tag == "{http://www.w3.org/2000/svg}svg" and float(drawn.get("width")) > 300 and one.get("alt")
    for word in words:
        assert word in texts(html)
    assert not re.search(r"<script|https?://|\son\w+=", html)
    assert len(found["text/plain"].splitlines()) <= 2 and "array(" not in found["text/plain"]


def test_the_numbers_shown_of_a_fit_are_its_estimates(shown, diagnosis):
    one = diagnosis.best
    rows = well_formed(shown(one)["text/html"]).findall(".//tbody/tr")
    cells = {row[0].text: [cell.text for cell in row] for row in rows}
    for e in one.estimates:
        value, error, interval = (cells[e.name][k].replace("−", "-") for k in (1, 2, 3))
        assert float(value) == pytest.approx(e.value, rel=1e-4) and float(error) == pytest.approx(e.stderr, rel=0.06)
        low, high = map(float, interval.split(" to "))
        assert (low, high) == pytest.approx((e.low, e.high), rel=1e-3)


def test_a_model_shows_as_latex_and_prints_as_text(shown):
    found = shown(Model.build("exponential_law", ("creep",)))
    assert "text/html" not in found
    assert found["text/latex"].startswith("$$\n\\begin{aligned}") and r"\exp (-\mu \varepsilon )" in found["text/latex"]
    assert found["text/plain"].startswith("exponential_law: F = ")


@pytest.mark.long
def test_no_name_of_a_user_becomes_markup(shown, record, diagnosis, ladder):
    specimen = replace(record.specimen, name=HOSTILE)
    mine = replace(
        record,
        name=HOSTILE,
        source=HOSTILE,
        columns={"force": HOSTILE},
        inputs=replace(record.inputs, specimen=specimen),
    )
    candidate = replace(diagnosis.ranking[0], effect=HOSTILE, label=HOSTILE, why=HOSTILE)
    told = replace(diagnosis, sentence=HOSTILE, ranking=(candidate, *diagnosis.ranking[1:]))
    rung = replace(ladder.rungs[1], why=HOSTILE)
    one = fit(Model.build("modified_chou_hannaford"), mine)
    odd = replace(one, given=(replace(one.estimates[0], doc=HOSTILE, unit=HOSTILE), *one.estimates[1:]))
    comparison = replace(compare(diagnosis.base), sentence=HOSTILE)
    for result in (specimen, mine, told, replace(ladder, rungs=(ladder.rungs[0], rung)), odd, comparison):
        html = shown(result)["text/html"]
        assert "<script" not in html and HOSTILE in texts(html)


def run_in_python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.long
def test_results_import_neither_matplotlib_nor_jinja_nor_ipython():
    heavy = "[name for name in ('matplotlib', 'jinja2', 'IPython') if name in sys.modules]"
    code = (
        "import sys, pam_ident\n"
        "import pam_ident.fitting.fit, pam_ident.diagnosis.nouns, pam_ident.leg.track, pam_ident.records\n"
        f"print({heavy})"
    )
    assert run_in_python(code) == "[]"


@pytest.mark.long
def test_what_a_result_shows_waits_for_no_jax():
    """It takes seconds to import, and only the leg needs it."""
    code = "import sys, pam_ident.notebook.pages, pam_ident.report.render\nprint('jax' in sys.modules)"
    assert run_in_python(code) == "False"


@pytest.mark.long
def test_where_ipython_runs_a_result_shows_itself_and_matplotlib_waits_for_it():
    pytest.importorskip("IPython")
    code = (
        "import sys\n"
        "from IPython.core.interactiveshell import InteractiveShell\n"
        "shell = InteractiveShell.instance()\n"
        "shell.run_cell('import pam_ident; from pam_ident.core import Specimen; one = Specimen(\"mine\")')\n"
        "print('matplotlib' in sys.modules, 'numpy' in sys.modules)\n"
        "data, _ = shell.display_formatter.format(shell.user_ns['one'])\n"
        "print('<table>' in data['text/html'], data['text/plain'].startswith('Specimen mine'))"
    )
    assert run_in_python(code).splitlines()[-2:] == ["False True", "True True"]


@pytest.mark.long
def test_an_import_before_ipython_is_made_good_by_the_extension():
    pytest.importorskip("IPython")
    code = (
        "import pam_ident\nfrom pam_ident.core import Specimen\n"
        "from IPython.core.interactiveshell import InteractiveShell\n"
        "shell = InteractiveShell.instance()\n"
        "shell.run_line_magic('load_ext', 'pam_ident')\n"
        "print('<table>' in shell.display_formatter.format(Specimen())[0]['text/html'])"
    )
    assert run_in_python(code).splitlines()[-1] == "True"


def test_specimens_of_others_are_left_alone(shown):
    class Specimen:
        pass

    assert "text/html" not in shown(Specimen())


def test_a_specimen_with_sensors_tells_them(shown):
    from pam_ident.core.inputs import Sensors

    assert "sensors, force_N" in texts(shown(Specimen(sensors=Sensors(1.5)))["text/html"])
