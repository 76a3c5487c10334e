"""The page says what the story holds, loads nothing, escapes everything, and is well formed."""

import html
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib.figure import Figure

from pam_ident.diagnosis.compare import compare
from pam_ident.diagnosis.nouns import Pattern
from pam_ident.effects import get_effect
from pam_ident.fitting import fit, fit_isobars, loop_energies
from pam_ident.fitting.identifiability import AT_BOUND
from pam_ident.model import Model
from pam_ident.report import Section, Story, render, tables
from pam_ident.report.easel import Easel
from pam_ident.report.opening import answer, opening
from pam_ident.report.parts import parts
from pam_ident.report.svg import embed, inline
from pam_ident.report.words import number, standing, stderr

VOID = {"meta", "img", "br", "hr", "link", "input", "wbr"}
PROVENANCE = {
    "file": "made.csv",
    "date": "2026-01-02",
    "versions": {"pam-ident": "0.1.0", "numpy": "9.9"},
    "command": "pam-ident report made.csv --law modified_chou_hannaford --out made.html",
}


class Page(HTMLParser):
    """Collects tags, ids, text and headings, and checks that tags close in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.ids, self.loads, self.heads, self.text = [], [], [], [], [], ""
        self.links = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.note(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.note(tag, attrs)

    def note(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        for key, value in attrs:
            if key == "id":
                self.ids.append(value)
            if key in ("src", "href", "action", "data", "poster", "srcset"):
                self.loads.append(value)
        if re.fullmatch("h[1-6]", tag):
            self.heads.append(int(tag[1]))

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]} at {self.getpos()}"
        self.open.pop()

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("style", "script"):
            self.text += data


@pytest.fixture(scope="session")
def section(record, diagnosis, ladder):
    law = Model.build("exponential_law")
    return Section(
        record,
        compare(diagnosis.base),
        replace(diagnosis, pattern=Pattern("local", "contraction", 12.0, "mm", 0.25, "A rub at 12 mm.")),
        compare(diagnosis.best),
        ladder,
        (fit_isobars(law, record, ("contraction", "extension")),),
        loop_energies(record, record.force),
        loop_energies(record, diagnosis.best.force),
        ("The record holds <two> isobars only.",),
    )


@pytest.fixture(scope="session")
def text(section):
    return render(Story("A report & more", (section,), PROVENANCE))


@pytest.fixture(scope="session")
def parsed(text):
    return Page(text)


def test_the_badge_does_not_contradict_the_end_of_the_ladder(section, ladder):
    """The demo's map was badged `a known effect explains` where the terminal said unknown_effect."""
    ends = {"adequate": "Missing effect", "missing_effect": "Missing effect", "unknown_effect": "Unknown effect"}
    for verdict, word in ends.items():
        told = replace(section, ladder=replace(ladder, last=replace(ladder.last, verdict=verdict)))
        assert opening(told, Easel("a", 100)).badge[0] == word, verdict
    alone = Section(section.record, section.comparison, replace(section.diagnosis, verdict="adequate", selected=()))
    assert opening(alone, Easel("a", 100)).badge[0] == "Adequate"


def test_is_well_formed(parsed, text):
    assert text.lstrip().startswith("<!DOCTYPE html>")
    assert parsed.open == []
    assert parsed.heads.count(1) == 1
    assert parsed.heads[0] == 1
    assert all(b <= a + 1 for a, b in zip(parsed.heads, parsed.heads[1:], strict=False))
    assert ("html", {"lang": "en"}) in parsed.tags
    assert len(parsed.ids) == len(set(parsed.ids))


def test_loads_nothing(parsed, text):
    assert parsed.loads
    for address in parsed.loads:
        assert address.startswith(("#", "data:image/png;base64,")), address
    for address in parsed.loads:
        assert not address.startswith("#") or address[1:] in parsed.ids, address
    assert [set(attrs) for tag, attrs in parsed.tags if tag == "script"] == [{"type", "id"}] * 2 + [set()]
    assert not {"link", "iframe", "object", "embed", "base"} & {tag for tag, _ in parsed.tags}
    assert "@import" not in text
    assert not re.search(r"url\(\s*['\"]?(?!#)", text)


def test_svg_references_stay_inside_the_page(parsed, text):
    found = set(re.findall(r"url\(#([^)]+)\)", text))
    assert found and found <= set(parsed.ids)


def test_opens_with_what_is_missing_in_plain_words(parsed, diagnosis):
    """The answer and its figures first, then the details, then the contents: a stranger reads from the top."""
    body = parsed.text
    order = [
        "Missing: Coulomb friction or friction that grows with pressure.",
        "With that added",
        "Before: ",
        "The error as effects are added",
        "follows the direction of motion",
        "How sure: Coulomb friction 97\u00a0%",
        "This record cannot tell apart: Coulomb friction; ",
        "What to do next: repeat the strokes at 0.1 MPa.",
        "Details of made up",
        "The answer in numbers",
        "Measured (points)",
        "Mean error (N) in each cell",
        "This record cannot tell apart: Coulomb friction; ",
        "Repeat the strokes at 0.1 MPa.",
        "halves the error",
        "Why it was added",
        "A rub at 12 mm.",
        "Parameters of the completed model",
        "Each isobar fitted alone, contraction",
        "Energy taken up in one loop",
        "The record holds <two> isobars only.",
        "Missing effect",
        PROVENANCE["command"],
    ]
    place = 0
    for piece in order:
        assert piece in body[place:], piece
        place = body.index(piece, place) + len(piece)


def test_what_the_answer_says_is_what_was_found(section, diagnosis):
    """One effect more that nobody knows, none at all, or a group: the first lines change with it."""
    last = replace(diagnosis, verdict="unknown_effect", next_experiment=None)
    more = replace(section, ladder=replace(section.ladder, last=last))
    assert opening(more, Easel("x", 50)).heading == (
        "Missing: Coulomb friction or friction that grows with pressure. "
        "Something is left that no known effect explains."
    )
    unsure = replace(diagnosis, ranking=tuple(replace(one, probability=0.6) for one in diagnosis.ranking))
    assert opening(replace(section, diagnosis=unsure), Easel("x", 50)).heading.startswith("Probably missing: Coulomb")
    none = replace(diagnosis, verdict="adequate", selected=(), groups=(), best=diagnosis.base, next_experiment=None)
    part = opening(Section(section.record, section.comparison, none), Easel("x", 50))
    assert part.heading == "Nothing is missing that this record could show." and len(part.pictures) == 2
    assert part.notes[-1] == "What to do next: use the model; its parameters are below."
    unknown = replace(none, verdict="unknown_effect")
    part = opening(Section(section.record, section.comparison, unknown), Easel("x", 50))
    assert part.heading == "Something is left that no known effect explains."


def test_a_parameter_at_its_bound_is_said_beside_the_answer(section):
    after = section.after
    stuck = replace(after.estimates[0], at_bound=True, verdict=AT_BOUND)
    told = replace(section.comparison_after, fit=replace(after, given=(stuck, *after.estimates[1:])))
    notes = opening(replace(section, comparison_after=told), Easel("x", 50)).notes
    assert [one for one in notes if one.startswith(f"{stuck.name} = ") and "bound" in one]


def test_what_a_diagnosis_names_and_a_ladder_leaves_out_is_said_all_the_same(section):
    found = section.diagnosis
    less = next(one for one in found.ranking if one.effect not in found.selected)
    doubtful = [replace(one, probability=0.6) if one is less else one for one in found.ranking]
    more = replace(found, selected=(*found.selected, less.effect), ranking=tuple(doubtful))
    said = f" Probably missing: {get_effect(less.effect)[0].title}."
    heading = opening(replace(section, diagnosis=more), Easel("x", 50)).heading
    assert said in heading and heading.replace(said, "") == opening(section, Easel("x", 50)).heading
    assert "With that added" not in answer(replace(section, diagnosis=more))


def test_something_unknown_is_said_with_what_it_follows(section):
    last = replace(
        section.ladder.last, verdict="unknown_effect", pattern=Pattern("other", "time", None, "", 0.5, "a swing")
    )
    found = replace(section, ladder=replace(section.ladder, last=last))
    assert opening(found, Easel("x", 50)).heading.endswith("no known effect explains: a swing.")


def test_noise_and_held_out_error_are_the_same_all_over_the_page(section):
    """The ladder's last model tells the noise, and what is held out is held out the same way."""
    found = replace(section, ladder=replace(section.ladder, noise_floor=0.789))
    first, numbers = parts(found, "x", 50)[:2]
    assert "the noise is about 0.789 N" in answer(found) and first.text[0] in answer(found)
    facts = dict(numbers.facts)
    assert facts["noise"] == "0.789 N" and not numbers.text
    assert f"held-out error: {facts['held-out error']}." in first.notes[0]


def test_each_parameter_has_value_unit_and_standing(diagnosis):
    for one in (diagnosis.base, diagnosis.best):
        rows = {row[0]: row for row in tables.parameters(one, "x").rows}
        assert set(rows) == set(one.values)
        for estimate in one.estimates:
            _, value, error, unit, status, _ = rows[estimate.name]
            assert float(value.replace("−", "-")) == pytest.approx(estimate.value, abs=0.06 * estimate.stderr)
            assert float(error.replace("−", "-")) == pytest.approx(estimate.stderr, rel=0.06)
            if "e" not in error:
                assert len(value.partition(".")[2]) == len(error.partition(".")[2]), "digits are those of the error"
            assert (unit, status) == (estimate.unit, "determined")


def test_parameters_are_on_the_page(text, diagnosis):
    for estimate in diagnosis.best.estimates:
        cells = re.search(rf'<th scope="row">{re.escape(estimate.name)}</th>(.*?)</tr>', text)
        assert cells
        assert f">{estimate.unit}</td>" in cells[1]


def test_no_standard_error_where_nothing_is_determined(diagnosis):
    loose = replace(diagnosis.best.estimates[0], identified=False, stderr=0.123)
    assert stderr(loose) == "not determined"
    assert standing(loose) == "not determined by this record"
    assert standing(replace(loose, identified=True, at_bound=True)) == "at its bound"
    broken = replace(diagnosis.best, given=(loose, *diagnosis.best.estimates[1:]))
    row = tables.parameters(broken, "x").rows[0]
    assert "0.12" not in " ".join(row)


def test_numbers():
    assert [number(v, 3) for v in (None, float("nan"), 0.0, -1.2345, 1234.5, 0.00123, 3e-9)] == [
        "–",
        "–",
        "0",
        "−1.23",
        "1234",
        "0.00123",
        "3.00e−09",
    ]


def test_ladder_and_candidate_tables(diagnosis, ladder):
    table = tables.ladder(ladder)
    assert table.rows[1][:3] == ("1", "+ Coulomb friction (coulomb_friction)", str(len(diagnosis.best.model.params)))
    assert table.rows[1][3] == number(diagnosis.best.rmse, 3)
    assert table.rows[1][6] == "halves the error"
    rows = tables.candidates(diagnosis).rows
    assert rows[0][:3] == ("Coulomb friction (coulomb_friction)", "selected", "97 %")
    assert rows[3][1:5] == ("absorbed by the law", "–", "–", "–")


def test_isobar_tables_have_the_shape_of_the_paper(record):
    shown = tables.isobars(fit_isobars(Model.build("exponential_law"), record, ("contraction", "extension")))
    assert [t.head[:4] for t in shown[:2]] == [("pressure (MPa)", "a (N)", "b (N)", "c (N)")] * 2
    assert [row[0] for row in shown[0].rows] == ["0.5", "0.3"]
    assert shown[2].head == ("coefficient", "contraction", "extension")
    assert [row[0] for row in shown[2].rows] == ["a", "b", "c"]
    assert "a0" in [row[0] for row in shown[3].rows]


@pytest.mark.long
def test_a_loop_that_gives_energy_back_is_named(section):
    wrong = replace(section, loop_model={0.3: -0.2, 0.5: 0.1})
    assert "gives energy back" in tables.loops(wrong).rows[0][3]
    body = Page(render(Story("x", (wrong,)))).text
    assert "The model gives energy back at 0.3 MPa" in body
    assert section.loop_model[0.5] > 0


def test_tables_and_figures_can_be_read_aloud(parsed):
    tags = parsed.tags
    count = [tag for tag, _ in tags]
    assert count.count("caption") == count.count("table") > 5
    assert all("scope" in attrs for tag, attrs in tags if tag == "th")
    svgs = [attrs for tag, attrs in tags if tag == "svg"]
    assert len(svgs) == count.count("figure") == count.count("figcaption") == 9
    assert all(a["role"] == "img" and a["aria-label"] for a in svgs)


@pytest.mark.long
def test_hostile_names_stay_text(section, diagnosis):
    bad = "<script>alert(1)</script>"
    candidate = replace(diagnosis.ranking[0], label=bad, why=bad)
    hostile = replace(
        section,
        record=replace(section.record, name=bad, source=bad, columns={"force": bad}),
        diagnosis=replace(
            section.diagnosis,
            sentence=bad,
            ranking=(candidate, *diagnosis.ranking[1:]),
            pattern=Pattern("local", bad, 12.0, '"><b>', 0.1, bad),
        ),
        warnings=(bad,),
    )
    text = render(Story(bad, (hostile,), {bad: bad, "command": bad}))
    assert "<script>alert" not in text and text.count("<script") == 3
    assert '"><b>' not in text
    assert html.escape(bad) in text
    assert Page(text).open == []


@pytest.mark.long
def test_size_and_several_records(section, text):
    assert len(text.encode()) < 1_500_000
    many = render(Story("many", (section,) * 3, PROVENANCE))
    assert len(many.encode()) < 3_000_000
    page = Page(many)
    assert len(page.ids) == len(set(page.ids))
    assert page.heads.count(1) == 1


@pytest.mark.long
def test_adequate_record_needs_no_second_model(section, diagnosis):
    plain = Section(
        section.record,
        section.comparison,
        replace(diagnosis, verdict="adequate", selected=(), labels=(), groups=(), best=diagnosis.base),
    )
    page = Page(render(Story("plain", (plain,))))
    assert "Nothing is missing that this record could show." in page.text
    assert "Parameters of the completed model" not in page.text
    offered = [one for one in diagnosis.ranking if one.status == "candidate"]
    details = page.text.partition("What was not judged")[2]
    assert offered and details and not [one.effect for one in offered if f"({one.label})" in page.text]
    assert "Candidates" not in page.text and "would leave" not in page.text
    assert all(f"({one.label})" in details for one in diagnosis.ranking if one.status != "candidate")
    assert page.open == []


@pytest.mark.long
def test_a_ladder_without_a_step_is_neither_drawn_nor_stepped_through(section, text, diagnosis, ladder):
    low = replace(ladder, rungs=ladder.rungs[:1])
    alone = replace(diagnosis, verdict="adequate", selected=(), labels=(), groups=(), best=diagnosis.base)
    page = render(Story("low", (Section(section.record, section.comparison, alone, ladder=low),)), live=False)
    assert f"No effect was added to the law, which leaves {number(diagnosis.base.rmse, 3)} N rms." in Page(page).text
    assert 'class="steps"' not in page.partition("<body>")[2] and page.count("<figure ") == 5
    assert "<dd>8.30 N</dd>" in page and "<dd>8.30 N → 0.550 N</dd>" in text


def test_a_static_table_can_be_reported(table):
    one = fit(Model.build("modified_chou_hannaford"), table)
    from pam_ident.diagnosis.nouns import Diagnosis

    answer = Diagnosis(one, one, "unknown_effect", (), (), (), (), 1.0, 2.0, 2.0, None, None, "Something is left.")
    page = Page(render(Story("table", (Section(table, compare(one), answer),))))
    assert "Unknown effect" in page.text
    assert "Something is left." in page.text


def test_a_heavy_figure_becomes_a_picture():
    figure = Figure((2, 2))
    figure.subplots().plot(np.arange(3000), np.random.default_rng(1).normal(size=3000), "o")
    assert embed(figure, "a", "label").startswith("<svg")
    heavy = embed(figure, "a", 'a "label"', max_bytes=1000)
    assert heavy.startswith('<img role="img" alt="a &#34;label&#34;" src="data:image/png;base64,')


def test_inline_svg_keeps_references_and_drops_the_rest():
    svg = (
        '<?xml version="1.0"?><svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        'viewBox="0 0 9 9" width="9pt"><metadata>x</metadata><defs><style>*{}</style>'
        '<path id="m" d="M 0.123456 1"/></defs>'
        '<g id="lost" clip-path="url(#m)"><use xlink:href="#m" x="1.000001" y="2" style="fill: red"/>'
        '<use xlink:href="#m" x="3" y="2" style="fill: red"/></g><use xlink:href="http://x.y/z"/></svg>'
    )
    assert inline(svg, "p", "say") == (
        '<svg viewBox="0 0 9 9" role="img" aria-label="say" style="stroke-linejoin:round;stroke-linecap:butt">'
        '<defs><path id="p-0" d="M 0.12 1" /></defs><g clip-path="url(#p-0)" style="fill: red">'
        '<use href="#p-0" x="1" y="2" /><use href="#p-0" x="3" y="2" /></g><use /></svg>'
    )


def test_isobars_are_switched_off_one_by_one(text):
    switches = re.findall(r'id="(r1f\d+-s\d)" checked><label for="\1">([\d.]+ MPa)</label>', text)
    assert [word for _, word in switches] == ["0.3 MPa", "0.5 MPa"]
    assert text.count('class="isobar-1"') == text.count('class="isobar-2"') > 2
    assert ".isobar-2 { display: none; }" in text and ".isobar-3 {" not in text


def test_words_are_readable_on_a_dark_screen_too_and_paper_stays_light(text):
    style = text.partition("<style>")[2].partition("</style>")[0]
    light, dark = (dict(re.findall(r"--(\w+): (#\w{6})", rule)) for rule in re.findall(r":root \{([^}]+)\}", style))
    assert light.keys() == dark.keys() and style.count("#") - style.count("url(#") == len(light) + len(dark)
    assert "@media screen and (prefers-color-scheme: dark) {\n  :root" in style
    for colours in (light, dark):
        for words in ("ink", "soft", "blue"):
            assert min(contrast(colours[words], colours[ground]) for ground in ("paper", "pale")) > 4.5


def contrast(one, other):
    """Of two colours, after the Web Content Accessibility Guidelines 2.2."""
    parts = np.array([[int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)] for colour in (one, other)])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    dark, light = sorted(linear @ [0.2126, 0.7152, 0.0722])
    return (light + 0.05) / (dark + 0.05)
