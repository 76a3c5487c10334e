"""Files given to the workbench in a real browser: from any heading to a named effect, by mouse and by keyboard."""

import re
from itertools import combinations

import pytest
from hand import FOCUSED, drop, error_now, overlap, specimen, tried

pytest.importorskip("panel")
pytestmark = pytest.mark.browser


@pytest.mark.long
def test_what_was_said_of_a_file_is_kept_and_corrected_by_menus(opened, foreign):
    drop(opened, foreign, "rig.csv")
    opened.get_by_text("What was dropped").wait_for()
    unit, draft = opened.get_by_label("Unit of AI0"), opened.locator(".draft")
    unit.select_option("MPa")
    draft.get_by_label("Initial length (mm)").fill("200")
    opened.get_by_role("button", name="Open with these columns").click()
    opened.get_by_role("alert").filter(has_text="braid angle").wait_for()
    assert unit.input_value() == "MPa" and draft.get_by_label("Initial length (mm)").input_value() == "200"
    specimen(opened)
    opened.get_by_role("button", name="Open with these columns").click()
    opened.get_by_role("alert").filter(has_text="nothing is named").wait_for()
    opened.get_by_role("button", name="Columns and units").click()
    unit.select_option("bar")
    opened.get_by_role("button", name="Open with these columns").click()
    opened.get_by_text("Missing:").wait_for()
    assert error_now(opened) == pytest.approx(12.0, rel=0.15)


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


@pytest.mark.long
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


@pytest.mark.long
def test_a_unit_slip_names_nothing(opened, folder, foreign):
    opened.locator("input[type=file]").set_input_files([foreign / "slip.csv", folder / "specimen.toml"])
    opened.get_by_role("alert").filter(has_text="nothing is named").wait_for()
    assert opened.get_by_role("button", name="Answer all the same").is_visible()
    assert opened.get_by_role("group", name="Candidates").get_by_role("button").count() == 0


@pytest.mark.long
def test_on_a_narrow_screen_what_was_dropped_stands_before_the_controls(opened, foreign):
    opened.set_viewport_size({"width": 500, "height": 900})
    drop(opened, foreign, "rig.csv")
    head = opened.get_by_text("What was dropped")
    head.wait_for()
    law = opened.get_by_label("Force law")
    assert head.bounding_box()["y"] < 450 < law.bounding_box()["y"]


@pytest.mark.long
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
