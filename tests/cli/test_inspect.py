"""`inspect` counts what is in a record and advises on what is not; `effects` lists; `rig` writes."""

import json
import math

import pytest


def test_what_was_read(ask, clean):
    text = ask("inspect", clean).stdout
    assert "1200 samples, 3 pressures, 0.2 to 0.4 MPa" in text
    assert "pressure from 'pressure_MPa'" in text and "braid angle 25.4°, wall 1.5 mm" in text
    assert "strokes     24, at 3, 30 mm/s" in text
    assert "4 at most on one isobar" in text
    assert "contraction 600, extension 600 samples" in text


def test_a_good_record_gets_little_advice(ask, clean):
    advice = ask("inspect", clean).stdout.partition("Advice:")[2].strip().splitlines()
    assert len(advice) == 1 and "no temperature" in advice[0]


def change(path, write_record, edit):
    lines = path.read_text().splitlines()
    rows = [row for k, line in enumerate(lines[1:]) if (row := edit(k, *map(float, line.split(","))))]
    return write_record(lines[0] + "\n" + "".join(",".join(f"{v:.6f}" for v in row) + "\n" for row in rows))


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (lambda k, t, p, x, f: (t, p, 3.2 * x, f), "beyond 0.35"),
        (lambda k, t, p, x, f: (t, p, x - 12.0, f), "zero of the displacement"),
        (lambda k, t, p, x, f: (t, p, x, max(f, 250.0)), "clipped"),
        (lambda k, t, p, x, f: (t, p + 0.015 * math.sin(k / 17), x, f), "not isobaric"),
        (lambda k, t, p, x, f: (t, p, x, f - 600.0), "cannot push"),
        (lambda k, t, p, x, f: (t, 0.3 + 0.0 * p, x, f), "1 pressure level:"),
        (lambda k, t, p, x, f: (t, p + 0.101325, x, f), "may be absolute"),
        (lambda k, t, p, x, f: (t, p - 0.3, x, f), "below the air's"),
        (lambda k, t, p, x, f: (t, 10 * p, x, f), "bar and MPa (10)"),
        (lambda k, t, p, x, f: (t, p / 10, x, f), "bar and MPa (10)"),
        (lambda k, t, p, x, f: (t, 14.5 * p, x, f), "psi and bar (14.5)"),
        (lambda k, t, p, x, f: (t, p, x, 100 * f), "(100)"),
        (lambda k, t, p, x, f: (t, p, x, f / 1000), "kN and N (1000)"),
        (lambda k, t, p, x, f: (t, p, 24.0 - x, f), "rises with the contraction"),
        (lambda k, t, p, x, f: (t, p, x, -f), "cannot push"),
        (lambda k, t, p, x, f: (t, p, x / 10, f), "Check the unit of the displacement"),
        (lambda k, t, p, x, f: (t + 50.0 * (k > 130), p, x, f), "the time jumps within an isobar (1 times)"),
        (lambda k, t, p, x, f: None if (k // 50) % 2 else (t, p, x, f), "extension branch is missing"),
    ],
    ids=[
        "long",
        "stretched",
        "clipped",
        "wandering",
        "pushing",
        "one pressure",
        "absolute",
        "below the air",
        "pressure times 10",
        "pressure over 10",
        "psi",
        "force times 100",
        "kilonewtons",
        "displacement turned",
        "force turned",
        "centimetres",
        "time jumps",
        "one branch",
    ],
)
def test_advice_on_what_looks_wrong(ask, clean, write_record, edit, words):
    assert words not in ask("inspect", clean).stdout
    result = ask("inspect", change(clean, write_record, edit))
    assert result.exit_code == 0 and words in result.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"speeds": (10.0,)}, "one stroke speed"),
        ({"cycles": 1, "speeds": (10.0,)}, "no repeated cycle"),
        ({"cycles": 2, "speeds": (10.0,)}, "two cycles"),
    ],
)
def test_advice_on_what_is_lacking(ask, clean, write_record, options, words):
    assert words not in ask("inspect", clean).stdout
    assert words in ask("inspect", write_record(**options)).stdout


@pytest.mark.parametrize(("drift", "told"), [(0.0, False), (4.0, False), (30.0, True)])
def test_a_load_cell_that_drifts_between_tares(ask, clean, write_record, drift, told):
    lines = clean.read_text().splitlines()
    rows = [list(map(float, line.split(","))) for line in lines[1:]]
    end = rows[-1][0]
    tares = [
        [[t + 0.1 * k, 0.0, 0.0, zero + 0.1 * (-1) ** k] for k in range(20)] for t, zero in ((-5, 0), (end + 5, drift))
    ]
    text = "\n".join([lines[0], *(",".join(f"{v:.6f}" for v in row) for row in [*tares[0], *rows, *tares[1]])])
    advice = ask("inspect", write_record(text + "\n")).stdout
    assert ("the force drifts by 30" in advice) is told and ("drifts" in advice) is told


def test_what_was_read_of_a_pattern_and_a_folder(ask, clean, tmp_path):
    lines = clean.read_text().splitlines(keepends=True)
    (tmp_path / "specimen.toml").write_text(clean.with_name("specimen.toml").read_text())
    for k in range(3):
        (tmp_path / f"p{k}.csv").write_text("".join([lines[0], *lines[1 + 400 * k : 401 + 400 * k]]))
    whole = [line for line in ask("inspect", clean).stdout.splitlines()[1:] if not line.startswith("written")]
    for given in (tmp_path, f"{tmp_path}/p*.csv"):
        told = ask("inspect", given).stdout.splitlines()
        assert told[0].startswith(str(given))
        assert any(line.startswith("written     3 files, p0.csv to p2.csv, as text (utf-8), commas") for line in told)
        assert [line for line in told if not line.startswith(("written", str(tmp_path)))] == whole


def test_advice_on_a_static_table(ask, root):
    text = ask("inspect", root / "datasets" / "dmsp20_300" / "record.csv").stdout
    assert "66 rows marked as slack" in text and "no time column" in text and "no branches" in text


def test_effects_are_listed_and_shown(ask):
    text = ask("effects").stdout
    for name in ("coulomb_friction", "bladder_elasticity_printed", "force_drift"):
        assert f"\n{name}: " in f"\n{text}"
    one = ask("effects", "show", "bladder_elasticity_printed").stdout
    assert "Warning: the printed form" in one and "source: equation (2)" in one
    forms = ask("effects", "show", "coulomb_friction").stdout
    assert "form stribeck" in forms and "F_c" in forms and "mm/s" in forms


def test_an_effect_of_ones_own_is_listed(ask, tmp_path):
    own = tmp_path / "own.py"
    own.write_text(
        "from pam_ident.core import Param\n"
        "from pam_ident.effects import AddsForce, Effect\n"
        "FORM = AddsForce('textbook', 'A', (Param('A', 'N', 'size', -1.0, 1.0),), lambda i, s, f: f[:, None])\n"
        "EFFECT = Effect(name='of_my_own', title='Mine', source='here', test='look', forms=(FORM,))\n"
    )
    assert "of_my_own" in ask("effects", "--effect-file", own).stdout
    assert "Mine" in ask("effects", "--effect-file", own, "show", "of_my_own").stdout
    assert "of_my_own" not in ask("effects").stdout


def test_rig_writes_sealed_records(ask, tmp_path):
    result = ask("rig", tmp_path / "set", "--n", 1, "--seed", 3, "--only", "null")
    assert result.exit_code == 0, result.output
    assert len(json.loads((tmp_path / "set" / "truth.json").read_text())) == 1
    assert ask("inspect", tmp_path / "set" / "c000" / "record.csv").exit_code == 0


def test_rig_refuses_what_it_does_not_know(ask, tmp_path):
    result = ask("rig", tmp_path / "set", "--only", "magic")
    assert result.exit_code == 2 and "magic" in result.stderr and not (tmp_path / "set").exists()


def test_what_stops_naming_is_told_first_and_apart(ask, clean, write_record):
    told = ask("inspect", change(clean, write_record, lambda k, t, p, x, f: (t, p, x, 100 * f)))
    grave, _, harmless = told.stdout.partition("Stops naming")[2].partition("Advice:")
    assert told.exit_code == 0 and "- scale: " in grave and "(100)" in grave and "no temperature" in harmless
    assert "diagnose, ladder and report take --assume CODE" in told.stdout
    assert "(100)" not in harmless and "Stops naming" not in ask("inspect", clean).stdout


def test_a_log_whose_time_was_passed_over_says_so_and_gets_no_names_until_it_is_meant(ask, answer, clean, write_record):
    told = write_record(clean.read_text().replace("time_s", "AI7"))
    inspected, found = answer("inspect", told)
    assert "passed over 'AI7'" in inspected.stdout and found["passed_over"] == ["AI7"]
    assert "- no_clock: " in inspected.stdout.partition("Stops naming")[2]
    diagnosed = ask("diagnose", told, "--law", "exponential_law")
    assert (
        diagnosed.exit_code == 4
        and "'AI7' looks like it" in diagnosed.stderr
        and "--assume no_clock" in diagnosed.stderr
    )
    assert ask("diagnose", told, "--law", "exponential_law", "--assume", "no_clock").exit_code == 0


def test_a_locked_muscle_has_a_row_a_length_and_one_under_weights_counts_its_cycles_in_a_row(ask, write_record):
    ramp = [0.2 + 0.3 * k / 40 for k in range(41)]
    rows = [(p, x, 2600.0 * p - 40.0 * x) for x in (0.0, 10.0, 20.0) for p in [*ramp, *ramp[-2:0:-1]] * 3]
    text = "time_s,pressure_MPa,displacement_mm,force_N\n"
    path = write_record(text + "".join(f"{0.1 * k:.1f},{p:.4f},{x:g},{f:.3f}\n" for k, (p, x, f) in enumerate(rows)))
    said = ask("inspect", path).stdout
    assert "isometric" in said and "3 at most at one length" in said
    lines = [line.split() for line in said.splitlines() if line.split()[:1] in (["0.0000"], ["0.0500"], ["0.1000"])]
    assert [line[1] for line in lines] == ["240"] * 3 and lines[1][2:5] == ["0.2000", "to", "0.5000"]
