"""At the prompt the gate is the commands': what looks wrong is said, what is grave stops naming until it is assumed."""

import pickle

import pytest

import pam_ident as pam
from pam_ident.core import UsageError
from pam_ident.tasks.gate import GraveDoubt, Refused

SPECIMEN = {"name": "made", "initial_length_mm": 200.0, "initial_radius_mm": 10.0, "braid_angle_deg": 25.4}
LAW = "exponential_law"


@pytest.fixture(scope="module")
def clipped(frame):
    """The record with its force at the amplifier's limit."""
    return pam.read(frame.assign(force_N=frame["force_N"].clip(upper=700.0)), specimen=SPECIMEN)


def test_what_is_grave_stops_naming_and_is_said_of_a_fit(clipped, tmp_path):
    for verb in (pam.diagnose, pam.ladder, lambda *given: pam.report(*given, out=tmp_path / "page.html")):
        with pytest.raises(GraveDoubt, match="nothing is named") as stopped:
            verb(clipped, LAW)
    assert not (tmp_path / "page.html").exists()
    again = pickle.loads(pickle.dumps(stopped.value))
    assert (str(again), again.n, again.doubts) == (str(stopped.value), len(clipped), stopped.value.doubts)
    for found in (pam.fit(clipped, LAW), pam.compare(clipped, LAW)):
        assert "WARNING (force_clipped)" in repr(found)
        assert "WARNING (force_clipped)" in found._repr_html_()
        assert found.to_json()["warnings"][0]["code"] == found.warnings[0].code == "force_clipped"


@pytest.mark.long
def test_what_is_assumed_is_named(clipped):
    found = pam.diagnose(clipped, LAW, assume="all", only="coulomb_friction")
    assert found.warnings[0].grave and repr(found).startswith("WARNING (force_clipped)")
    assert found.to_json()["warnings"][0]["grave"] is True
    with pytest.raises(UsageError, match="assume='clip': expected all or one of"):
        pam.diagnose(clipped, LAW, assume=["clip"])


def test_the_kind_of_test_can_be_said(frame, tmp_path):
    told = pam.read(frame, specimen=SPECIMEN, kind="isotonic")
    with pytest.raises(Refused, match="an isotonic test"):
        pam.diagnose(told, LAW)
    lines = [f"{key} = {value!r}" for key, value in SPECIMEN.items()]
    (tmp_path / "muscle.toml").write_text("\n".join(['kind = "isotonic"', "[specimen]", *lines]), encoding="utf-8")
    with pytest.raises(Refused, match="an isotonic test"):
        pam.diagnose(pam.read(frame, specimen=tmp_path / "muscle.toml"), LAW)


def test_what_was_left_out_is_a_warning(frame):
    holed = frame.copy()
    holed.loc[7, "force_N"] = None
    assert [one.code for one in pam.fit(pam.read(holed, specimen=SPECIMEN), LAW).warnings] == ["empty_cells"]
