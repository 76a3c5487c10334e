"""What lies on the bench: adding, removing, keeping."""

import tomllib
from html.parser import HTMLParser

import pytest

from pam_ident.core import DataError, Specimen, UsageError
from pam_ident.diagnosis import ranking
from pam_ident.records import read_record
from pam_ident.records.record import rebuilt
from pam_ident.records.specimen_file import specimen_toml
from pam_ident.tasks.setup import Setup
from pam_ident.workbench import words
from pam_ident.workbench.bench import Bench
from pam_ident.workbench.draft import read_dropped, safe_name


def test_an_effect_is_found_added_and_taken_out_again(begun):
    assert begun.diagnosis.selected == ("coulomb_friction",) and begun.first is begun.diagnosis
    assert begun.fit.rmse == pytest.approx(12.0, rel=0.1)  # all of the friction, nothing of the law
    added = begun.adding(begun.diagnosis.labels[0])
    assert added.fit.rmse == pytest.approx(1.0, rel=0.1) and added.diagnosis is None
    assert added.rungs[0] is begun.rungs[0], "what was fitted is not fitted again"
    assert added.ladder.rungs[-1].found is begun.diagnosis
    assert added.diagnosed().diagnosis.verdict == "adequate"
    again = added.removing("coulomb_friction")
    assert again.rungs == begun.rungs and again.setup.effects == ()
    with pytest.raises(UsageError, match="no effect 'creep'"):
        again.removing("creep")


def test_the_verdict_is_there_before_the_errors_of_every_candidate(begun):
    soon, late = begun.diagnosing()
    assert soon.diagnosis.verdict == late.diagnosis.verdict and soon.diagnosis.labels == late.diagnosis.labels
    first, last = (words.candidate_cards(one) for one in (soon, late))
    assert first[0]["title"] == last[0]["title"] == "Coulomb friction"
    assert {one.rmse_after for one in soon.diagnosis.ranking} == {None} and soon.diagnosis.next_experiment is None
    assert late.judged and not soon.judged, "what was stopped in between is taken up again"


def test_a_candidate_whose_fit_fails_leaves_no_error_to_tell(begun, monkeypatch):
    true = ranking._alone
    failed = "series_compliance"
    monkeypatch.setattr(
        ranking, "_alone", lambda model, *given: (1e87, 9.0) if failed in model.effect_names else true(model, *given)
    )
    late = begun.diagnosed()
    errors = {one.effect: (one.rmse_after, one.heldout_rmse_after) for one in late.diagnosis.ranking}
    assert errors.pop(failed) == (None, None) and None not in errors.pop("coulomb_friction")
    assert late.judged, "all that can be known is known"


def test_wrong_names_are_refused(begun):
    added = begun.adding("coulomb_friction:smooth")
    with pytest.raises(UsageError, match="unknown effect"):
        begun.adding("gremlins")
    with pytest.raises(UsageError, match="named twice"):
        added.adding("coulomb_friction")


def test_the_command_repeats_what_was_done(begun, folder):
    path = folder / "record.csv"
    assert begun.command == f"pam-ident compare {path} --law exponential_law"
    added = begun.adding("coulomb_friction:smooth")
    assert added.command == f"pam-ident add {path} --law exponential_law --effect coulomb_friction:smooth"


@pytest.mark.long
def test_the_report_tells_the_ladder_that_was_climbed(begun):
    fresh = Bench.begin(begun.record, begun.path, Setup("exponential_law"))
    with pytest.raises(UsageError, match="nothing to report yet"):
        fresh.report()
    page = begun.adding("viscous_damping").report()
    assert "viscous_damping" in page and begun.diagnosis.sentence in page
    assert "--effect viscous_damping" in page


def test_a_specimen_survives_its_file(tmp_path):
    given = Specimen('say "hi" \\ there', 199.5, 9.75, 25.4, None)
    table = tomllib.loads(specimen_toml(given))["specimen"]
    assert Specimen(**table) == given


def test_another_specimen_means_another_contraction_of_the_same_displacement(folder):
    record = read_record(folder / "record.csv")
    other = Specimen("long", 400.0, 10.0, 25.4)
    moved = rebuilt(record, other)
    assert moved.inputs.contraction == pytest.approx(record.inputs.contraction / 2)
    assert moved.inputs.displacement_mm == pytest.approx(record.inputs.displacement_mm)
    assert moved.specimen == other and moved.sha256 == record.sha256


@pytest.mark.parametrize(
    ("given", "safe"),
    [
        ("run 3.csv", "run 3.csv"),
        ("../../etc/passwd", "passwd"),
        ("C:\\temp\\run.csv", "run.csv"),
        ("..", "_"),
        (".hidden", "_hidden"),
        ("<img src=x>.csv", "_img src_x_.csv"),
        ("a;rm -rf $HOME.csv", "a_rm -rf _HOME.csv"),
        ("\u202egnp.csv", "_gnp.csv"),
        ("", "record.csv"),
    ],
)
def test_names_from_outside_are_only_names(given, safe):
    assert safe_name(given) == safe


def test_dropped_files_are_a_record_and_leave_nothing_behind(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    files = {name: (folder / name).read_bytes() for name in ("record.csv", "specimen.toml")}
    record, name = read_dropped(files, None)
    assert name == record.source == "record.csv" and record.specimen.name == "made"
    assert len(record) == len(read_record(folder / "record.csv")) and list(tmp_path.iterdir()) == []
    given = Specimen("typed", 200.0, 10.0, 25.4)
    assert read_dropped({"record.csv": files["record.csv"]}, given)[0].specimen == given
    assert read_dropped(files, given)[0].specimen.name == "made", "what was measured goes before what was typed"


def test_what_is_wrong_with_dropped_files_is_told_without_the_place_they_lay(folder):
    content = (folder / "record.csv").read_bytes()
    with pytest.raises(UsageError, match="no record among the files"):
        read_dropped({"specimen.toml": b""}, None)
    with pytest.raises(UsageError, match="same name"):
        read_dropped({"a/run.csv": content, "b/run.csv": content}, None)
    with pytest.raises(DataError, match=r"^specimen\.toml: no specimen file"):
        read_dropped({"run.csv": content}, None)
    with pytest.raises(DataError, match=r"^run\.csv") as caught:
        read_dropped({"run.csv": b"time_s,force_N\n0,1\n"}, Specimen())
    assert "/" not in str(caught.value).partition(":")[0]


class Seen(HTMLParser):
    """Tags that a browser would see."""

    def __init__(self, text):
        super().__init__()
        self.tags = set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags |= {tag, *(name for name, _ in attrs)}


def test_a_hostile_name_stays_text(folder):
    files = {name: (folder / name).read_bytes() for name in ("record.csv", "specimen.toml")}
    files["specimen.toml"] = files["specimen.toml"].replace(b'"made"', b"'<img src=x onerror=alert(1)>'")
    record, name = read_dropped(files, None)
    bench = Bench.begin(record, "<script>" + name, Setup("sarosi"))
    for text in (words.head(bench), words.verdict(bench), words.command(bench), words.parameters(bench)):
        assert not Seen(str(text)).tags & {"img", "script", "onerror"}
    assert "&lt;img" in words.head(bench) and "&lt;script" in words.command(bench)
    assert not Seen(str(words.error("<script>"))).tags & {"script"}
