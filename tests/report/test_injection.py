"""Names, headers, comments, files and effects of a stranger stay text in every format.

Two records of the same numbers are reported, one with kind names and one with hostile ones. Both pages must have the
same elements with the same attributes, so that nothing hostile became markup.
"""

import base64
import gzip
import re
from html.parser import HTMLParser

import pytest

from pam_ident.report.markdown import code, escape
from pam_ident.report.words import plain
from pam_ident.tasks.report import report_record
from pam_ident.tasks.setup import REFIT, Setup

HOSTILE = {
    "script": "</script><script>alert(1)</script>",
    "handler": '"><img src=x onerror=alert(1)>',
    "svg": "</svg></title></style><svg onload=alert(1)>",
    "link": "[click](javascript:alert(1)) ![x](http://evil.example/x.png) <http://evil.example> https://evil.example",
    "markdown": "` ``` | ~~x~~ **bold** $x^2$ # no heading",
    "jinja": "{{ 7 * 7 }} {% raw %} ${7*7}",
    "turned": "abc\u202egpj.exe \u2066\x07\x1b[31m",
    "sheet": "=HYPERLINK(1)",
}
KIND = dict.fromkeys(HOSTILE, "kind")

EFFECT = """
import numpy as np

from pam_ident.core import Param
from pam_ident.effects import AddsForce, Effect

SIZE = Param("W", "N", {doc!r}, -100.0, 100.0, scale=5.0)
WAVE = lambda i, s, f: np.sin(40.0 * i.contraction)[:, None]
EFFECT = Effect("mine", {title!r}, {source!r}, (AddsForce({form!r}, {formula!r}, (SIZE,), WAVE),), test="none",
                warning={warning!r})
"""


def write(folder, record, words):
    """The made-up record as a file with a comment, headers, a specimen and an effect full of `words`; its path."""
    folder.mkdir()
    x = record.inputs
    time, pressure, force = (words[k].replace(",", "") for k in ("script", "handler", "svg"))
    head = f'"{time} t","{pressure.replace(chr(34), chr(34) * 2)} p",x,"{force} f"\n'
    rows = "".join(
        f"{t:.6f},{p:.6f},{d:.6f},{f:.6f}\n"
        for t, p, d, f in zip(x.time, x.pressure, x.displacement_mm, record.force, strict=True)
    )
    path = folder / f"{words['handler']}.csv"
    path.write_text(f"# {words['script']} {words['link']}\n{head}{rows}", encoding="utf-8")

    (folder / "columns.toml").write_text(
        f"[columns]\ntime_s = '''{time} t'''\npressure_MPa = '''{pressure} p'''\n"
        f"displacement_mm = 'x'\nforce_N = '''{force} f'''\n",
        encoding="utf-8",
    )
    name = words["link"] + words["script"] + words["markdown"]
    (folder / "specimen.toml").write_text(
        f"[specimen]\nname = '''{name}'''\ninitial_length_mm = 200.0\ninitial_radius_mm = 10.0\n"
        "braid_angle_deg = 25.0\n",
        encoding="utf-8",
    )
    (folder / "mine.py").write_text(
        EFFECT.format(
            doc=words["turned"],
            title=words["script"] + words["link"],
            source=words["svg"],
            form=words["handler"] + words["turned"],
            formula=words["jinja"] + words["markdown"],
            warning=words["sheet"] + words["link"],
        ),
        encoding="utf-8",
    )
    return path


@pytest.fixture(scope="module")
def told(record, tmp_path_factory):
    """What the three formats say by kind of words: HTML and Markdown as text, and the figures' folder."""
    folder, found = tmp_path_factory.mktemp("stranger"), {}
    for which, words in (("kind", KIND), ("hostile", HOSTILE)):
        path = write(folder / which, record, words)
        form = words["handler"] + words["turned"]
        own = (f"mine:{form}",), (str(folder / which / "mine.py"),)
        setup = Setup("modified_chou_hannaford", *own, heldout=REFIT)
        for suffix in ("html", "md"):
            out = folder / which / f"{words['handler']} (a) [b].{suffix}"
            report_record(str(path), setup, str(out))
            found[which, suffix] = out.read_text(encoding="utf-8")
        found[which, "figures"] = sorted(out.with_name(f"{out.stem}_figures").iterdir())
    return found


class Elements(HTMLParser):
    """The tags with the names of their attributes, inside and outside of figures, what is loaded, and all scripts."""

    def __init__(self, text):
        super().__init__()
        self.page, self.drawn, self.loads, self.scripts, self.depth = [], set(), [], [], 0
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.depth += tag == "svg"
        one = (tag, tuple(sorted(name for name, _ in attrs)))
        self.loads += [value for name, value in attrs if name in ("href", "src", "srcset", "action", "xlink:href")]
        if self.depth:
            self.drawn.add(one)
        else:
            self.page.append(one)

    def handle_data(self, data):
        if self.cdata_elem == "script":
            self.scripts.append(data)

    def handle_endtag(self, tag):
        self.depth -= tag == "svg"


@pytest.mark.long
def test_the_page_of_a_stranger_has_the_elements_of_a_friend_s(told):
    kind, hostile = (Elements(told[which, "html"]) for which in ("kind", "hostile"))
    assert len(kind.page) > 300
    assert hostile.page == kind.page
    assert hostile.drawn <= kind.drawn
    assert {"img", "iframe"}.isdisjoint(tag for tag, _ in hostile.page)
    assert [one for one in hostile.page if one[0] == "script"] == [("script", ("id", "type"))] * 2 + [("script", ())]
    bokeh, figures, script = hostile.scripts
    assert [bokeh, script] == [kind.scripts[0], kind.scripts[2]]
    drawn = gzip.decompress(base64.b64decode(figures, validate=True)).decode()
    assert '"type":"object"' in drawn
    for words in ("alert", "evil", "onerror", "7*7", "HYPERLINK", "kind"):
        assert words not in drawn, words
    assert all(load.startswith("#") for load in hostile.loads)
    for words in ("&lt;script&gt;alert(1)&lt;/script&gt;", "onerror=alert(1)&gt;", "{{ 7 * 7 }}"):
        assert words in told["hostile", "html"], words
    assert not re.search("[\u202a-\u202e\u2066-\u2069\x07\x1b]", told["hostile", "html"])


@pytest.mark.long
def test_the_markdown_of_a_stranger_has_the_elements_of_a_friend_s(told):
    from markdown_it import MarkdownIt

    reader = MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"])
    kind, hostile = (Elements(reader.render(told[which, "md"])) for which in ("kind", "hostile"))
    assert len(kind.page) > 300 and ("table", ()) in kind.page
    assert hostile.page == kind.page
    assert all(".svg" in load and "%20%28a%29%20%5Bb%5D_figures/" in load for load in hostile.loads)
    assert not re.search(
        "(?<!:)https?://", told["hostile", "md"].replace(told["hostile", "md"].split("    pam-ident")[-1], "")
    )


@pytest.mark.long
def test_the_figures_of_a_stranger_hold_no_element_of_his(told):
    assert told["kind", "figures"]
    for kind, hostile in zip(told["kind", "figures"], told["hostile", "figures"], strict=True):
        one, other = (Elements(path.read_text(encoding="utf-8")) for path in (kind, hostile))
        assert other.drawn <= one.drawn
        assert all(load.startswith(("#", "data:image/png;base64,")) for load in other.loads)


@pytest.mark.long
@pytest.mark.browser
def test_the_pdf_of_a_stranger_has_neither_script_nor_address(told, chromium, monkeypatch):
    from pam_ident.report import to_pdf

    monkeypatch.setenv("PAM_IDENT_BROWSER", chromium)
    pdf = to_pdf(told["hostile", "html"])
    assert pdf.startswith(b"%PDF-")
    for word in (b"/JavaScript", b"/JS", b"/URI", b"/Launch", b"/OpenAction", b"/EmbeddedFile"):
        assert word not in pdf, word


@pytest.mark.long
@pytest.mark.browser
def test_the_interactive_figures_of_a_stranger_do_no_harm(told, page, tmp_path):
    path, said = tmp_path / "stranger.html", []
    path.write_text(told["hostile", "html"], encoding="utf-8")
    page.on("dialog", lambda dialog: (said.append(dialog.message), dialog.dismiss()))
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: said.append(request.url))
    page.goto(path.as_uri())
    page.locator("figure.live").nth(1).wait_for(state="attached")
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    for rung in page.get_by_role("radio").all():
        rung.check(force=True)
        for figure in page.locator("figure.live .panels:visible").all():
            figure.hover()
    assert said == [path.as_uri()]
    assert page.locator("script").count() == 4, "those of the page, and Bokeh's"


@pytest.mark.long
@pytest.mark.browser
def test_a_script_that_slips_in_is_not_run(told, page, tmp_path):
    """Even if a text were not escaped: the page's policy names the two scripts that may run."""
    path, said = tmp_path / "slipped.html", []
    slipped = "<script>document.title = 'slipped'</script><img src=x onerror=\"document.title = 'slipped'\">"
    path.write_text(told["hostile", "html"].replace("<main ", slipped + "<main "), encoding="utf-8")
    page.on("console", lambda message: said.append(message.text))
    page.goto(path.as_uri())
    page.locator("figure.live").nth(1).wait_for(state="attached")
    assert page.title() != "slipped" and any("script" in one for one in said)


@pytest.mark.parametrize(
    "word", [*HOSTILE.values(), "1. no list", "- no list", "--- no rule", "+ x", "===", ": x", "a\n\n# b"]
)
def test_any_text_is_one_paragraph_of_that_text(word):
    from markdown_it import MarkdownIt

    tokens = MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"]).parse(escape(word))
    assert [t.type for t in tokens] == ["paragraph_open", "inline", "paragraph_close"]
    assert {child.type for child in tokens[1].children} <= {"text", "text_special"}
    assert "".join(child.content for child in tokens[1].children) == " ".join(plain(word).split())


def test_numbers_are_left_as_they_are():
    assert [escape(n) for n in ("6.34 N", "−5", "0.5", "1e−3", "12")] == ["6.34 N", "−5", "0.5", "1e−3", "12"]


def test_a_command_stays_code():
    assert code("a\n```\n\nb") == "    a\n    ```\n    \n    b"
