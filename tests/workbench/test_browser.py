"""The workbench as a process, used in a real browser: the whole story, and nothing that leaves the machine."""

import http.client
import json
import os
import re
import signal
import subprocess
import sys
import urllib.request
from itertools import combinations

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


def drop(page, folder, *names):
    """Give files to the page."""
    page.locator("input[type=file]").set_input_files([folder / name for name in names])


def tried(page):
    """Wait until the candidates have been tried."""
    page.locator(".card .bar").first.wait_for()


def candidates(page):
    """Titles, probabilities and errors that the candidates would leave, in the order shown."""
    cards = page.get_by_role("group", name="Candidates").get_by_role("button").all()
    said = [(card.locator(".title").text_content(), card.locator(".text").text_content()) for card in cards]
    return [(title, text.split(" · ")[0], float(re.search(r"leaves ([\d.]+)", text)[1])) for title, text in said]


def error_now(page):
    """The present error in N, as the page tells it."""
    fact = page.locator("dl.facts div", has_text="error now").locator("dd")
    return float(re.match(r"[\d.]+", fact.text_content()).group())


def overlap(one, other):
    """Whether two boxes lie over each other by more than a pixel."""
    return all(
        min(one[k] + one[d], other[k] + other[d]) - max(one[k], other[k]) > 1
        for k, d in (("x", "width"), ("y", "height"))
    )


def specimen(page):
    """Type in the muscle where the draft asks for it."""
    for label, value in (("Initial length (mm)", "200"), ("Initial radius (mm)", "10"), ("Braid angle (°)", "25.4")):
        page.locator(".draft").get_by_label(label).fill(value)


def test_the_whole_story(opened, folder, tmp_path):
    drop(opened, folder, "record.csv", "specimen.toml")
    opened.get_by_text("Missing:").wait_for()
    assert error_now(opened) == pytest.approx(12.0, rel=0.1)
    assert "Missing: Coulomb friction" in opened.locator("p.lead").text_content()
    tried(opened)
    opened.get_by_role("button", name=re.compile("^Coulomb friction")).click()
    opened.get_by_text("Nothing is missing").wait_for()
    assert error_now(opened) == pytest.approx(1.0, rel=0.1)
    command = opened.locator("pre").text_content()
    assert re.fullmatch(r"pam-ident add record\.csv --law exponential_law --effect coulomb_friction\S*", command)
    with opened.expect_download() as download:
        opened.get_by_text("Save the report").click()
    download.value.save_as(tmp_path / "report.html")
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "coulomb_friction" in report and len(report) < 3_000_000
    opened.get_by_role("button", name="Remove Coulomb friction").click()
    opened.get_by_text("Missing:").wait_for()
    assert error_now(opened) == pytest.approx(12.0, rel=0.1)


def test_a_bad_file_is_told_and_does_no_harm(lying, folder, tmp_path):
    bad = tmp_path / "<img src=x onerror=alert(1)>.csv"
    bad.write_text("time_s,<b>force</b>\n0,1\n")
    lying.locator("input[type=file]").set_input_files([bad, folder / "specimen.toml"])
    alert = lying.get_by_role("alert")
    alert.wait_for()
    assert "csv" in alert.text_content() and lying.locator("p.error img, p.error b").count() == 0
    assert lying.locator(".draft img").count() == 0
    lying.get_by_role("button", name="Leave it").click()
    assert error_now(lying) == pytest.approx(12.0, rel=0.1)


def test_a_file_may_be_dropped_anywhere(opened, foreign):
    opened.evaluate(
        """(text) => {
          const given = new DataTransfer()
          given.items.add(new File([text], "rig.csv"))
          document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: given, bubbles: true, cancelable: true }))
        }""",
        (foreign / "rig.csv").read_text(encoding="utf-8"),
    )
    opened.get_by_text("What was dropped").wait_for()
    assert opened.get_by_label("AI0 is", exact=True).input_value() == "pressure"


def test_a_unit_slip_names_nothing(opened, folder, foreign):
    opened.locator("input[type=file]").set_input_files([foreign / "slip.csv", folder / "specimen.toml"])
    opened.get_by_role("alert").filter(has_text="nothing is named").wait_for()
    assert opened.get_by_role("button", name="Answer all the same").is_visible()
    assert opened.get_by_role("group", name="Candidates").get_by_role("button").count() == 0


def test_on_a_narrow_screen_what_was_dropped_stands_before_the_controls(opened, foreign):
    opened.set_viewport_size({"width": 500, "height": 900})
    drop(opened, foreign, "rig.csv")
    head = opened.get_by_text("What was dropped")
    head.wait_for()
    law = opened.get_by_label("Force law")
    assert head.bounding_box()["y"] < 450 < law.bounding_box()["y"]


@pytest.mark.parametrize("name", ["rig.csv", "deutsch.csv"])
def test_a_foreign_file_goes_from_drop_to_named_effect_by_mouse(name, opened, foreign, tmp_path):
    drop(opened, foreign, name)
    opened.get_by_text("What was dropped").wait_for()
    opened.get_by_label(re.compile("^Offset of (LoadCell|Kraft)")).wait_for()
    labels = [one.bounding_box() for one in opened.locator(".draft label").all()]
    assert len(labels) > 16 and not any(overlap(a, b) for a, b in combinations(labels, 2))
    specimen(opened)
    opened.get_by_role("button", name="Open with these columns").click()
    opened.get_by_text("Missing:").wait_for()
    assert error_now(opened) == pytest.approx(12.0, rel=0.15)
    for kind in ("specimen", "columns"):
        with opened.expect_download() as download:
            opened.get_by_text(f"Save {kind}.toml").click()
        download.value.save_as(tmp_path / f"{kind}.toml")
    (tmp_path / name).write_bytes((foreign / name).read_bytes())
    from pam_ident.records import read_record

    again = read_record(tmp_path / name)
    assert again.specimen.initial_length_mm == 200.0 and again.inputs.pressure.max() < 1.0


def test_a_foreign_file_goes_from_drop_to_named_effect_by_keyboard(opened, foreign):
    drop(opened, foreign, "rig.csv")  # a system's dialogue is its own
    opened.get_by_text("What was dropped").wait_for()
    press = opened.keyboard.press

    def tab_to(told):
        for _ in range(80):
            press("Tab")
            if told in opened.evaluate(FOCUSED):
                return
        raise AssertionError(f"the keyboard does not come to {told!r}")

    opened.locator("input[type=file]").focus()
    for label, value in (("Initial length (mm)", "200"), ("Initial radius (mm)", "10"), ("Braid angle (°)", "25.4")):
        tab_to(label)
        opened.keyboard.type(value)
    tab_to("Open with these columns")
    press("Enter")
    tried(opened)
    tab_to("Coulomb friction")
    opened.wait_for_function("() => Bokeh.documents[0].get_model_by_name('preview').get_column('x').length > 99")
    press("Enter")
    opened.get_by_text("Nothing is missing").wait_for()
    assert opened.evaluate(FOCUSED) != "", "the keyboard's place is kept"
    assert error_now(opened) == pytest.approx(1.0, rel=0.15)


FOCUSED = """() => {
  let one = document.activeElement
  while (one?.shadowRoot?.activeElement) one = one.shadowRoot.activeElement
  if (!one || one === document.body) return ""
  return [one.ariaLabel, one.innerText, ...[...(one.labels ?? [])].map((label) => label.innerText)].join(" ")
}"""


def test_candidates_stand_in_order_and_leave_what_they_say(lying):
    found = candidates(lying)
    chance = [{"< 1 %": 0.0, "> 99 %": 100.0}.get(p.removeprefix("probability ")) for _, p, _ in found]
    chance = [float(p.split()[1].rstrip("%")) if c is None else c for c, (_, p, _) in zip(chance, found, strict=True)]
    assert chance == sorted(chance, reverse=True) and sum(chance) <= 100.5
    unlikely = [left for c, (_, _, left) in zip(chance, found, strict=True) if c == 0.0]
    assert unlikely == sorted(unlikely)
    lying.get_by_role("button", name=found[0][0]).click()
    lying.get_by_text("Nothing is missing").wait_for()
    assert error_now(lying) == found[0][2]
    lying.get_by_role("group", name="Candidates").get_by_role("button").first.wait_for(state="detached")
    assert "exponential_law + coulomb_friction" in lying.get_by_text("misses the measurement").text_content()


def test_steps_are_undone_and_redone_and_outlive_a_reload(lying):
    lying.get_by_role("button", name=re.compile("^Coulomb friction")).click()
    lying.get_by_text("Nothing is missing").wait_for()
    lying.get_by_role("button", name="Undo").click()
    lying.get_by_text("Missing:").wait_for()
    assert error_now(lying) == pytest.approx(12.0, rel=0.1)
    lying.reload()
    lying.get_by_text("Missing:").wait_for()
    assert "/" not in lying.evaluate("location.pathname + location.search")[1:]
    lying.get_by_role("button", name="Redo").click()
    lying.get_by_text("Nothing is missing").wait_for()
    assert error_now(lying) == pytest.approx(1.0, rel=0.1)


def test_clicks_that_come_all_at_once_change_the_figures_too(lying):
    lying.get_by_role("button", name=re.compile("^Coulomb friction")).click()
    lying.get_by_text("Nothing is missing").wait_for()
    tabs = [lying.get_by_role("button", name=name).element_handle() for name in ("Parameters", "A against B")]
    undo = lying.get_by_role("button", name="Undo").element_handle()
    lying.evaluate("(all) => all.forEach((one) => one.click())", [*tabs, undo])
    lying.get_by_text("Missing:").wait_for()
    lying.wait_for_function(
        "() => [...Bokeh.documents[0]._all_models.values()].some((one) => "
        "one.type === 'ColumnDataSource' && Math.max(...(one.get_column('error') ?? [0])) > 10)"
    )


def test_the_story_stands_on_one_screen_in_plain_names(lying):
    lying.set_viewport_size({"width": 1400, "height": 900})
    for one in (lying.locator("canvas").nth(0), lying.locator("canvas").nth(1), lying.locator(".card .bar").first):
        box = one.bounding_box()
        assert box["y"] >= 0 and box["y"] + box["height"] <= 900
    names = lying.get_by_label("Another effect").locator("option").all_text_contents()
    assert 15 < len(names) < 30 and not any("_" in name for name in names)


def test_the_figures_zoom_together_and_tell_what_is_pointed_at(lying):
    ends = (
        "() => Bokeh.documents[0].get_model_by_name('traces') && [...Bokeh.documents[0]._all_models.values()]"
        ".filter((one) => one.type === 'Figure').map((one) => [one.x_range.start, one.x_range.end]).slice(0, 2)"
    )
    before = lying.evaluate(ends)
    lying.get_by_role("button", name="Zoom in").click()
    lying.wait_for_function(f"({ends})()[0][0] > {before[0][0]}")
    after = lying.evaluate(ends)
    assert after[0] == after[1] and after != before
    box = lying.locator("canvas").first.bounding_box()
    lying.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    for told in ("measured:", "model:", "error:", "of it follows something:"):
        lying.get_by_text(told, exact=True).first.wait_for()


def test_a_model_is_pinned_and_a_parameter_held(lying):
    part = lying.get_by_role("button", name="A against B")
    part.focus()
    part.press("Enter")
    assert lying.evaluate(FOCUSED).strip() == "A against B"
    lying.get_by_role("button", name="Pin this model as A").press("Enter")
    lying.get_by_label("Hold a parameter").select_option("mu")
    slider = lying.get_by_role("slider")
    slider.focus()
    before = error_now(lying)
    slider.press("End")
    lying.get_by_text("Parameters are held by hand").wait_for()
    for _ in range(100):
        if error_now(lying) > before:
            break
        lying.wait_for_timeout(100)
    assert error_now(lying) > before and lying.get_by_role("cell", name="exponential law").count() == 2
    lying.get_by_role("button", name="Release mu").click()
    lying.get_by_text("Missing:").wait_for()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_fault(scheme, opened, folder, foreign):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    opened.emulate_media(color_scheme=scheme)
    opened.reload()
    drop(opened, foreign, "rig.csv")
    opened.get_by_text("What was dropped").wait_for()
    told = faults(axe, opened)
    drop(opened, folder, "record.csv", "specimen.toml")
    tried(opened)
    opened.get_by_text("Specimen", exact=True).click()
    opened.get_by_label("Hold a parameter").select_option("mu")
    opened.get_by_role("slider").wait_for()
    told += faults(axe, opened)
    assert told == [], json.dumps(told, indent=1)


def faults(axe, page):
    """What axe finds that is serious, or nearly so, on a wide and on a narrow screen, where all of the page fits."""
    found = []
    for width in (1400, 500):
        page.set_viewport_size({"width": width, "height": 1000})
        page.wait_for_function("(width) => document.documentElement.scrollWidth <= width", arg=width)
        found += [
            (width, one["id"], one["impact"], [n["html"][:200] for n in one["nodes"]])
            for one in axe.run(page).response["violations"]
            if one["impact"] in ("serious", "critical", "moderate")
        ]
    return found


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
