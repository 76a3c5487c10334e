"""Bad input ends in the right exit code and one clear message, never in a traceback."""

import json
import re

import pytest

GOOD = "time_s,pressure_MPa,displacement_mm,force_N\n" + "".join(
    f"{k * 0.1:.1f},{0.2 + 0.1 * (k // 20)},{(k % 20) * 1.0},{900 - 20 * (k % 20) + 100 * (k // 20)}\n"
    for k in range(60)
)


def with_cell(row, column, cell):
    lines = GOOD.splitlines()
    cells = lines[row].split(",")
    cells[column] = cell
    lines[row] = ",".join(cells)
    return "\n".join(lines) + "\n"


BAD = {
    "missing column": (GOOD.replace("force_N", "weight"), ["force_N"]),
    "no displacement": (GOOD.replace("displacement_mm", "way"), ["displacement_mm"]),
    "unknown unit": (GOOD.replace("pressure_MPa", "Pressure [atm]"), ["atm", "MPa"]),
    "unknown unit as suffix": (GOOD.replace("force_N", "force_stone"), ["stone", "force"]),
    "text in a number column": (with_cell(7, 3, "broken"), ["row 8", "force_N", "broken"]),
    "empty file": ("", ["empty"]),
    "header only": (GOOD.splitlines()[0] + "\n", ["no rows"]),
    "empty column": (re.sub(r",[\d.]+\n", ",\n", GOOD), ["row 2", "force_N", "holds nothing"]),
    "infinite": (with_cell(9, 3, "inf"), ["row 10", "force_N"]),
    "time runs backwards": (with_cell(30, 0, "0.05"), ["row 31", "time_s", "backwards"]),
    "contraction beyond reason": (with_cell(12, 2, "2000"), ["row 13", "displacement_mm"]),
    "branch of no known name": (
        GOOD.replace("force_N\n", "force_N,branch\n").replace("\n", ",up\n").replace("branch,up", "branch"),
        ["branch", "up"],
    ),
    "not text": ("\x00\x01\x02", ["record.csv"]),
}


def one_message(result, code, *words):
    assert result.exit_code == code, result.output
    message = result.stderr.strip()
    assert 1 <= len(message.splitlines()) <= 2, message
    assert "Traceback" not in result.output
    for word in words:
        assert word in message
    return message


@pytest.mark.parametrize("kind", BAD)
@pytest.mark.parametrize("verb", ["fit", "compare", "diagnose"])
def test_bad_records_are_named_with_what_to_mend(ask, write_record, kind, verb):
    text, words = BAD[kind]
    path = write_record(text)
    one_message(ask(verb, path, "--law", "exponential_law"), 4, str(path), *words)


@pytest.mark.parametrize(
    "words",
    [
        ("inspect",),
        ("add", "--law", "sarosi", "--effect", "coulomb_friction"),
        ("ladder", "--law", "sarosi"),
        ("report", "--law", "sarosi", "--out", "never.html"),
    ],
    ids=lambda words: words[0],
)
def test_every_command_refuses_a_bad_record(ask, write_record, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = write_record(BAD["infinite"][0])
    one_message(ask(words[0], path, *words[1:]), 4, "row 10")
    assert not (tmp_path / "never.html").exists()


def test_rows_with_empty_cells_are_told_and_cost_nothing_else(ask, write_record):
    path = write_record(with_cell(5, 2, ""))
    assert "1 row is left out: column 'displacement_mm' is empty there" in ask("inspect", path).output
    assert ask("fit", path, "--law", "modified_chou_hannaford", "--where", "force_N > 300").exit_code == 0
    one_message(ask("fit", path, "--law", "modified_chou_hannaford", "--where", "force > 300"), 2, "no unit given")


def test_the_good_record_of_these_tests_is_good(ask, write_record):
    assert ask("fit", write_record(GOOD), "--law", "modified_chou_hannaford").exit_code == 0


@pytest.mark.long
@pytest.mark.parametrize("verb", ["fit", "compare", "diagnose", "ladder"])
def test_what_one_pressure_does_not_tell_of_a_law_is_said(ask, write_record, verb):
    result = ask(verb, write_record(pressures=(0.3,)), "--law", "exponential_law")
    assert result.exit_code == 0 and "does not tell a0, b0, c0 from" in result.output


def test_one_isobar_has_no_line_over_pressure(ask, write_record):
    asked = ("fit", write_record(pressures=(0.3,)), "--law", "exponential_law", "--method", "both")
    one_message(ask(*asked), 3, "a line over pressure needs two isobars")


def test_what_does_not_exist(ask, tmp_path):
    one_message(ask("fit", tmp_path / "none.csv", "--law", "sarosi"), 4, "none.csv: no such file")
    one_message(ask("fit", tmp_path, "--law", "sarosi"), 4, "folder")


@pytest.mark.parametrize(
    ("specimen", "words"),
    [
        (None, ["specimen.toml", "--specimen"]),
        ("[specimen]\nname = 'x'\n", ["specimen.toml", "initial_length_mm"]),
        ("[specimen\n", ["specimen.toml", "TOML"]),
        ("[muscle]\n", ["[specimen]"]),
    ],
)
def test_bad_specimens(ask, write_record, specimen, words):
    one_message(ask("fit", write_record(GOOD, specimen=specimen), "--law", "sarosi"), 4, *words)


def test_a_branch_that_is_not_there(ask, root):
    record = root / "datasets" / "dmsp20_300" / "record.csv"
    one_message(ask("fit", record, "--law", "sarosi", "--branch", "separate"), 4, "no contraction branch")


def test_an_effect_the_record_cannot_hold(ask, root):
    record = root / "datasets" / "dmsp20_300" / "record.csv"
    for verb in ("fit", "add"):
        result = ask(verb, record, "--law", "sarosi", "--effect", "viscous_damping")
        one_message(result, 4, "viscous_damping needs", "motion")


@pytest.mark.parametrize(
    "words",
    [
        ("fit", "RECORD", "--law", "hooke"),
        ("fit", "RECORD", "--law", "auto", "--effect", "magic"),
        ("fit", "RECORD", "--law", "sarosi", "--effect", "magic"),
        ("fit", "RECORD", "--law", "sarosi", "--effect", "coulomb_friction:magic"),
        ("fit", "RECORD", "--law", "sarosi", "--effect", "creep", "--effect", "creep"),
        ("fit", "RECORD", "--law", "sarosi", "--branch", "upwards"),
        ("fit", "RECORD", "--law", "sarosi", "--method", "magic"),
        ("fit", "RECORD", "--law", "sarosi", "--effect-file", "none.py"),
        ("fit", "RECORD", "--law", "sarosi", "--json", "nowhere/answer.json"),
        ("fit", "RECORD", "--law", "sarosi", "--json", "."),
        ("fit", "RECORD", "--law", "sarosi", "--wish"),
        ("compare", "RECORD", "--law", "sarosi", "--out", "map.gif"),
        ("report", "RECORD", "--law", "sarosi", "--out", "report.txt"),
        ("report", "RECORD", "--law", "sarosi"),
        ("add", "RECORD", "--law", "sarosi"),
        ("diagnose", "--law", "sarosi"),
        ("effects", "show", "magic"),
        ("wish",),
    ],
    ids=" ".join,
)
def test_wrong_calls_exit_with_2(ask, write_record, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = write_record(GOOD)
    one_message(ask(*(path if word == "RECORD" else word for word in words)), 2)
    assert list(tmp_path.iterdir()) == []


VERBS = {
    "inspect": ("RECORD",),
    "fit": ("RECORD",),
    "compare": ("RECORD", "--law", "sarosi"),
    "add": ("RECORD", "--effect", "creep"),
    "diagnose": ("RECORD",),
    "ladder": ("RECORD",),
    "report": ("RECORD", "--out", "out.html"),
    "validate": ("none.json", "RECORD"),
    "predict": ("none.json", "--at", "RECORD"),
    "export": ("RECORD", "--to", "c", "--out", "out.h"),
}


@pytest.mark.parametrize("verb", VERBS)
def test_what_cannot_be_read_has_its_line_of_json(verb, ask, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.csv").write_text("time_s,force_N\n0,1\n")
    words = [word.replace("RECORD", "bad.csv") for word in VERBS[verb]]
    result = ask(verb, *words, "--json", "-")
    answer = json.loads(result.stdout)
    naming = verb in ("diagnose", "ladder", "report")
    assert result.exit_code == 4 and answer["schema"] == f"pam-ident/{'diagnosis' if naming else 'refusal'}/1"
    ((warning,), record) = answer["warnings"], answer["record"]
    assert warning["code"] == "bad_data" and warning["grave"] and warning["text"] == " ".join(result.stderr.split())
    assert record == (None if verb == "export" else "bad.csv")
    ask(verb, *words, "--json", tmp_path / "answer.json")
    assert json.loads((tmp_path / "answer.json").read_text()) == answer


@pytest.mark.long
def test_each_of_several_records_has_its_line_and_a_wrong_call_has_none(ask, rubbing, tmp_path):
    (tmp_path / "bad.csv").write_text("time_s,force_N\n0,1\n")
    result = ask("diagnose", tmp_path / "bad.csv", rubbing, "--law", "exponential_law", "--json", "-")
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    assert result.exit_code == 4 and [one["selected"] for one in lines] == [[], ["coulomb_friction"]]
    result = ask("fit", rubbing, "--law", "none", "--json", tmp_path / "answer.json")
    assert result.exit_code == 2 and not (tmp_path / "answer.json").exists()
