"""A number is written the same way wherever it is said: text, JSON, page, Markdown, workbench, Python."""

import json
import re

import numpy as np
import pytest

import pam_ident as pam
from pam_ident.core.digits import newtons, percent, probability

SIZE = re.compile(r"(?<![\w.])(\d[\d.]*(?:e[+-]?\d+)?) N(?![\w/·])")
SHARE = re.compile(r"\d%")
MEAN = re.compile(r"pulls .*?\(.*?\)")  # a mean and its interval, by its standard error
DRAWN = re.compile(r"<style.*?</style>|<script.*?</script>|<[^>]+>", re.DOTALL)


def strays(text):
    """What is written otherwise than `core.digits` has it."""
    sizes = [found[0] for found in SIZE.finditer(text) if newtons(float(found[1])) != found[0]]
    return sizes + [text[max(found.start() - 30, 0) : found.end()] for found in SHARE.finditer(text)]


def texts(answer):
    """Every text in an answer."""
    if isinstance(answer, str):
        return [answer]
    inside = answer.values() if isinstance(answer, dict) else answer if isinstance(answer, list) else ()
    return [text for one in inside for text in texts(one)]


@pytest.fixture(scope="module")
def rippled(clean, write_record):
    """A ripple of the drive, which no effect of the catalogue explains, spikes, and a force that is pushed."""
    rows = np.loadtxt(clean, delimiter=",", skiprows=1)
    rows[:, 3] += 6.0 * np.sin(2.0 * np.pi * rows[:, 2] / 5.0)
    rows[100, 3] = -114.437
    lines = "".join(",".join(f"{value:.6f}" for value in row) + "\n" for row in rows)
    return write_record("time_s,pressure_MPa,displacement_mm,force_N\n" + lines)


def test_it_sees_what_is_written_otherwise():
    assert strays("it leaves 5.2 N, 90% of 12.34 N") == ["5.2 N", "12.34 N", "it leaves 5.2 N, 90%"]
    assert not strays("it leaves 5.20 N of 12.3 N, 1200 N and 0 N; 90 % follows −0.0123 N, 3 N·m, 4.5 Nm")


@pytest.mark.long
@pytest.mark.parametrize("name", ["rubbing", "rippled", "dmsp20_300"])
def test_in_text_and_json(name, request, ask, tmp_path):
    record = name if name == "dmsp20_300" else request.getfixturevalue(name)
    for verb in ("inspect", "compare", "diagnose"):
        law = [] if verb == "inspect" else ["--law", "exponential_law"]
        said = ask(verb, record, *law, "--json", tmp_path / verb)
        assert said.exit_code == 0 and said.stdout
        answer = "\n".join(texts(json.loads((tmp_path / verb).read_text(encoding="utf-8"))))
        assert not strays(said.stdout + said.stderr) and not strays(answer), verb


@pytest.mark.long
@pytest.mark.parametrize("name", ["rubbing", "rippled", "dmsp20_300"])
def test_on_the_page_and_in_markdown(name, request, ask, tmp_path):
    record = name if name == "dmsp20_300" else request.getfixturevalue(name)
    for ending in ("html", "md"):
        out = tmp_path / f"report.{ending}"
        said = ask("report", record, "--law", "exponential_law", "--out", out)
        assert said.exit_code == 0 and not strays(said.stdout + said.stderr)
        assert not strays(DRAWN.sub(" ", out.read_text(encoding="utf-8").replace("−", "-"))), ending


@pytest.mark.long
def test_in_a_comparison_of_two(clean, rubbing, ask, tmp_path):
    said = ask("against", clean, rubbing, "--json", tmp_path / "ab.json", "--out", tmp_path / "ab.html")
    assert said.exit_code == 0 and "rms" in said.stdout
    whole = (tmp_path / "ab.html").read_text(encoding="utf-8")
    assert whole.index("What differs") < whole.index("Contents"), "the answer comes first"
    assert f"{clean} {rubbing} --law exponential_law --out" in whole
    page = DRAWN.sub(" ", (tmp_path / "ab.html").read_text(encoding="utf-8"))
    answer = "\n".join(texts(json.loads((tmp_path / "ab.json").read_text(encoding="utf-8"))))
    texts_of_all = (MEAN.sub(" ", text) for text in (" ".join(said.stdout.split()), page, answer))
    assert not any(map(strays, texts_of_all))


@pytest.mark.long
def test_in_python_and_on_the_workbench(rippled):
    from pam_ident.workbench import words

    found = pam.diagnose(rippled, "exponential_law")
    details = found.details
    headline = " ".join(words.headline(details))
    assert newtons(details.base.rmse) in details.sentence and newtons(details.base.rmse) in headline
    assert details.pattern is not None and details.pattern.text in headline
    said = found.summary()
    assert all(percent(one.share) in said for one in details.follows)
    assert all(probability(one) in said for one in found.candidates["probability"])
    assert percent(details.follows[0].share) in pam.compare(rippled, "exponential_law").summary()
    for told in (said, found._repr_html_(), headline, words.follows(details.follows)):
        assert not strays(DRAWN.sub(" ", str(told)))


@pytest.mark.parametrize(
    ("share", "told"), [(0.0, "0 %"), (0.126, "13 %"), (0.9968, "> 99 %"), (1.0, "100 %"), (-0.002, "0 %"), (None, "-")]
)
def test_what_is_not_all_is_not_called_so(share, told):
    assert percent(share) == told
    assert probability(share or 0.0) in (told, "< 1 %", "> 99 %")
