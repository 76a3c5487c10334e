"""The page without a browser: its widgets are used as a person's clicks would use them."""

import threading
import time
from dataclasses import replace

import pytest

pn = pytest.importorskip("panel")

import pam_ident.tasks.diagnose as tasks_diagnose  # noqa: E402
from pam_ident.core import UsageError  # noqa: E402
from pam_ident.plot import failure_map  # noqa: E402
from pam_ident.plot.follows import COLOUR  # noqa: E402
from pam_ident.records import read_record  # noqa: E402
from pam_ident.tasks.diagnose import diagnosing_record  # noqa: E402
from pam_ident.tasks.setup import Setup  # noqa: E402
from pam_ident.workbench import Workbench, bench  # noqa: E402
from pam_ident.workbench.page import _found as found_of  # noqa: E402


@pytest.fixture(scope="module")
def first(folder):
    """A workbench with the record on it, its first work done."""
    made = Workbench(folder / "record.csv")
    made.wait()
    return made


@pytest.fixture
def page(first):
    """The same page, loaded again."""
    return Workbench(history=replace(first.history, steps=[*first.history.steps]))


def buttons(page, beginning):
    """Buttons whose name begins so."""
    found = page.page.select(lambda one: isinstance(one, pn.widgets.Button) and one.label.startswith(beginning))
    return {one.label: one for one in found}


def click(page, beginning):
    """Click the one button whose name begins so, and wait."""
    (button,) = buttons(page, beginning).values()
    button.clicks += 1
    page.wait()


def choose(page, cards, key):
    """Choose the card of a key, as a click of the browser does, and wait."""
    cards._handle_msg({"key": key})
    page.wait()


@pytest.mark.long
def test_the_story_from_verdict_to_adequate_and_back(page):
    assert "<b>Missing: Coulomb friction or friction that grows with pressure.</b>" in page.verdict.object
    first = page.candidates.items[0]
    assert first["key"].startswith("coulomb_friction") and first["kind"] == "named"
    assert first["text"].startswith(("probability 9", "probability > 99"))
    left = page.bench.previews[0].rmse
    choose(page, page.candidates, first["key"])
    assert page.bench.fit.rmse == left, "what a candidate would leave is what adding it leaves"
    assert "Nothing is missing" in page.verdict.object and page.candidates.items == []
    assert "--effect coulomb_friction" in page.side.command.object
    assert b"<html" in page.side.save.callback().read()
    choose(page, page.side.terms, "coulomb_friction")
    assert "Missing:" in page.verdict.object and "--effect" not in page.side.command.object
    assert page.side.terms.items == [] and len(page.history.steps) == 3


@pytest.mark.long
def test_undo_and_redo_show_what_was_found_and_a_new_step_forgets_what_was_undone(page):
    first = page.bench
    choose(page, page.candidates, page.candidates.items[0]["key"])
    added = page.bench
    choose(page, page.steps, "undo")
    assert page.bench is first and page.work is None and page.setup.effects == ()
    assert [item["title"] for item in page.steps.items] == ["Undo", "Redo", "Exponential law", "+ Coulomb friction"]
    choose(page, page.steps, "redo")
    assert page.bench is added
    choose(page, page.steps, "redo")
    assert page.bench is added, "there is nothing after it"
    choose(page, page.steps, "0")
    page._on_hold({"mu": 50.0})
    page.wait()
    page._on_hold({"mu": 51.0})
    page.wait()
    assert [one.held for one in page.history.steps] == [{}, {"mu": 51.0}], "a slider that moves on is one step"
    assert page.bench.fit.values["mu"] == 51.0 and page.bench.fit.rmse >= first.fit.rmse
    assert page.side.sliders.items[0]["name"] == "mu" and not page.find.visible
    page.side.sliders._handle_msg({"name": "mu", "value": None})
    page.wait()
    assert page.bench.held == {} and page.bench.diagnosis is not None


def test_what_the_likeliest_candidate_leads_to_is_found_before_it_is_chosen(page, monkeypatch):
    asked = []
    monkeypatch.setattr(bench, "diagnosing_record", lambda *given: asked.append(given) or diagnosing_record(*given))
    page.ahead.begin(page.bench, page.history)
    choose(page, page.candidates, page.candidates.items[0]["key"])
    assert "Nothing is missing" in page.verdict.object and not page.error.visible and page.candidates.items == []
    assert len(asked) == 1, "what is under way is waited for"


@pytest.mark.parametrize(("law", "effect"), [("sarosi", ""), ("exponential_law", "coulomb_friction")])
def test_the_error_of_a_step_on_5000_rows_takes_a_second_of_a_processor_and_waits_for_no_name(law, effect):
    setup = Setup("exponential_law")
    before = bench.Bench.begin(setup.read("hidden_effect"), "hidden_effect", setup)
    begun = time.process_time()
    step = before.adding(effect) if effect else bench.Bench.begin(before.record, "hidden_effect", Setup(law))
    _, shown = next(Workbench()._told(step))
    assert time.process_time() - begun < 1.0 and len(shown.record) > 4500
    assert shown.fit.rmse != before.fit.rmse and shown.diagnosis is None


@pytest.mark.long
def test_a_pinned_model_is_compared_and_what_was_done_outlives_the_page(page):
    click(page, "Pin this model")
    page.side.law.value = "sarosi"
    page.wait()
    assert "exponential law" in page.texts["against"].object and "six-parameter law" in page.texts["against"].object
    again = Workbench("no such file", history=page.history)
    assert again.bench is page.bench and again.side.law.value == "sarosi" and again.work is None


@pytest.mark.long
def test_what_is_drawn_is_the_record_also_without_a_clock(page):
    drawn = page.view.points.data
    assert list(drawn["error"]) == list(page.bench.fit.residual) and set(drawn["branch"]) == {
        "contraction",
        "extension",
    }
    assert list(page.view.traces.data) == ["x", *(one.label for one in page.bench.previews)]
    page.view.along.value = "contraction"
    assert list(page.view.points.data["x"]) == list(page.bench.record.inputs.contraction)
    page.side.example.value = "dmsp20_300"
    page.wait()
    assert {len(column) for column in page.view.points.data.values()} == {len(page.bench.record)}
    assert page.view.along.value == "sample" and page.view.x.end > len(page.bench.record) - 1


def test_the_map_and_the_bar_of_what_the_error_follows_are_those_of_the_report(page):
    shown = failure_map.data(page.bench.comparison)
    cells = failure_map.cells(shown)
    for branch, one in enumerate(page.view.maps):
        assert one.source.data["n"] == [cell.n for cell in cells if cell.place[0] == branch]
        assert one.figure.title.text == shown.branches[branch]
    assert all(COLOUR[one.what] in page.follows.object for one in page.bench.diagnosis.follows)


def test_a_grave_warning_stops_naming_until_it_is_answered_all_the_same(folder, tmp_path, monkeypatch):
    whole = tasks_diagnose.diagnosing  # one candidate is enough
    monkeypatch.setattr(tasks_diagnose, "diagnosing", lambda *given: whole(*given[:2], only=("coulomb_friction",)))
    lines = (folder / "record.csv").read_text().splitlines()
    rows = [line.rpartition(",") for line in lines[1:]]
    clipped = "\n".join([lines[0], *(f"{rest},{min(float(force), 500.0)}" for rest, _, force in rows)])
    (tmp_path / "record.csv").write_text(clipped + "\n", encoding="utf-8")
    (tmp_path / "specimen.toml").write_bytes((folder / "specimen.toml").read_bytes())
    page = Workbench(tmp_path / "record.csv")
    page.wait()
    assert page.anyway.visible and not page.find.visible and page.bench.diagnosis is None
    assert "nothing is named" in page.error.object
    click(page, "Answer all the same")
    assert page.bench.diagnosis is not None and not page.anyway.visible and not page.error.visible
    assert "--assume all" in page.side.command.object


@pytest.mark.long
def test_another_law_and_another_effect_by_name(page):
    page.side.law.value = "modified_chou_hannaford"
    page.wait()
    assert page.bench.fit.model.law.name == "modified_chou_hannaford"
    page.side.effect.value = "viscous_damping"
    click(page, "Add this effect")
    assert page.bench.fit.model.labels == ["viscous_damping"]
    page.side.geometry.value = True
    page.wait()
    assert page.bench.fit.model.free_geometry and page.bench.fit.model.labels == []


@pytest.mark.long
def test_files_that_are_dropped_take_the_place_of_the_record(page, folder):
    names = ["other.csv", "specimen.toml"]
    contents = [(folder / "record.csv").read_bytes(), (folder / "specimen.toml").read_bytes()]
    page.side.drop.param.update(filename=names, value=contents)
    page.wait()
    assert page.bench.path == "other.csv" and page.side.command.object.count("other.csv") == 1
    page.side.drop.param.update(filename=["bad.csv"], value=[b"time_s,force_N\n0,1\n"])
    page.wait()
    assert page.draft.panel.visible and "the pressure" in page.draft.head.object
    assert page.bench.path == "other.csv", "what lay on the bench stays there"
    page.side.drop.param.update(filename=["empty.csv"], value=[b""])
    page.wait()
    assert page.error.visible and "empty.csv" in page.error.object and page.bench.path == "other.csv"


def foreign(folder):
    """The record under headings that say little, pressure in bar, without a specimen."""
    lines = (folder / "record.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    names = lines[0].split(",")
    order = [names.index(name) for name in ("time_s", "pressure_MPa", "displacement_mm", "force_N")]
    made = ["t,AI0,LVDT,LoadCell"]
    for row in rows:
        t, p, x, force = (float(row[k]) for k in order)
        made.append(f"{t},{10.0 * p},{x},{force}")
    return ("\n".join(made) + "\n").encode()


@pytest.mark.long
def test_a_file_of_unknown_headings_without_a_specimen_is_opened_by_what_is_said_of_it(folder, tmp_path):
    page = Workbench()
    page.side.drop.param.update(filename=["run.csv"], value=[foreign(folder)])
    page.wait()
    assert page.draft.panel.visible and not page.error.visible and page.bench is None
    said = [(c.guess.quantity, c.guess.unit) for c in page.draft.draft.columns]
    assert said == [("time", "s"), ("pressure", "bar"), ("displacement", "mm"), ("force", "N")]
    click(page, "Open with these columns")
    assert page.error.visible and "specimen" in page.error.object
    fields = page.draft.form.fields
    for key, value in (("initial_length_mm", "200"), ("initial_radius_mm", "10,0"), ("braid_angle_deg", "eighty")):
        fields[key].value = value
    click(page, "Open with these columns")
    assert page.error.visible and "Braid angle (°): &#39;eighty&#39;; expected a number" in page.error.object
    fields["braid_angle_deg"].value = "80"
    click(page, "Open with these columns")
    assert page.error.visible and "5 to 54 degrees" in page.error.object and page.draft.panel.visible
    fields["braid_angle_deg"].value = "25.4"
    click(page, "Open with these columns")
    assert not page.error.visible and not page.draft.panel.visible
    assert page.bench.record.specimen.initial_length_mm == 200.0 and page.bench.diagnosis is not None
    (tmp_path / "run.csv").write_bytes(foreign(folder))
    for name, save in (("specimen.toml", page.side.save_specimen), ("columns.toml", page.side.save_columns)):
        (tmp_path / name).write_bytes(save.callback().read())
    again = read_record(tmp_path / "run.csv")
    assert (again.force == page.bench.record.force).all() and again.specimen.braid_angle_deg == 25.4


@pytest.mark.long
def test_another_specimen_is_typed_in_later(page):
    page.side.form.fields["braid_angle_deg"].value = "24"
    click(page, "Use this specimen")
    assert page.bench.record.specimen.braid_angle_deg == 24.0 and not page.error.visible
    assert b"braid_angle_deg = 24.0" in page.side.save_specimen.callback().read()


def test_work_is_stopped_by_its_button_and_taken_up_again(page):
    page.history.push(page.bench.adding("viscous_damping"))
    page._begin(lambda: found_of(page.bench))
    assert page.stop.visible and not page.find.visible
    page.stop.clicks += 1
    page.wait()
    assert page.bench.diagnosis is None and "stopped" in page.status.object and page.find.visible
    click(page, "Find what is missing")
    assert page.bench.diagnosis is not None and not page.find.visible


def test_a_fit_that_cannot_be_is_told_and_changes_nothing(page):
    before = page.bench
    page.side.effect.value = "thermal_softening"  # the record holds no temperature
    click(page, "Add this effect")
    assert page.error.visible and "temperature" in page.error.object and page.bench is before


def test_nothing_is_told_of_a_record_before_there_is_one(page):
    made = Workbench()
    made.wait()
    assert not made.right.visible and not made.follows.object
    assert page.right.visible and "<h2>What the error follows</h2>" in page.follows.object


@pytest.mark.long
def test_examples_are_records():
    page = Workbench()
    assert {"hidden_effect", "dmsp20_300"} <= set(page.side.example.options.values())
    page.side.example.value = "nothing_hidden"
    page.wait()
    assert "Nothing is missing" in page.verdict.object


def test_a_wrong_law_is_refused_before_the_page_is_made():
    with pytest.raises(UsageError, match="unknown law"):
        Workbench(law="no_such_law")


def test_the_browser_is_heard_only_between_changes_of_the_page(monkeypatch):
    page, heard = Workbench(), threading.Event()
    monkeypatch.setattr("panel.viewable.MimeRenderMixin._on_msg", lambda *_: heard.set())
    listener = threading.Thread(target=page.page._on_msg, args=("ref", None, None))

    def change():
        listener.start()
        assert not heard.wait(0.3)

    monkeypatch.setattr(page, "_look", change)
    page.look()
    assert heard.wait(30)
    listener.join()
