"""The workbench as a process, used in a real browser: the whole story, and nothing that leaves the machine."""

import http.client
import json
import re
import urllib.request

import pytest
from hand import FOCUSED, candidates, drop, error_now, tried

pytest.importorskip("panel")
pytestmark = pytest.mark.browser


def test_the_whole_story(opened, folder, tmp_path):
    drop(opened, folder, "record.csv", "specimen.toml")
    opened.get_by_text("Missing:").wait_for()
    assert error_now(opened) == pytest.approx(12.0, rel=0.1)
    assert "Missing: Coulomb friction" in opened.locator("p.lead").text_content()
    tried(opened)
    bar = "(one) => [one.style.getPropertyValue('--share'), one.style.getPropertyValue('--noise')].map(Number)"
    assert opened.locator(".bar.large").evaluate(bar) == pytest.approx([1.0, 1 / 12], rel=0.1)
    opened.get_by_role("button", name=re.compile("^Coulomb friction")).click()
    opened.get_by_text("Nothing is missing").wait_for()
    assert error_now(opened) == pytest.approx(1.0, rel=0.1)
    assert opened.locator(".bar.large").evaluate(bar) == pytest.approx([1 / 12, 1 / 12], rel=0.1)
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


@pytest.mark.long
def test_a_candidate_that_is_pointed_at_draws_its_trace_into_the_error(lying):
    cards = lying.get_by_role("group", name="Candidates").get_by_role("button")
    drawn = """(key) => {
      const [traces, preview] = ["traces", "preview"].map((one) => Bokeh.documents[0].get_model_by_name(one))
      return String(preview.get_column("y")) === String(key ? traces.get_column(key) : [])
    }"""
    for k in (1, 0):
        cards.nth(k).hover()
        key = cards.nth(k).get_attribute("data-key")
        lying.wait_for_function(drawn, arg=key)
    assert key.startswith("coulomb_friction")
    lying.get_by_role("heading", name="pam-ident workbench").hover()
    lying.wait_for_function(drawn, arg="")


@pytest.mark.long
def test_candidates_stand_in_order_and_leave_what_they_say(lying):
    found = candidates(lying)
    chance = [{"< 1 %": 0.0, "> 99 %": 100.0}.get(p.removeprefix("probability ")) for _, p, _ in found]
    chance = [float(p.split()[1].rstrip("%")) if c is None else c for c, (_, p, _) in zip(chance, found, strict=True)]
    one, other, *rest = chance  # the first two are one group, of which each has the chance of all
    assert chance == sorted(chance, reverse=True) and one == other and one + sum(rest) <= 100.5
    unlikely = [left for c, (_, _, left) in zip(chance, found, strict=True) if c == 0.0]
    assert unlikely == sorted(unlikely)
    lying.get_by_role("button", name=found[0][0]).click()
    lying.get_by_text("Nothing is missing").wait_for()
    assert error_now(lying) == found[0][2]
    lying.get_by_role("group", name="Candidates").get_by_role("button").first.wait_for(state="detached")
    assert "The exponential law + Coulomb friction" in lying.get_by_text("misses the measurement").text_content()


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
def test_the_story_stands_on_one_screen_in_plain_names(lying):
    lying.set_viewport_size({"width": 1400, "height": 900})
    for one in (lying.locator("canvas").nth(0), lying.locator("canvas").nth(1), lying.locator(".card .bar").first):
        box = one.bounding_box()
        assert box["y"] >= 0 and box["y"] + box["height"] <= 900
    names = lying.get_by_label("Another effect").locator("option").all_text_contents()
    assert 15 < len(names) < 30 and not any("_" in name for name in names)


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
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
    opened.get_by_role("button", name="A against B").click()
    opened.get_by_role("button", name="Pin this model as A").click()
    opened.get_by_role("button", name="Release mu").click()
    opened.get_by_role("button", name=re.compile("^Coulomb friction")).click()
    opened.get_by_text("Nothing is missing").wait_for()
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


@pytest.mark.long
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
