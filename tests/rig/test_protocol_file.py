"""Protocol files: what the rig makes of them, and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import UsageError
from pam_ident.rig import Plan, Protocol, Secret, make_record
from pam_ident.rig.muscle import ChouHannaford, RigMuscle, RigSpecimen
from pam_ident.rig.protocol_file import KEYS, read_protocol
from pam_ident.tasks.rig import run_protocol

SPECIMEN = RigSpecimen()
CHOU = RigMuscle(SPECIMEN, ChouHannaford(SPECIMEN))
LEAST = "[protocol]\npressures_MPa = [0.2, 0.4]\nspeeds_mm_s = [5]\n"


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "p.toml"
        path.write_text(text)
        return path

    return write


def test_a_file_says_all_that_the_rig_can_do(written):
    text = LEAST + (
        "cycles_per_speed = 2\nstroke_mm = [5, 30]\nhold_s = [1, 10]\nmove_rows = 20\nhold_rows = [4, 8]\n"
        "minor_loops_mm = [1, 3]\nwarming_K = 15\ngap_s = 30\n"
    )
    assert all(key in text for key in KEYS)
    expected = Protocol(
        (0.2, 0.4), (5.0,), 2, (1.0, 10.0), 20, (4, 8), 30.0, stroke_mm=(5.0, 30.0), minor_loops_mm=(1.0, 3.0),
        warming_K=15.0,
    )  # fmt: skip
    assert read_protocol(written(text)) == expected
    assert read_protocol(written(LEAST)).holds == ((0.0, 0),)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speeds = 3\n", "no table [protocol]"),
        ("[protocol]\nspeeds_mm_s = [5]\n", "lacks pressures_MPa"),
        ("[protocol\n", "not a readable TOML file"),
        (LEAST + "pressure = 3\n", "pressure is not known"),
        (LEAST.replace("[5]", "5"), "speeds_mm_s = 5; expected a list"),
        (LEAST.replace("[5]", "[]"), "speeds_mm_s = []"),
        (LEAST.replace("[5]", "[-5]"), "above zero"),
        (LEAST + "stroke_mm = [30, 5]\n", "stroke_mm"),
        (LEAST + "stroke_mm = [1, 2, 3]\n", "[from, to]"),
        (LEAST + "move_rows = 2.5\n", "move_rows = 2.5; expected a count"),
        (LEAST + 'hold_s = "long"\n', "hold_s = 'long'; expected seconds"),
        (LEAST + "hold_s = [1, 10]\nhold_rows = [1, 2, 3]\n", "hold_rows"),
        (LEAST + "hold_s = 0.2\n", "at least 0.5 s"),
        (LEAST + "warming_K = true\n", "warming_K = True; expected kelvin"),
        (LEAST + "minor_loops_mm = [0]\n", "minor_loops_mm"),
    ],
)
def test_a_bad_file_is_refused_with_its_key_and_what_was_expected(written, text, said):
    path = written(text)
    with pytest.raises(UsageError) as refused:
        read_protocol(path)
    assert str(path) in str(refused.value) and said in str(refused.value)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(UsageError, match="no such file"):
        read_protocol(tmp_path / "none.toml")


def test_holds_follow_in_turn_and_strokes_stay_within_their_ends():
    protocol = Protocol((0.2, 0.4), (5.0,), 3, (1.0, 10.0, 2.0), 20, (4, 8, 4), stroke_mm=(5.0, 30.0))
    course = protocol.run(CHOU, np.random.default_rng(0))
    assert len(course.rows) == 2 * 6 * 20 + 2 * 2 * (4 + 8 + 4)
    x = course.eps[course.rows] * 200.0
    assert x.min() == pytest.approx(5.0) and x.max() == pytest.approx(30.0)
    rest = (course.moving == 0) & (course.count > 0)
    begins = np.flatnonzero(rest & ~np.roll(rest, 1))
    ends = np.flatnonzero(rest & ~np.roll(rest, -1))
    first = course.isobar[begins] == 0
    lasts = (course.time[ends] - course.time[begins])[first]
    np.testing.assert_allclose(lasts[:5], [1.0, 10.0, 2.0, 1.0, 10.0], atol=0.05)  # the gap follows the last


def test_minor_loops_run_from_the_middle_of_the_stroke():
    protocol = Protocol((0.4,), (5.0,), 2, 0.0, 20, 0, stroke_mm=(0.0, 40.0), minor_loops_mm=(1.0, 10.0))
    course = protocol.run(CHOU, np.random.default_rng(0))
    assert len(course.rows) == (4 + 2 + 8) * 20
    moves = (course.eps[course.rows] * 200.0).reshape(14, 20)
    ends = [(40, 0), (0, 40)] * 2 + [(40, 20)] + [(20, 21), (21, 20)] * 2 + [(20, 30), (30, 20)] * 2
    np.testing.assert_allclose(moves[:, [0, -1]], [*ends, (20, 40)], atol=1e-9)


def test_the_heater_warms_until_the_middle_and_lets_cool():
    time = np.linspace(20.0, 120.0, 101)
    warm = Protocol(warming_K=15.0).heating(time)
    assert warm[50] == pytest.approx(15.0) == warm.max() and warm[[0, -1]] == pytest.approx(0.0, abs=1e-12)
    plain, warmed = (Protocol((0.3, 0.4, 0.5), (10.0,), warming_K=rise) for rise in (0.0, 15.0))
    heated, plain = (make_record(Plan(3, protocol=p)) for p in (warmed, plain))
    gap = heated.column("temperature_C") - plain.column("temperature_C")
    assert gap.max() == pytest.approx(15.0, abs=0.05)


def test_a_seed_is_the_same_muscle_under_any_protocol():
    secret = Secret("creep", "prony_2", 2.0)
    standard, short = (Plan(7, secrets=(secret,), protocol=p) for p in ("standard", Protocol((0.3, 0.5), (10.0,))))
    one, other = make_record(standard), make_record(replace(short, warming=True))
    assert one.muscle == other.muscle
    assert one.hidden[0].size == other.hidden[0].size and one.hidden[0].settings == other.hidden[0].settings
    assert len(other.table) == 2 * 6 * 52 != len(one.table) == 4680


def test_a_run_writes_record_specimen_and_sealed_answer(written, tmp_path):
    truth = run_protocol(tmp_path / "x", written(LEAST), "exponential_law", ["creep:prony_2", "rub"], 4, 2.0)
    assert truth["truth"] == ["creep"] and truth["unknown"] == "rub" and truth["forms"]["creep"] == "prony_2"
    assert json.loads((tmp_path / "x" / "truth.json").read_text()) == [json.loads(json.dumps(truth))]
    assert {f.name for f in (tmp_path / "x").iterdir()} == {"record.csv", "specimen.toml", "truth.json"}


@pytest.mark.parametrize(
    ("law", "effects", "said"),
    [
        ("hooke", [], "law 'hooke'"),
        ("exponential_law", ["gravity"], "effect 'gravity'"),
        ("exponential_law", ["creep:odd"], "form 'odd'"),
        ("exponential_law", ["rub", "mount_slip"], "one unknown"),
    ],
)
def test_what_the_rig_cannot_hide_is_refused(written, tmp_path, law, effects, said):
    with pytest.raises(UsageError, match=said):
        run_protocol(tmp_path / "x", written(LEAST), law, effects)


def test_a_pressure_without_a_stroke_is_refused(written, tmp_path):
    path = written(LEAST.replace("0.2", "0.02") + "stroke_mm = [20, 40]\n")
    with pytest.raises(UsageError, match=str(path)):
        run_protocol(tmp_path / "x", path, "exponential_law")


def test_a_run_is_written_many_times_over_with_fresh_noise_and_a_clock_that_goes_on(written, tmp_path):
    protocol = written(LEAST)
    once = run_protocol(tmp_path / "once", protocol, "exponential_law", ["coulomb_friction"], 4)
    thrice = run_protocol(tmp_path / "thrice", protocol, "exponential_law", ["coulomb_friction"], 4, times=3)
    n = once["n"]
    assert thrice["n"] == 3 * n and thrice["repeats"] == 3 and thrice["sizes"] == once["sizes"]
    one, three = (np.loadtxt(tmp_path / k / "record.csv", delimiter=",", skiprows=1) for k in ("once", "thrice"))
    np.testing.assert_array_equal(three[:n], one)
    assert (tmp_path / "thrice" / "record.csv").read_bytes().startswith((tmp_path / "once" / "record.csv").read_bytes())
    assert np.all(np.diff(three[:, 0]) > 0.0) and three[n, 0] - three[n - 1, 0] >= 20.0
    for k in (1, 2):
        off = three[k * n : (k + 1) * n, 5] - one[:, 5]
        assert np.std(off) == pytest.approx(2.0 * np.sqrt(2.0), rel=0.15)  # noise of 2 N, twice
        np.testing.assert_array_equal(three[k * n : (k + 1) * n, 1:3], one[:, 1:3])
    again = run_protocol(tmp_path / "again", protocol, "exponential_law", ["coulomb_friction"], 4, times=3)
    assert again == thrice | {"case": "again"}
    assert (tmp_path / "again" / "record.csv").read_bytes() == (tmp_path / "thrice" / "record.csv").read_bytes()
    with pytest.raises(UsageError, match="--repeat 0"):
        run_protocol(tmp_path / "none", protocol, "exponential_law", times=0)
    assert not (tmp_path / "none").exists()
