"""A report is written in the format its name asks for, whole or not at all."""

import re
import sys

import pytest
from markupsafe import escape

from pam_ident.core import UsageError
from pam_ident.diagnosis import compare
from pam_ident.report import Section, Story, render, render_markdown, to_pdf
from pam_ident.report.render import page
from pam_ident.tasks import report as task
from pam_ident.tasks.setup import Setup

PROVENANCE = {"date (UTC)": "2026-01-02", "command": "pam-ident report made.csv --out made.md"}
SETUP = Setup("modified_chou_hannaford")


@pytest.fixture(scope="module")
def story(record, diagnosis, ladder):
    section = Section(record, compare(diagnosis.base), diagnosis, compare(diagnosis.best), ladder)
    return Story("A report", (section,), PROVENANCE)


@pytest.fixture
def quick(story, monkeypatch):
    """The task with its computing replaced by the made-up section."""

    class Read(Setup):
        def read(self, record):
            return story.sections[0].record

    monkeypatch.setattr(task, "build_section", lambda *_: story.sections[0])
    return Read("modified_chou_hannaford")


@pytest.mark.long
def test_markdown_holds_the_same_parts_in_the_same_order(story):
    text, figures = render_markdown(story, "here")
    page = render(story)
    heads = re.findall(r"<h([1-4]) id[^>]*>(.*?)</h\1>", page)
    assert [(len(m), h) for m, h in re.findall(r"^(#+) (.*)$", text.replace("\\", ""), re.M)][1:] == [
        (int(level), head) for level, head in heads
    ]
    assert re.findall(r"\]\((.*?)\)", text) == [f"here/{name}" for name in figures]
    assert len(figures) == page.count("<figure ") and all("<svg" in one for one in figures.values())
    assert story.sections[0].diagnosis.sentence.replace("_", "\\_") in text
    assert f"    {PROVENANCE['command']}" in text and "| date (UTC) | 2026-01-02 |" in text


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "kind", "start"),
    [
        ("a", None, "<!DOCTYPE"),
        ("a.txt", "md", "# made up"),
        ("a.html", None, "<!DOCTYPE"),
        ("a.MD", None, "# made up"),
    ],
)
def test_the_name_or_the_wish_gives_the_format(quick, tmp_path, name, kind, start):
    story = task.report_record("made.csv", quick, str(tmp_path / name), kind)
    text = (tmp_path / name).read_text(encoding="utf-8")
    assert text.lstrip().startswith(start)
    assert (f"--format {kind}" in text) == (kind is not None)
    assert story.title == "made up: modified Chou–Hannaford law"
    figures = tmp_path / "a_figures"
    assert figures.is_dir() == start.startswith("#")
    assert {path.name for path in tmp_path.iterdir()} <= {name, "a_figures"}


@pytest.mark.long
def test_figures_are_replaced_as_a_whole_or_not_at_all(quick, tmp_path, monkeypatch):
    out, figures = tmp_path / "a.md", tmp_path / "a_figures"
    figures.mkdir()
    (figures / "figure_99.svg").write_text("old")
    out.write_text("old")

    def fails(*_):
        raise OSError("no space left")

    with monkeypatch.context() as broken:
        broken.setattr(task, "write_whole", fails)
        with pytest.raises(OSError, match="no space left"):
            task.report_record("made.csv", quick, str(out))
    assert [path.name for path in figures.iterdir()] == ["figure_99.svg"] and out.read_text() == "old"
    task.report_record("made.csv", quick, str(out))
    assert (figures / "figure_01.svg").is_file() and not (figures / "figure_99.svg").exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.md", "a_figures"]


def test_a_folder_of_other_files_is_left_alone(quick, tmp_path):
    (tmp_path / "a_figures").mkdir()
    (tmp_path / "a_figures" / "mine.png").write_text("mine")
    with pytest.raises(UsageError, match="no folder of figures"):
        task.report_record("made.csv", quick, str(tmp_path / "a.md"))
    with pytest.raises(UsageError, match=r"ending in \.html"):
        task.report_record("made.csv", quick, str(tmp_path / "a.docx"))
    with pytest.raises(UsageError, match="expected one of html, md, pdf"):
        task.report_record("made.csv", quick, str(tmp_path / "a.html"), "docx")
    assert [path.name for path in tmp_path.iterdir()] == ["a_figures"]


@pytest.mark.browser
def test_a_pdf_is_printed_by_a_browser(quick, tmp_path, chromium, monkeypatch):
    monkeypatch.setenv("PAM_IDENT_BROWSER", chromium)
    task.report_record("made.csv", quick, str(tmp_path / "a.pdf"))
    pdf = (tmp_path / "a.pdf").read_bytes()
    assert pdf.startswith(b"%PDF-") and len(pdf) < 3_000_000
    assert re.search(rb"/MediaBox \[0 0 59[45]\S* 84[12]\S*\]", pdf)  # A4
    assert b"/StructTreeRoot" in pdf  # tagged, for screen readers
    assert [path.name for path in tmp_path.iterdir()] == ["a.pdf"]


def test_without_a_browser_it_says_what_to_do_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("PAM_IDENT_BROWSER", raising=False)
    with pytest.raises(UsageError, match=r"none is on PATH; install one, set PAM_IDENT_BROWSER .* print it"):
        task.report_record("nowhere.csv", SETUP, str(tmp_path / "a.pdf"))
    monkeypatch.setenv("PAM_IDENT_BROWSER", "no-such-browser")
    with pytest.raises(UsageError, match="PAM_IDENT_BROWSER=no-such-browser"):
        task.report_record("nowhere.csv", SETUP, str(tmp_path / "a.pdf"))


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
@pytest.mark.parametrize(
    ("script", "words"),
    [("exit 1", "made no PDF; set"), ("exec sleep 60", "made no PDF in 0.5 s"), (None, "cannot be run")],
)
def test_a_browser_that_fails_is_told_of(tmp_path, monkeypatch, script, words):
    browser = tmp_path / "browser"
    browser.write_bytes(b"\x00\x01" if script is None else f"#!/bin/sh\n{script}\n".encode())
    browser.chmod(0o755)
    monkeypatch.setenv("PAM_IDENT_BROWSER", str(browser))
    with pytest.raises(UsageError, match=words) as told:
        to_pdf("<p>x", tmp_path, patience_s=0.5)
    assert "open it and print it" in str(told.value)
    assert list(tmp_path.iterdir()) == [browser]


def test_a_command_on_any_page_can_be_copied():
    command = "pam-ident against a.csv b.csv --where 'pressure_MPa > 0.1 N'"
    assert f"<pre><code>{escape(command)}</code></pre>" in page("two", [], {"command": command})
