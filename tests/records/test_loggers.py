"""What loggers write beside plain numbers: clock times, per cent, absolute pressure, nothing, one reading for ever."""

import gzip
import warnings

import numpy as np
import pytest
from corpus import DISPLACEMENT, FORCE, HEADERS, PRESSURE, ROWS, TIME, as_text, assert_right, values

from pam_ident.core import DataError
from pam_ident.core.units import split_header
from pam_ident.records import read_record
from pam_ident.records.columns import spread
from pam_ident.records.faulty import frozen_rows


def refusal(path, *words):
    with pytest.raises(DataError) as caught, warnings.catch_warnings():
        warnings.simplefilter("error")
        read_record(path)
    message = str(caught.value)
    assert len(message.splitlines()) <= 2
    for word in words:
        assert word in message, message


def column(k, header, cells, **how):
    """The good table with another header and other cells in column k."""
    rows = [[*row[:k], cell, *row[k + 1 :]] for row, cell in zip(values().tolist(), cells, strict=True)]
    return as_text([*HEADERS[:k], header, *HEADERS[k + 1 :]], rows, **how)


CLOCK = [f"23:59:{59 + t:06.3f}" if t < 0.95 else f"00:00:{t - 1:06.3f}" for t in TIME]
ISO = [f"2024-02-28T23:59:{59 + t:06.3f}" if t < 0.95 else f"2024-02-29 00:00:{t - 1:06.3f}" for t in TIME]


@pytest.mark.parametrize("header", ["time", "time_s", "Time [hh:mm:ss]", "Time [hh:mm:ss.000]"])
@pytest.mark.parametrize("cells", [CLOCK, ISO, [f"{cell}+01:00" for cell in ISO]], ids=["clock", "ISO", "zone"])
def test_clock_times_are_seconds_since_the_first(put, header, cells):
    record = read_record(put(column(0, header, cells)))
    assert_right(record)
    assert [note.code for note in record.notes] == (["midnight"] if cells is CLOCK else [])


@pytest.mark.parametrize(
    "cells",
    [
        [f"58:{59 + t:06.3f}" if t < 0.95 else f"59:{t - 1:06.3f}" for t in TIME],
        [f"11:59:{59 + t:06.3f} am" if t < 0.95 else f"12:00:{t - 1:06.3f} PM" for t in TIME],
        [f"3/31/2024 11:59:{59 + t:06.3f} PM" if t < 0.95 else f"4/1/2024 12:00:{t - 1:06.3f} AM" for t in TIME],
        [f"31/12/24 23:59:{59 + t:06.3f}" if t < 0.95 else f"01/01/25 00:00:{t - 1:06.3f}" for t in TIME],
    ],
    ids=["minutes", "noon", "month first", "day first"],
)
def test_other_clocks_are_seconds_since_the_first(put, cells):
    assert_right(read_record(put(column(0, "time", cells))))


def test_a_spreadsheets_days(put):
    cells = [f"{45623.5855 + t / 86400.0:.9f}" for t in TIME]
    refusal(put(column(0, "time", cells)), "no unit given", "Time [day]")
    time = read_record(put(column(0, "Time [day]", cells))).inputs.time
    np.testing.assert_allclose(time - time[0], TIME, atol=2e-4)


def test_a_clock_with_a_decimal_comma(put):
    cells = [cell.replace(".", ",") for cell in CLOCK]
    assert_right(read_record(put(column(0, "time", cells, sep=";", decimal=","))))


def german(number):
    """A number with points between thousands and a decimal comma."""
    return number.translate(str.maketrans(",.", ".,"))


@pytest.mark.parametrize("header", ["time", "Datum/Uhrzeit"])
def test_a_date_that_begins_with_the_day(put, header):
    cells = [f"{cell[8:10]}.{cell[5:7]}.{cell[:4]} {german(cell[11:])}" for cell in ISO]
    assert_right(read_record(put(column(0, header, cells, sep=";", decimal=","))))


def test_points_between_thousands_beside_decimal_commas(put):
    force = [german(f"{row[3]:,.2f}") for row in values()]
    assert any("." in cell for cell in force)
    assert_right(read_record(put(column(3, "force_N", force, sep=";", decimal=","))))


@pytest.mark.parametrize("tick", [1.0, 0.5, 0.2])
def test_a_clock_coarser_than_the_rows_is_made_even(put, tick):
    record = read_record(put(column(0, "time_s", np.floor((TIME + 1e-9) / tick) * tick)))
    steps = np.diff(record.inputs.time)
    assert np.abs(record.inputs.time - TIME).max() < tick and steps.min() > 0.0
    np.testing.assert_allclose(steps[: round(tick / 0.1) - 1], 0.1)
    (note,) = record.notes
    assert note.code == "coarse_clock" and note.rows == 0 and "'time_s'" in note.text and "row 3)" in note.text


def test_a_coarse_clock_goes_on_over_the_pieces_of_a_file():
    """A second of three rows, two of them in the next piece, and a clock that stands."""
    assert spread(np.r_[1.0, 2.0, 2.0, 3.0], -np.inf).tolist() == [1.0, 2.0, 2.5, 3.0]
    assert spread(np.r_[3.0, 3.0, 4.0, 9.0, 9.0], 3.2).tolist() == [3.2, 3.5, 4.0, 9.0, 9.5]
    assert spread(np.r_[7.0, 7.0, 7.0], 7.0).tolist() == [7.0, 7.0, 7.0]


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ([*CLOCK[:8], "8", *CLOCK[9:]], ["row 10", "'8'"]),
        ([*TIME[:8], "00:00:08", *TIME[9:]], ["row 10", "'00:00:08'"]),
        (["12:30"] * ROWS, ["row 2", "'12:30'", "hh:mm:ss"]),
        (["02-28-2024 12:00:00"] * ROWS, ["row 2", "ISO time"]),
        (TIME, ["'time'", "no unit given"]),
    ],
)
def test_clock_times_that_are_none(put, cells, words):
    refusal(put(column(0, "time", cells)), *words)


@pytest.mark.parametrize("header", ["contraction", "contraction_pct", "Contraction [%]"])
def test_per_cent_in_the_cell(put, header):
    record = read_record(put(column(2, header, [f"{x / 2.0:g} %" for x in DISPLACEMENT])))
    np.testing.assert_allclose(record.inputs.contraction, DISPLACEMENT / 200.0, atol=1e-12)


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("pressure_bara", 10.0),
        ("pressure_bar_abs", 10.0),
        ("Pressure [bar abs]", 10.0),
        ("Pressure [bar(a)]", 10.0),
        ("Pressure (kPa absolute)", 1000.0),
        ("pressure_psia", 1 / 6.894757293168361e-3),
    ],
)
def test_absolute_pressure_is_taken_off_and_told(put, header, factor):
    record = read_record(put(column(1, header, (PRESSURE + 0.101325) * factor)))
    np.testing.assert_allclose(record.inputs.pressure, PRESSURE, rtol=1e-5)
    (note,) = record.notes
    assert note.code == "absolute_pressure" and note.column == header and "0.101325 MPa" in note.text


@pytest.mark.parametrize("header", ["pressure_barg", "Pressure [bar(g)]", "pressure_bar_gauge", "Pressure [bar rel]"])
def test_gauge_pressure_is_pressure(put, header):
    record = read_record(put(column(1, header, PRESSURE * 10.0)))
    np.testing.assert_allclose(record.inputs.pressure, PRESSURE)
    assert record.notes == ()


@pytest.mark.parametrize(
    ("header", "found"),
    [
        ("pressure_Pa", ("pressure", "Pa")),
        ("pressure_a", ("pressure_a", None)),
        ("force_N", ("force", "N")),
        ("valve_abs", ("valve_abs", None)),
        ("x [°C]", ("x", "C")),
        ("x [°F]", ("x", "degF")),
    ],
)
def test_other_headers_have_the_units_they_had(header, found):
    assert split_header(header) == found


def test_shuffled_rows_are_no_static_table(put):
    shuffled = np.random.default_rng(1).permutation(TIME)
    for header in ("time_s", "Zeit [s]"):
        refusal(put(column(0, header, shuffled)), "time runs backwards", "sort the rows")
    begun = np.r_[TIME[:12], TIME[: ROWS - 12]]
    refusal(put(column(0, "Zeit [s]", begun)), "where another run begins, give it a file of its own")


def test_a_mapping_against_an_absolute_header_is_refused(put):
    text = column(1, "p [bar abs]", (PRESSURE + 0.101325) * 10.0)
    mapping = "[columns]\ntime_s = 1\ndisplacement_mm = 3\nforce_N = 4\npressure_{} = {}\n"
    refusal(put(text, mapping=mapping.format("bar", 2)), "bar abs")
    record = read_record(put(text, mapping=mapping.format("bara", 2)))
    np.testing.assert_allclose(record.inputs.pressure, PRESSURE, rtol=1e-5)
    put(text, mapping=mapping.format("bar", "{ column = 2, offset = -1.01325 }"))
    np.testing.assert_allclose(read_record(put(text)).inputs.pressure, PRESSURE, rtol=1e-5)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("s,MPa,mm,kN\n" + as_text(), ["'force_N'", "'kN'"]),
        ("[s],[MPa],[mm],[kN]\n" + as_text(), ["'force_N'", "'kN'"]),
        (as_text().replace("\n", "\ns,MPa,mm,kN\n", 1), ["'force_N'", "'kN'"]),
        (column(3, "force_N", [1e308] * ROWS).replace("force_N", "force_kN"), ["row 2", "'force_kN'"]),
        (column(3, "force_N", [*FORCE[:5], 1e300, *FORCE[6:]]), ["row 7", "'force_N'", "1e+300"]),
        (column(0, "time_s", [*TIME[:-1], 1e300]), ["row 25", "'time_s'"]),
        (column(0, "cycle", [*[1] * 20, *[1e300] * 4]), ["row 22", "'cycle'"]),
        (column(0, "temperature_C", [1e9] * ROWS), ["row 2", "'temperature_C'"]),
        (column(0, "pressure_set_MPa", 1000 * PRESSURE), ["'pressure_set_MPa'"]),
        (column(0, "pressure_set_MPa", 10 * PRESSURE), ["'pressure_set_MPa'", "10 times", "'pressure_MPa'"]),
        (column(3, "force_N", ["1.167" if k % 2 else "1,5" for k in range(ROWS)], sep=";"), ["'force_N'"]),
        (as_text().replace("\n0.5,", f'\n"{"1" * 140_000},",'), ["row 7"]),
    ],
    ids=range(12),
)
def test_what_is_beyond_reason_is_refused_in_a_sentence(put, text, words):
    refusal(put(text), "record.csv", *words)


def test_a_remark_longer_than_csv_takes(put):
    rows = [[*row, f'"{"x" * 140_000 if row[0] == 0.5 else "x"}"'] for row in values().tolist()]
    assert_right(read_record(put(as_text((*HEADERS, "remark"), rows))))


@pytest.mark.parametrize("text", ["[file]\nencoding = 'latin-1'\n", "[file]\nheader_row = 1\n", "kind = 'isobaric'\n"])
def test_a_columns_file_may_leave_the_columns_to_their_names(put, text):
    assert_right(read_record(put(as_text(), mapping=text)))


def test_units_above_the_header_are_read(put):
    names = ("time", "pressure", "displacement", "force")
    assert_right(read_record(put("s,MPa,mm,N\n" + as_text(names))))


def test_a_point_that_may_part_thousands_is_told(put):
    rows = [[int(p * 10), 0, "1.167"] for p in PRESSURE]
    text = as_text(("pressure_bar", "displacement_mm", "force_N"), rows, sep=";")
    record = read_record(put(text))
    (note,) = record.notes
    assert record.force[0] == 1.167 and (note.code, note.column) == ("decimal_point", "force_N")
    assert "'1.167'" in note.text
    assert read_record(put(text.replace("3;0;1.167", "3;0.5;1.167", 1))).notes == ()
    mapping = "[file]\ndecimal = '.'\n[columns]\npressure_bar = 1\ndisplacement_mm = 2\nforce_N = 3\n"
    assert read_record(put(text, mapping=mapping)).notes == ()


def test_a_line_without_end_is_refused_before_it_fills_the_memory(put, monkeypatch):
    monkeypatch.setattr("pam_ident.records.text_table.BLOCK_BYTES", 1 << 16)
    monkeypatch.setattr("pam_ident.records.text_table.MOST_LINE", 1 << 18)
    path = put(gzip.compress(as_text().encode() + b"1" * (1 << 22)), "record.csv.gz")
    refusal(path, "a line of more than")


# --- sensors that hang -------------------------------------------------------------------------------------------


def strokes(seed=3):
    """Noisy strokes of a rig, 50 Hz."""
    rng = np.random.default_rng(seed)
    x = np.interp(np.arange(2000) % 400, [0, 180, 200, 380, 400], [0, 40, 40, 0, 0])
    return {
        "displacement": x + rng.normal(0, 0.02, 2000),
        "force": 900 - 15 * x + rng.normal(0, 1.0, 2000),
        "pressure": 0.3 + rng.normal(0, 5e-4, 2000),
    }


@pytest.mark.parametrize(
    ("key", "begin", "end"), [("displacement", 450, 490), ("force", 450, 490), ("force", 150, 231)]
)
def test_rows_of_a_sensor_that_hangs_are_found(key, begin, end):
    """In the last it wakes without a jump, where the muscle comes by again."""
    columns = strokes()
    columns[key][begin:end] = columns[key][begin]
    ((name, rows),) = frozen_rows(columns).items()
    assert name == key and list(np.flatnonzero(rows)) == list(range(begin + 1, end))


def test_a_coarse_load_cell_hangs_where_more_repeats_than_its_own_end_in_a_jump():
    columns = strokes()
    columns["force"][450:490] = columns["force"][450]
    coarse = {**columns, "force": 3.0 * np.round(columns["force"] / 3.0)}
    assert np.mean(np.diff(coarse["force"]) == 0.0) > 0.1
    ((name, rows),) = frozen_rows(coarse).items()
    assert name == "force" and list(np.flatnonzero(rows)) == list(range(450, 490))  # 449 reads the same by chance


@pytest.mark.parametrize("digits", [2, 12])
def test_holds_clips_and_coarse_sensors_do_not_hang(digits):
    smooth = np.interp(np.arange(2000) % 400, [0, 100, 160, 170, 400], [0, 40, 40, 0, 0])
    columns = strokes() | {"displacement": smooth}
    columns["force"] = np.maximum(columns["force"], 320.0)
    columns["pressure"] = np.round(columns["pressure"], 3)
    assert frozen_rows({key: np.round(x, digits) for key, x in columns.items()}) == {}


def test_a_sensor_hangs_through_a_hold_and_wakes_where_it_fell_asleep():
    """The muscle moves a little, rests, and comes by again: no jump, and no long way."""
    columns = strokes()
    x = columns["displacement"] = np.interp(np.arange(2000) % 40, [0, 12, 28, 40], [0.0, 24.0, 24.0, 0.0])
    columns["force"] = 900.0 - 10.0 * x + np.random.default_rng(3).standard_normal(2000)
    columns["force"][409:432] = columns["force"][409]  # the last 3 rows out, the hold, and the first 3 back
    ((name, rows),) = frozen_rows(columns).items()
    assert name == "force" and list(np.flatnonzero(rows)) == list(range(410, 432))


def test_a_load_cell_hangs_in_a_slow_turn_and_wakes_where_it_fell_asleep():
    columns, t = strokes(), np.arange(2000)
    x = columns["displacement"] = 40.0 * np.sin(t / 20.0) + np.random.default_rng(3).normal(0.0, 0.02, 2000)
    columns["force"] = 900.0 - x + np.random.default_rng(4).standard_normal(2000)
    turn = slice(654, 665)  # about the 10th quarter, 2 mm there and back
    columns["force"][turn] = columns["force"][654]
    ((name, rows),) = frozen_rows(columns).items()
    assert name == "force" and list(np.flatnonzero(rows)) == list(range(655, 665))


def test_a_gauge_hangs_while_its_set_pressure_goes_on_and_wakes_where_it_fell_asleep():
    rng, columns = np.random.default_rng(3), strokes()
    columns["pressure_set"] = np.interp(np.arange(2000) % 400, [0, 200, 400], [0.1, 0.5, 0.1])
    columns["pressure"] = columns["pressure_set"] + rng.normal(0, 2e-3, 2000)
    columns["pressure"][570:631] = columns["pressure"][570]
    columns["pressure"][631] = columns["pressure"][570] + 0.002
    ((name, rows),) = frozen_rows(columns).items()
    assert name == "pressure" and list(np.flatnonzero(rows)) == list(range(571, 631))
    held = columns | {"pressure_set": np.full(2000, 0.3)}
    assert frozen_rows(held) == {}, "a pressure that is held may stay the same"


def test_hung_rows_are_left_out_and_counted(put):
    columns = strokes()
    columns["force"][450:490] = columns["force"][450]
    rows = np.column_stack([0.02 * np.arange(2000), columns["pressure"], columns["displacement"], columns["force"]])
    text = "\n".join([",".join(HEADERS), *(",".join(map(repr, row)) for row in rows.tolist())])
    record = read_record(put(text))
    (note,) = record.notes
    assert len(record) == 2000 - 39 and (note.code, note.column, note.rows) == ("frozen_sensor", "force_N", 39)
    assert "row 453" in note.text


# --- constants of single runs ------------------------------------------------------------------------------------

NO_SHAPE = as_text(("time_s", "pressure_MPa", "force_N"), np.delete(values()[:12], 2, axis=1))
RUNS = "[runs.'r1.csv']\nlength_mm = 190\ntemperature_C = 21\n[runs.'r2.csv']\nlength_mm = 170\ntemperature_K = 300\n"


def two_runs(put, text, mapping):
    for k in (1, 2):
        path = put(text, f"r{k}.csv", mapping)
    return path.parent


def test_runs_have_constants_of_their_own(put):
    record = read_record(two_runs(put, NO_SHAPE, RUNS))
    np.testing.assert_allclose(record.inputs.contraction, [0.05] * 12 + [0.15] * 12)
    np.testing.assert_allclose(record.inputs.temperature, [21.0] * 12 + [26.85] * 12)
    assert record.notes == ()


def test_a_load_stands_for_the_force_that_was_not_measured(put):
    text = as_text(HEADERS[:3], values()[:12, :3])
    record = read_record(two_runs(put, text, "[runs.'r1.csv']\nload_N = 50\n[runs.'r2.csv']\nload_N = 80\n"))
    np.testing.assert_allclose(record.force, [50.0] * 12 + [80.0] * 12)
    measured = read_record(
        two_runs(put, as_text(rows=values()[:12]), "[runs.'r1.csv']\nload_kg=5\n[runs.'r2.csv']\nload_kg=8\n")
    )
    np.testing.assert_allclose(measured.force, np.tile(FORCE[:12], 2))


def test_a_run_of_another_initial_length_is_told(put):
    lengths = "[runs.'r1.csv']\ninitial_length_mm = 200\n[runs.'r2.csv']\ninitial_length_mm = 100\n"
    record = read_record(two_runs(put, as_text(rows=values()[:12]), lengths))
    np.testing.assert_allclose(record.inputs.contraction[12:], 2.0 * record.inputs.contraction[:12])
    (note,) = record.notes
    assert note.code == "run_lengths" and "100 to 100 mm" in note.text


@pytest.mark.parametrize(
    ("mapping", "words"),
    [
        (RUNS.replace("temperature_K = 300\n", ""), ["temperature_C", "'r2.csv'"]),
        (RUNS.replace("r2.csv", "r3.csv"), ["'r3.csv'", "no such file"]),
        (RUNS.replace("length_mm = 190", "lenght_mm = 190"), ["lenght_mm"]),
        (RUNS.replace("length_mm = 190", "length_mm = '190'"), ["'190'"]),
        (RUNS.replace("temperature_C =", "force_N =").replace("temperature_K =", "force_kN ="), ["force is a column"]),
        ("[runs.'r1.csv']\nspecimen = 'other.toml'\n[runs.'r2.csv']\nspecimen = 'specimen.toml'\n", ["another muscle"]),
        ("runs = 3\n", ["[runs]"]),
    ],
)
def test_constants_of_runs_that_cannot_be(put, mapping, words):
    folder = two_runs(put, NO_SHAPE, mapping)
    (folder / "other.toml").write_text((folder / "specimen.toml").read_text().replace("10.0", "12.0"))
    refusal(folder, "columns.toml", *words)


def test_one_constant_for_all_runs_is_never_silent(put):
    mapping = "[columns]\ntime_s = 1\npressure_MPa = 2\nforce_N = 3\nlength_mm = { value = 190 }\n"
    folder = two_runs(put, NO_SHAPE, mapping)
    (note,) = read_record(folder).notes
    assert (note.code, note.column) == ("one_for_all_runs", "length_mm") and "190 was taken for 2 runs" in note.text
    assert read_record(folder / "r1.csv").notes == ()
    own = mapping + "[runs.'r1.csv']\nlength_mm = 170\n[runs.'r2.csv']\nlength_mm = 180\n"
    record = read_record(two_runs(put, NO_SHAPE, own))
    np.testing.assert_allclose(record.inputs.contraction, [0.15] * 12 + [0.1] * 12)
    assert record.notes == ()
