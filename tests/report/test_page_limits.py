"""What the page may weigh and what it may do, whatever the story."""

import base64
import gzip
import hashlib
import re
import sys
from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from unittest.mock import Mock

import pytest

from pam_ident.diagnosis.compare import compare
from pam_ident.diagnosis.nouns import Ladder, Rung
from pam_ident.fitting import fit, fit_isobars, loop_energies
from pam_ident.model import Model
from pam_ident.report import Section, Story, render, render_markdown

LAW = "modified_chou_hannaford"
EFFECTS = ("coulomb_friction", "viscous_damping", "creep", "pressure_lag", "length_offset")


@pytest.fixture(scope="module")
def long(record, diagnosis):
    """A section with every part, and a ladder of six rungs."""
    fits = [fit(Model.build(LAW, EFFECTS[:k]), record) for k in range(6)]
    ladder = Ladder(
        tuple(Rung(one, one.rmse, "because", diagnosis if one.model.terms else None) for one in fits), 0.5, diagnosis
    )
    return Section(
        record,
        compare(fits[0]),
        diagnosis,
        compare(fits[-1]),
        ladder,
        (fit_isobars(Model.build(LAW), record, ("contraction", "extension")),),
        loop_energies(record, record.force),
    )


@pytest.mark.long
def test_three_records_of_six_rungs_stay_below_three_megabytes(long):
    page = render(Story("three", (long,) * 3))
    assert page.count("<h4 ") == 18 and page.count("<figure ") == 3 * 12 and page.count('class="panels"') == 3 * (3 + 5)
    assert len(page.encode()) < 3_000_000


@pytest.mark.long
def test_the_page_forbids_itself_all_but_its_own_style_and_two_scripts(long):
    page = render(Story("x", (replace(long, ladder=None),)))
    bokeh, _, script = re.findall("<script[^>]*>(.*?)</script>", page, re.DOTALL)
    allowed = [script, gzip.decompress(base64.b64decode(bokeh)).decode()]
    hashes = [base64.b64encode(hashlib.sha256(one.encode()).digest()).decode() for one in allowed]
    assert _policy(page) == [
        "default-src 'none'",
        f"script-src 'sha256-{hashes[0]}' 'sha256-{hashes[1]}'",
        "style-src 'unsafe-inline'",
        "img-src data:",
        "base-uri 'none'",
        "form-action 'none'",
    ]
    assert page.index("Content-Security-Policy") < page.index("<style")


def _policy(page):
    return page.partition('http-equiv="Content-Security-Policy" content="')[2].partition('"')[0].split("; ")


@pytest.mark.long
def test_without_bokeh_or_where_nobody_wants_it_there_is_no_script(long, monkeypatch):
    story = Story("x", (replace(long, ladder=None),))
    page = render(story, live=False)
    assert "<script" not in page and 'class="panels"' not in page
    assert [one.partition(" ")[0] for one in _policy(page)][:2] == ["default-src", "style-src"]
    for there in ("2.4.3", PackageNotFoundError("bokeh")):
        monkeypatch.setattr(sys.modules["pam_ident.live"], "version", Mock(side_effect=[there]))
        assert render(story) == page


@pytest.mark.long
def test_markdown_holds_all_six_rungs(long):
    text, figures = render_markdown(Story("x", (long,)), "here")
    assert text.count("\n#### Step ") == 6 and len(figures) == 12
