"""The page without a browser: its widgets are used as a person's clicks would use them."""

import threading

import pytest

pn = pytest.importorskip("panel")

import pam_ident.tasks.diagnose as tasks_diagnose  # noqa: E402
from pam_ident.core import UsageError  # noqa: E402
from pam_ident.workbench import Workbench  # noqa: E402


@pytest.fixture
def page(folder, undrawn):
    """A workbench with the record on it, its first work done."""
    made = Workbench(folder / "record.csv")
    made.wait()
    return made


@pytest.fixture
def undrawn(monkeypatch):
    """No pictures, which take longer than all else."""
    monkeypatch.setattr("pam_ident.workbench.page.pictures", lambda bench: {})


def buttons(page, beginning):
    """Buttons whose name begins so."""
    found = page.page.select(lambda one: isinstance(one, pn.widgets.Button) and one.label.startswith(beginning))
    return {one.label: one for one in found}


def click(page, beginning):
    """Click the one button whose name begins so, and wait."""
    (button,) = buttons(page, beginning).values()
    button.clicks += 1
    page.wait()


@pytest.mark.long
def test_the_story_from_verdict_to_adequate_and_back(folder):
    page = Workbench(folder / "record.csv")
    page.wait()
    assert "Effect missing" in page.verdict.object and "coulomb_friction" in page.verdict.object
    assert page.views["measured"].object.startswith("<svg") and not page.views["trace"].object
    (button,) = [b for name, b in buttons(page, "Add coulomb_friction").items()]
    assert button.color == "primary"
    click(page, "Add coulomb_friction")
    assert "Adequate" in page.verdict.object and "error of the law alone" in page.verdict.object
    assert page.views["falling"].object.startswith("<svg") and page.views["trace"].object.startswith("<svg")
    assert "--effect coulomb_friction" in page.side.command.object
    assert b"<html" in page._report_file().read()
    click(page, "Remove coulomb_friction")
    assert "Effect missing" in page.verdict.object and "--effect" not in page.side.command.object
    assert not buttons(page, "Remove") and not page.views["falling"].object


def test_a_grave_warning_stops_naming_until_it_is_answered_all_the_same(folder, undrawn, tmp_path, monkeypatch):
    whole = tasks_diagnose.diagnose  # one suspect is enough
    monkeypatch.setattr(tasks_diagnose, "diagnose", lambda *given: whole(*given[:-1], ("coulomb_friction",)))
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
    page.side.other.value = "viscous_damping"
    click(page, "Add this effect")
    assert page.bench.fit.model.labels == ["viscous_damping"]
    page.side.geometry.value = True
    page.wait()
    assert page.bench.fit.model.free_geometry and page.bench.fit.model.labels == []


def test_files_that_are_dropped_take_the_place_of_the_record(page, folder):
    names = ["other.csv", "specimen.toml"]
    contents = [(folder / "record.csv").read_bytes(), (folder / "specimen.toml").read_bytes()]
    page.side.drop.param.update(filename=names, value=contents)
    page.wait()
    assert page.bench.path == "other.csv" and page.side.command.object.count("other.csv") == 1
    page.side.drop.param.update(filename=["bad.csv"], value=[b"time_s,force_N\n0,1\n"])
    page.wait()
    assert page.error.visible and "bad.csv" in page.error.object
    assert page.bench.path == "other.csv", "what lay on the bench stays there"


def test_a_record_without_specimen_takes_the_one_that_is_typed(folder, undrawn):
    page = Workbench()
    page.side.drop.param.update(filename=["run.csv"], value=[(folder / "record.csv").read_bytes()])
    page.wait()
    assert page.error.visible and "specimen" in page.error.object and page.bench is None
    for key, value in (("initial_length_mm", "200"), ("initial_radius_mm", "10,0"), ("braid_angle_deg", "25.4")):
        page.side.fields[key].value = value
    page.side.drop.param.update(filename=["run.csv"], value=[(folder / "record.csv").read_bytes() + b"\n"])
    page.wait()
    assert not page.error.visible and page.bench.record.specimen.initial_length_mm == 200.0
    page.side.fields["braid_angle_deg"].value = "eighty"
    click(page, "Use this specimen")
    assert page.error.visible and "Braid angle (°): &#39;eighty&#39;; expected a number" in page.error.object
    page.side.fields["braid_angle_deg"].value = "80"
    click(page, "Use this specimen")
    assert page.error.visible and "5 to 54 degrees" in page.error.object
    page.side.fields["braid_angle_deg"].value = "24"
    click(page, "Use this specimen")
    assert page.bench.record.specimen.braid_angle_deg == 24.0 and not page.error.visible
    assert b"braid_angle_deg = 24.0" in page._specimen_file().read()


def test_work_is_stopped_by_its_button_and_taken_up_again(page):
    page.bench = page.bench.adding("viscous_damping")
    page._change(lambda bench: bench)
    assert page.stop.visible and not page.find.visible
    page.stop.clicks += 1
    page.wait()
    assert page.bench.diagnosis is None and "stopped" in page.status.object and page.find.visible
    click(page, "Find what is missing")
    assert page.bench.diagnosis is not None and not page.find.visible


def test_a_fit_that_cannot_be_is_told_and_changes_nothing(page):
    before = page.bench
    page.side.other.value = "thermal_softening"  # the record holds no temperature
    click(page, "Add this effect")
    assert page.error.visible and "temperature" in page.error.object and page.bench is before


def test_examples_are_records(undrawn):
    page = Workbench()
    assert {"hidden_effect", "dmsp20_300"} <= set(page.side.example.options.values())
    page.side.example.value = "nothing_hidden"
    page.wait()
    assert "Adequate" in page.verdict.object


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
