"""Awkward text files: each is read right, value by value, or refused with one message that says what to mend."""

import gzip

import numpy as np
import pytest
from corpus import DISPLACEMENT, FORCE, HEADERS, PRESSURE, ROWS, TIME, as_text, assert_right, values

from pam_ident.core import DataError
from pam_ident.records import read_record, text_table

BARE = ("time", "pressure", "displacement", "force")
UNITS = "s,MPa,mm,N\n"
BAR = np.column_stack([TIME * 1000, PRESSURE * 10, DISPLACEMENT / 10, FORCE / 1000])
BAR_HEADERS = ("Time [ms]", "Pressure [bar]", "Displacement [cm]", "Force [kN]")
PREAMBLE = "Rig 3, muscle 7\nOperator: N. N.\nDate,2024-05-03\n\n"
GERMAN = as_text(sep=";", decimal=",")
GOOD = as_text()
WIDE = np.column_stack([values(), np.full(ROWS, 7.0)])


def under_header(text, line):
    first, _, rest = text.partition("\n")
    return first + "\n" + line + rest


def with_line(text, number, line):
    lines = text.split("\n")
    lines[number - 1] = line
    return "\n".join(lines)


def repeated(text, between=""):
    lines = text.splitlines(keepends=True)
    return "".join([*lines[:13], between, lines[0], *lines[13:]])


def quoted(text, sep=","):
    return "\n".join(sep.join(f'"{cell}"' for cell in line.split(sep)) for line in text.splitlines()) + "\n"


READ = {
    "commas": GOOD,
    "semicolons": as_text(sep=";"),
    "commas between thousands": GOOD.replace("1350.25", '"1,350.25"'),
    "tabs": as_text(sep="\t"),
    "bars": as_text(sep="|"),
    "blanks": as_text(sep="   ", first=" "),
    "commas and blanks": as_text(sep=" , "),
    "semicolons, decimal comma": GERMAN,
    "tabs, decimal comma": as_text(sep="\t", decimal=","),
    "blanks, decimal comma": as_text(sep=" ", decimal=","),
    "commas, quoted decimal commas": quoted(GERMAN, ";").replace(";", ","),
    "all quoted": quoted(GOOD),
    "Windows line ends": as_text(end="\r\n"),
    "old Mac line ends": as_text(end="\r"),
    "no line end at the end": GOOD.rstrip("\n"),
    "blank lines between": GOOD.replace("\n", "\n\n"),
    "blank lines at the end": GOOD + "\n\n  \n",
    "rows of nothing but delimiters at the end": GOOD + ",,,\n,,,\n",
    "rows of nothing but delimiters and blanks": GOOD.replace("\n0.5,", "\n , ,, \n0.5,"),
    "line ends of two systems": GOOD.replace("\n", "\r\n", 9),
    "end-of-file mark of DOS": GOOD + "\x1a",
    "UTF-8 with a mark": b"\xef\xbb\xbf" + GOOD.encode(),
    "UTF-16, little end first": b"\xff\xfe" + GOOD.encode("utf-16-le"),
    "UTF-16, big end first": b"\xfe\xff" + GERMAN.encode("utf-16-be"),
    "UTF-16 without a mark": GOOD.encode("utf-16-le"),
    "Latin-1 in a preamble": ("Prüfstand Köln\n\n" + GERMAN).encode("latin-1"),
    "Latin-1 degrees": as_text((*HEADERS, "temperature [°C]"), WIDE).encode("latin-1"),
    "UTF-8 in a preamble": "Prüfstand Köln\n" + GERMAN,
    "gzipped": gzip.compress(GOOD.encode()),
    "preamble": PREAMBLE + GOOD,
    "preamble of many commas": "a,b,c,d,e,f\n1,2,3,4,5,6\n" + GOOD,
    "preamble with semicolons over commas": "Rig; 3; muscle; 7; test; 9\n" + GOOD,
    "comment marks in a preamble": "# rig 3\n# muscle 7\n" + GOOD,
    "header as a comment": "# " + GOOD,
    "long preamble": "line\n" * 90 + GOOD,
    "units in a row": under_header(as_text(BARE), UNITS),
    "units in brackets in a row": under_header(as_text(BARE), "[s],[MPa],[mm],[N]\n"),
    "units in a row, other units": under_header(as_text(BARE, BAR), "ms,bar,cm,kN\n"),
    "units in a row and in the header, the same": under_header(GOOD, UNITS),
    "units in a row, preamble, decimal comma": PREAMBLE
    + under_header(as_text(BARE, sep=";", decimal=","), "s;MPa;mm;N\n"),
    "row of units after a blank line": under_header(as_text(BARE), "\n" + UNITS),
    "other units in brackets": as_text(BAR_HEADERS, BAR),
    "other units, decimal comma": as_text(BAR_HEADERS, BAR, sep=";", decimal=","),
    "columns in another order": as_text(HEADERS[::-1], values()[:, ::-1]),
    "further columns": as_text((*HEADERS, "valve_V"), WIDE),
    "further columns twice": as_text(
        (*HEADERS[:3], "raw", "raw", HEADERS[3]), np.insert(values(), [3, 3], 5.0, axis=1)
    ),
    "columns without a name": as_text((*HEADERS, "", ""), np.column_stack([WIDE, TIME])),
    "a last delimiter on each line": as_text(last=","),
    "a last delimiter on the rows alone": as_text().replace("\n", ";\n").replace(",", ";").replace("N;", "N"),
    "a last delimiter on the header alone": GOOD.replace("force_N", "force_N,"),
    "remarks as text": as_text((*HEADERS, "remark"), [[*row, "valve; open"] for row in values()]),
    "remarks that are empty": as_text((*HEADERS, "remark"), [[*row, ""] for row in values()]),
    "remarks with commas, quoted": as_text((*HEADERS, "remark"), [[*row, '"one, two"'] for row in values()]),
    "header repeated, clock goes on": repeated(GOOD),
    "header repeated after blank lines": repeated(GOOD, "\n\n"),
    "powers of ten": as_text(rows=[[f"{x:.9e}" for x in row] for row in values()]),
    "powers of ten, decimal comma": as_text(
        sep=";", rows=[[f"{x:.9E}".replace(".", ",") for x in row] for row in values()]
    ),
    "plus signs": as_text(rows=[[f"{x:+.6g}" for x in row] for row in values()]),
    "whole numbers": as_text(("time_ms", "pressure_kPa", "displacement_um", "force_mN"), BAR * [1, 100, 1e4, 1e6]),
    "capitals": as_text(("TIME [S]", "PRESSURE [MPA]", "DISPLACEMENT [MM]", "FORCE [N]")),
    "length in place of displacement": as_text(
        (*HEADERS[:2], "length_mm", "force_N"), values() * [1, 1, -1, 1] + [0, 0, 200, 0]
    ),
    "contraction in per cent": as_text((*HEADERS[:2], "contraction_pct", "force_N"), values() * [1, 1, 0.5, 1]),
}

MAPPED = {
    "no header": (as_text(()), "time_s = 1\npressure_MPa = 2\ndisplacement_mm = 3\nforce_N = 4"),
    "other names": (
        as_text(("t", "p", "way", "pull")),
        'time_s = "t"\npressure_MPa = "p"\ndisplacement_mm = "way"\nforce_N = "pull"',
    ),
    "names with blanks under a preamble": (
        PREAMBLE
        + as_text(("Zeit", "p abs", "Weg s", "Kraft F"), values() * [1, 1000, -1, -1] + [0, 101.325, 80, 0], ";", ","),
        'time_s = "Zeit"\npressure_kPa = { column = "p abs", offset = -101.325 }\n'
        'displacement_mm = { column = "Weg s", factor = -1, offset = 80 }\n'
        'force_N = { column = "Kraft F", factor = -1 }',
    ),
    "one name twice, by number": (
        as_text(("t", "x", "x", "f")),
        "time_s = 1\npressure_MPa = 2\ndisplacement_mm = 3\nforce_N = 4",
    ),
    "two that would be taken": (
        as_text((*HEADERS, "force_kN"), np.column_stack([values(), np.zeros(ROWS)])),
        'time_s = "time_s"\npressure_MPa = "pressure_MPa"\ndisplacement_mm = "displacement_mm"\nforce_N = "force_N"',
    ),
    "header line and decimal mark told": (
        "1;2;3;4\nt;p;x;f\n" + as_text((), sep=";", decimal=","),
        'time_s = "t"\npressure_MPa = "p"\ndisplacement_mm = "x"\nforce_N = "f"\n[file]\nheader_row = 2\ndecimal = ","',
    ),
}

REFUSED = {
    "a cell with a decimal comma": (GOOD.replace("\n0.5,", '\n"0,5",'), ["row 7", "'time_s'", "'0,5'"]),
    "a point in a file of decimal commas": (
        GERMAN.replace("1350,25", "1350.25"),
        ["row 6", "'force_N'", "1350.25", "comma"],
    ),
    "thousands or decimals": (
        as_text(sep=";", rows=[[str(k), "1", "2", "1,250"] for k in range(9)]),
        ["'force_N'", "'1,250'", "thousands"],
    ),
    "a comma too many": (GOOD.replace("1350.25", "1,350.25"), ["row 6", "5 cells", "4"]),
    "a cell too few in the middle": (with_line(GOOD, 9, "0.7,0.3,17.5"), ["row 9", "3 cells", "4"]),
    "a cell too few before a column that is not read": (
        with_line(as_text((*HEADERS, "x"), WIDE), 9, "0.7,17.5,1312.75,7"),
        ["row 9", "4 cells", "5"],
    ),
    "the last row cut off": (GOOD[:-12], ["row 25", "3 cells"]),
    "a row too long under a preamble": (PREAMBLE + with_line(GOOD, 9, "0,1,2,3,4,5"), ["row 13", "6 cells"]),
    "rows longer than the header": (GOOD.replace("\n", ",1\n").replace("N,1", "N"), ["row 2", "5 cells", "4"]),
    "other delimiters in rows than in the header": (GOOD.replace(",", ";").replace("s;p", "s,p", 1), ["expected"]),
    "a quotation mark that is not closed": (GOOD.replace("\n0.5,", '\n"0.5,'), ["row 7", "quotation mark"]),
    "a byte 0": (GOOD.replace("1350.25", "1350\x00.25"), ["text"]),
    "a byte 0 far down": ("\n" + GOOD * 60 + "1,0.3,0,9\x00\n", ["text"]),
    "an image": (b"\x89PNG\r\n\x1a\n\x00\x00", ["not a readable CSV"]),
    "blank lines only": ("\n\n \n", ["empty"]),
    "a preamble only": (PREAMBLE, ["no header row", "columns.toml"]),
    "no header": (as_text(()), ["row 1", "no header", "columns.toml"]),
    "no header under a preamble": (PREAMBLE + as_text(()), ["row 5", "no header", "columns.toml"]),
    "unknown names": (as_text(("t", "p", "x", "f")), ["row 1", "pressure", "'p'", "columns.toml"]),
    "unknown unit in the row of units": (
        under_header(as_text(BARE), "s,torr,mm,N\n"),
        ["'pressure [torr]'", "'torr'", "kPa"],
    ),
    "row of units against the header": (under_header(GOOD, "s,MPa,mm,kN\n"), ["'force_N'", "'kN'"]),
    "no unit anywhere": (as_text(BARE), ["no unit given"]),
    "the same name twice": (as_text((*HEADERS, "force_N"), WIDE), ["row 1", "two columns", "'force_N'"]),
    "the same quantity in two units": (as_text((*HEADERS, "force_kN"), WIDE), ["'force_N'", "'force_kN'"]),
    "a footer": (GOOD + "End of test\n", ["row 26", "1 cells"]),
    "a footer of as many cells": (GOOD + "mean,0.3,12,900\n", ["row 26", "'time_s'", "'mean'"]),
    "a second table of other columns": (GOOD + "a,b\n1,2\n", ["row 26", "2 cells"]),
    "a bad cell after the header is repeated": (repeated(GOOD).replace("1187.75", "x"), ["row 20", "'x'"]),
    "a bad cell under a preamble with blank lines": (PREAMBLE + GOOD.replace("1350.25", "x"), ["row 10", "'x'"]),
    "numbers with their unit": (GOOD.replace("1350.25", "1350.25 N"), ["row 6", "1350.25 N"]),
    "truth values": (as_text(rows=[[*map(str, row[:3]), "True"] for row in values()]), ["row 2", "'True'"]),
    "a date for a time": (GOOD.replace("\n0.5,", "\n2024-05-03 10:00,"), ["row 7", "'time_s'"]),
    "hexadecimal": (GOOD.replace("1350.25", "0x1F"), ["row 6", "0x1F"]),
    "underscores": (GOOD.replace("1350.25", "1_350"), ["row 6", "1_350"]),
    "too large a number": (GOOD.replace("1350.25", "1e999"), ["row 6", "'force_N'"]),
    "time backwards after a repeated header is a new run, but within it is not": (
        repeated(GOOD).replace("\n1.5,", "\n1.3,"),
        ["row 18", "backwards"],
    ),
}

BAD_MAPPINGS = {
    "no table": ("[rows]\na = 1", ["[columns]"]),
    "not TOML": ("[columns", ["TOML"]),
    "a quantity of no known name": ("[columns]\nweight_N = 1", ["weight_N", "force"]),
    "a unit of no known name": (
        "[columns]\nforce_N = 4\npressure_MPa = 2\ndisplacement_mm = 3\ntime_h = 1",
        ["time_h"],
    ),
    "a unit against the file's": (
        "[columns]\nforce_kN = 4\npressure_MPa = 2\ndisplacement_mm = 3",
        ["force_kN", "'force_N'"],
    ),
    "no force": ("[columns]\npressure_MPa = 2\ndisplacement_mm = 3", ["force"]),
    "two shapes": ("[columns]\nforce_N = 4\npressure_MPa = 2\ndisplacement_mm = 3\nlength_mm = 1", ["more than one"]),
    "a column that is not there": (
        "[columns]\nforce_N = 9\npressure_MPa = 2\ndisplacement_mm = 3",
        ["column 9", "4 columns"],
    ),
    "a name that is not there": (
        '[columns]\nforce_N = "g"\npressure_MPa = 2\ndisplacement_mm = 3',
        ["'g'", "'force_N'"],
    ),
    "an entry of no meaning": (
        "[columns]\nforce_N = { col = 4 }\npressure_MPa = 2\ndisplacement_mm = 3",
        ["force_N", "value"],
    ),
    "a truth value": ("[columns]\nforce_N = true\npressure_MPa = 2\ndisplacement_mm = 3", ["force_N"]),
    "an unknown setting": (
        "[columns]\nforce_N = 4\npressure_MPa = 2\ndisplacement_mm = 3\n[file]\nsep = 1",
        ["sep", "delimiter"],
    ),
    "an unknown encoding": (
        '[columns]\nforce_N = 4\npressure_MPa = 2\ndisplacement_mm = 3\n[file]\nencoding = "x"',
        ["'x'"],
    ),
}


@pytest.fixture(params=[text_table.BLOCK_BYTES, 37], ids=["whole", "in pieces"])
def blocks(request, monkeypatch):
    """Files are read at once, or in pieces of a row or two."""
    monkeypatch.setattr(text_table, "BLOCK_BYTES", request.param)


@pytest.mark.usefixtures("blocks")
@pytest.mark.parametrize("kind", READ)
def test_what_can_be_read_is_read_right(put, kind):
    assert_right(read_record(put(READ[kind], "record.csv.gz" if kind == "gzipped" else "record.csv")))


def test_the_quick_way_and_the_closer_look_read_the_same_numbers(put, monkeypatch):
    rows = np.random.default_rng(0).normal(0.0, 1.0, (3000, 4))
    rows[:, 0] = np.arange(3000)
    rows[:, 1] = np.abs(rows[:, 1])
    path = put(as_text(rows=[[f"{x:.12g}" for x in row] for row in rows]))
    quick = read_record(path)
    monkeypatch.setattr(text_table, "_plain", lambda *_: None)
    close = read_record(path)
    for name in ("pressure", "contraction", "time"):
        np.testing.assert_array_equal(getattr(quick.inputs, name), getattr(close.inputs, name))
    np.testing.assert_array_equal(quick.force, close.force)
    np.testing.assert_allclose(quick.force, rows[:, 3], rtol=1e-11)


@pytest.mark.parametrize("kind", MAPPED)
def test_what_a_mapping_explains_is_read_right(put, kind):
    text, mapping = MAPPED[kind]
    assert_right(read_record(put(text, mapping="[columns]\n" + mapping)))


def refusal(path, words):
    with pytest.raises(DataError) as caught:
        read_record(path)
    message = str(caught.value)
    assert str(path.parent) in message and len(message.splitlines()) <= 2
    for word in words:
        assert word in message, message


@pytest.mark.usefixtures("blocks")
@pytest.mark.parametrize("kind", REFUSED)
def test_what_cannot_be_read_is_refused_with_its_place(put, kind):
    text, words = REFUSED[kind]
    refusal(put(text), words)


@pytest.mark.parametrize("kind", BAD_MAPPINGS)
def test_a_mapping_that_does_not_fit_is_refused(put, kind):
    text, words = BAD_MAPPINGS[kind]
    refusal(put(GOOD, mapping=text), [*words])


def test_a_mapping_reads_what_it_names_and_nothing_else(put):
    text = as_text((*HEADERS, "temperature_C"), WIDE)
    mapping = "[columns]\nforce_N = 4\npressure_MPa = 2\nlength_mm = { value = 190 }"
    record = read_record(put(text, mapping=mapping))
    assert record.inputs.time is None and record.inputs.temperature is None
    np.testing.assert_allclose(record.inputs.contraction, 0.05)


def test_branches_in_the_words_of_a_rig(put):
    rows = [[*row, 1 + (k % 12 > 5)] for k, row in enumerate(values())]
    mapping = "[columns]\nforce_N = 4\npressure_MPa = 2\ndisplacement_mm = 3\n"
    mapping += 'branch = { column = "state", contraction = "1", extension = "2" }'
    record = read_record(put(as_text((*HEADERS, "state"), rows), mapping=mapping))
    np.testing.assert_array_equal(record.inputs.direction, np.where(np.arange(ROWS) % 12 > 5, -1.0, 1.0))


def test_a_clock_that_begins_anew_with_each_isobar_is_several_runs(put):
    rows = np.column_stack([np.tile(TIME[:12], 2), PRESSURE, PRESSURE, DISPLACEMENT, FORCE])
    record = read_record(put(as_text(("time_s", "pressure_set_MPa", *HEADERS[1:]), rows)))
    assert np.all(np.diff(record.inputs.time) > 0.0) and record.inputs.segment[12] == 1
    np.testing.assert_allclose(np.diff(record.inputs.time)[12:], 0.1)
