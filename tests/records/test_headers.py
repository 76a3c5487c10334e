"""Headers that are no quantity's name: taken by word and unit where these leave no choice, else refused with help."""

import re
import tomllib

import numpy as np
import pytest

from pam_ident.core import DataError, Specimen
from pam_ident.core.units import split_header
from pam_ident.records import read_record

MUSCLE = Specimen("muscle", 200.0, 10.0, 25.0)
TIME = np.arange(40) * 0.1
WAY = 20.0 * (1.0 - np.cos(TIME))
ROWS = np.column_stack([TIME, 2.0 + 0.0 * TIME, WAY, 500.0 - 8.0 * WAY])
NAMED = ["time_s", "pressure_bar", "displacement_mm", "force_N"]


def written(folder, headers, mark=",", rows=ROWS):
    path = folder / "run.csv"
    lines = [mark.join(headers), *(mark.join(f"{cell:.4f}" for cell in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def read(folder, headers, mark=",", rows=ROWS):
    return read_record(written(folder, headers, mark, rows), MUSCLE)


def test_a_muscles_length_in_german_is_a_length(tmp_path):
    found = read(
        tmp_path, [*NAMED[:2], "Muskellänge [mm]", "force_N"], rows=np.c_[ROWS[:, :2], 200.0 - WAY, ROWS[:, 3]]
    )
    np.testing.assert_allclose(found.inputs.contraction, WAY / 200.0, atol=1e-6)


@pytest.mark.parametrize(("every", "read_too"), [(1, True), (5, False)])
def test_a_temperature_is_taken_by_its_word_where_each_row_has_one(tmp_path, every, read_too):
    """A slow thermocouple's empty cells would cost the rows."""
    cells = [f"{20.0 + 0.1 * k:.1f}" if k % every == 0 else "" for k in range(len(ROWS))]
    lines = [",".join([*(f"{v:.4f}" for v in row), cell]) for row, cell in zip(ROWS, cells, strict=True)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join([",".join([*NAMED, "Temperatur [°C]"]), *lines]) + "\n", encoding="utf-8")
    found = read_record(path, MUSCLE)
    assert len(found) == len(ROWS) and (found.inputs.temperature is not None) is read_too


@pytest.mark.parametrize(
    ("mark", "headers"),
    [
        (",", ["t [s]", "p [bar]", "x [mm]", "F [N]"]),
        (",", ["Elapsed Time (s)", "Press (bar)", "STROKE (MM)", "Load (N)"]),
        (",", ["TIME (sec)", "Sensor 3 [bar]", "Disp (mm)", "load_N"]),
        (";", ["Zeit [s]", "Druck [bar]", "Weg [mm]", "Kraft [N]"]),
        (";", ["Zeit [s]", "Druck [bar]", "Verkürzung [mm]", "Kraft [N]"]),
        (";", ["Time, s", "Pressure, bar", "Displacement, mm", "Force, N"]),
        (";", ["Zeit, s", "Druck, bar", "Weg, mm", "Kraft, N"]),
        (";", ["Zeit in s", "Überdruck in bar", "Verkürzung in mm", "Zugkraft in N"]),
        (";", ["Time in s", "Pressure in bar", "Stroke in mm", "Load in N"]),
        (";", ["Zeit s", "Druck bar", "Weg mm", "Kraft N"]),
        (",", ["Time s", "Pressure bar", "Stroke mm", "Force N"]),
        (";", ["Zeit / s", "Druck / bar", "s / mm", "Kraft / N"]),
        (";", ["t/s", "p/bar", "x/mm", "F/N"]),
        (";", ["Temps (s)", "Pression (bar)", "Course (mm)", "Effort (N)"]),
        (",", ["time_s", "pressure_sensor_bar", "displacement_mm", "force_N"]),
    ],
)
def test_word_and_unit_say_what_a_column_is(tmp_path, mark, headers):
    found, named = read(tmp_path, headers, mark), read(tmp_path, NAMED)
    for one, other in ((found.inputs.time, named.inputs.time), (found.force, named.force)):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(found.inputs.pressure, named.inputs.pressure)
    np.testing.assert_array_equal(found.inputs.contraction, named.inputs.contraction)
    guessed = [
        header for header in headers if split_header(header)[0] not in ("time", "pressure", "displacement", "force")
    ]
    told = " ".join(note.text for note in found.notes if note.code == "guessed_columns")
    assert all(repr(header) in told for header in guessed) and bool(told) == bool(guessed)


@pytest.mark.parametrize(
    "header",
    [
        "p_abs [bar]", "p_abs_bar", "Absolutdruck [bar]", "absolute pressure (bar)", "Druck absolut [bar]",
        "Pressure abs [bar]", "pressure_abs_bar", "Pressure (abs) [bar]", "pAbs / bar", "Druck bar abs",
    ],
)  # fmt: skip
def test_a_pressure_whose_name_says_so_is_absolute(tmp_path, header):
    found = read(tmp_path, ["time_s", header, *NAMED[2:]])
    np.testing.assert_allclose(found.inputs.pressure, 0.2 - 0.101325)
    assert [note.column for note in found.notes if note.code == "absolute_pressure"] == [header]


@pytest.mark.parametrize("header", ["ABSORBER p [bar]", "Absorberdruck_bar", "abscissa_pressure [bar]"])
def test_a_word_that_begins_like_absolute_is_another(tmp_path, header):
    np.testing.assert_allclose(read(tmp_path, ["time_s", header, *NAMED[2:]]).inputs.pressure, 0.2)


def test_a_row_of_units_agrees_with_a_name_that_says_absolute_and_parts_no_channel_from_its_letter(tmp_path):
    units = ["s", "bar", "mm", "N"]
    path = written(tmp_path, ["time", "p_abs_bar", "Weg C", "Kraft N"])
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([head, ",".join(units), *rows]), encoding="utf-8")
    found = read_record(path, MUSCLE)
    np.testing.assert_allclose(found.inputs.pressure, 0.2 - 0.101325)
    assert found.columns["displacement"] == "Weg C [mm]"


@pytest.mark.parametrize("header", ["v mm/s", "Speed in mm/s", "Flow l/min", "Force rate N/s", "Run 1", "Trial N"])
def test_the_end_of_a_rate_or_of_a_number_is_no_unit(tmp_path, header):
    found = read(tmp_path, [header, "p [bar]", "x [mm]", "F [N]"])
    assert found.inputs.time is None and found.passed == (header,)


@pytest.mark.parametrize(
    ("headers", "missing"),
    [
        (["time_s", "p [bar]", "Supply [bar]", "force_N"], ["no pressure and no displacement"]),
        (["time_s", "p_set [bar]", "x [mm]", "F [N]"], ["no pressure column"]),
        (["time_s", "Sollwert [bar]", "x [mm]", "F [N]"], ["no pressure column"]),
        (["time_s", "p [bar]", "Sensor [mm]", "F [N]"], ["displacement_mm, contraction"]),
        (["time_s", "p [bar]", "x [mm]", "Set force [N]"], ["no force column"]),
        (["time_s", "p [bar]", "x [mm]", "cycle_N"], ["no force column"]),
        (["x [mm]", "p [bar]", "L [mm]", "F [N]"], ["displacement_mm, contraction"]),
        (["time", "pressure [bar]", "displacement", "force"], ["'time': no unit", "'displacement': no", "'force': no"]),
        (["time_s", "p1 [bar]", "p2 [bar]", "force_N"], ["no pressure and no displacement", "'p2 [bar]' (pressure)"]),
        (["time_s", "pressure", "way", "load"], ["no force and no displacement", 'force_N = "load"', '"way"']),
    ],
)
def test_what_may_be_several_things_is_refused_and_all_that_is_missing_is_told_at_once(tmp_path, headers, missing):
    with pytest.raises(DataError) as error:
        read(tmp_path, headers)
    message = str(error.value)
    assert all(words in message for words in missing) and len(message.splitlines()) <= 2, message


def test_a_refusal_shows_the_columns_that_would_be_right(tmp_path):
    driven = np.column_stack([0 * TIME, TIME > 2.0, 0 * TIME, (2.0 + (TIME > 2.0)) * ROWS[:, 3] / 2.0])
    with pytest.raises(DataError) as error:
        read(tmp_path, ["Sekunden", "AI0", "AI1", "AI2"], rows=ROWS * [1.0, 1.0, 1.0, 0.0] + driven)
    ready = str(error.value).partition("is: ")[2]
    assert [*tomllib.loads(ready)["columns"].values()] == ["Sekunden", "AI0", "AI1", "AI2"]
    (tmp_path / "columns.toml").write_text(ready, encoding="utf-8")
    assert set(read_record(tmp_path / "run.csv", MUSCLE).columns) >= {"time", "pressure", "displacement", "force"}


def test_a_joint_is_offered_its_lever_and_a_column_is_named_with_its_unit_or_without(tmp_path):
    angle = np.column_stack([ROWS[:, 0], ROWS[:, 1], ROWS[:, 2] / 30.0, 0.03 * ROWS[:, 3]])
    headers = ["time_s", "pressure_MPa", "Knee [rad]", "Torque (Nm)"]
    with pytest.raises(DataError) as error:
        read(tmp_path, headers, rows=angle)
    offered = 'lever = {torque_Nm = "Torque (Nm)", angle_rad = "Knee [rad]", radius_mm = "?"}'
    assert str(error.value).endswith(offered) and "each ? is filled in" in str(error.value)
    (tmp_path / "columns.toml").write_text(offered.replace(" (Nm)", "").replace('"?"', "30"), encoding="utf-8")
    record = read_record(tmp_path / "run.csv", MUSCLE)
    assert record.force == pytest.approx(ROWS[:, 3], rel=1e-3)


def test_units_below_the_header_and_the_sign_for_micro_are_known_to_the_guess(tmp_path):
    text = "Zeit;Druck;Weg;Kraft\n[ms];[mbar];[µm];[cN]\n"
    text += "".join(f"{k};{1000 + k};{k};{900 + k}\n" for k in range(30))
    (tmp_path / "run.csv").write_text(text, encoding="utf-8")
    with pytest.raises(DataError) as error:
        read_record(tmp_path / "run.csv", MUSCLE)
    assert 'displacement_um = "Weg", force_N = {column = "Kraft", factor = "?"}' in str(error.value)


def test_a_header_in_another_encoding_is_not_offered_as_it_looks(tmp_path):
    text = "時間(s),圧力(MPa),変位(mm),荷重(N)\n" + "".join(f"{k},0.2,{k},{900 - k}\n" for k in range(30))
    (tmp_path / "run.csv").write_bytes(text.encode("shift_jis"))
    with pytest.raises(DataError, match="encoding = 'shift_jis'"):
        read_record(tmp_path / "run.csv", MUSCLE)


def test_a_column_of_another_unit_is_not_offered(tmp_path):
    """The second clock goes with the stroke, and no column is of its length."""
    rows = np.column_stack([ROWS, WAY])[:, [0, 1, 4, 3]]
    with pytest.raises(DataError) as error:
        read(tmp_path, ["Zeit in s", "Druck", "t2 [s]", "Kraft"], rows=rows)
    assert 'displacement_mm = "?"' in str(error.value)


def test_branches_in_other_words_are_refused_with_the_line_that_tells_them(tmp_path):
    path = written(tmp_path, [*NAMED, "Branch"], rows=np.column_stack([ROWS, np.signbit(np.sin(TIME)).astype(float)]))
    path.write_text(path.read_text().replace(",0.0000\n", ",infl\n").replace(",1.0000\n", ",defl\n"))
    with pytest.raises(DataError, match=r"columns\.toml") as error:
        read_record(path, MUSCLE)
    line = re.search(r"branch = \{.*?\}", str(error.value))
    assert line and tomllib.loads(line[0]) == {
        "branch": {"column": "Branch", "contraction": "infl", "extension": "defl"}
    }
    columns = [f'{name} = "{name}"' for name in NAMED]
    (tmp_path / "columns.toml").write_text("\n".join(["[columns]", *columns, line[0]]), encoding="utf-8")
    np.testing.assert_array_equal(read_record(path, MUSCLE).inputs.direction, np.where(np.sin(TIME) < 0.0, -1.0, 1.0))


def test_a_column_called_a_time_that_does_not_run_on_is_no_clock(tmp_path):
    rows = ROWS.copy()
    rows[:, 0] = 5.0
    assert read(tmp_path, ["Hold [s]", *NAMED[1:]], rows=rows).inputs.time is None


def test_a_clock_without_a_unit_is_refused(tmp_path):
    with pytest.raises(DataError, match="'Timestamp': no unit given"):
        read(tmp_path, ["Timestamp", *NAMED[1:]])


def test_a_mass_in_the_file_is_the_load_that_hangs_there(tmp_path):
    found = read(tmp_path, [*NAMED[:3], "mass_kg"])
    np.testing.assert_allclose(found.force, 9.80665 * read(tmp_path, NAMED).force)
    assert found.columns["force"] == "mass_kg"
    both = np.column_stack([ROWS, ROWS[:, 3] / 9.80665])
    assert read(tmp_path, [*NAMED, "load_kg"], rows=both).columns["force"] == "force_N"


def test_commas_within_names_are_no_delimiter(tmp_path):
    """Under the comma two quantities are known, and no row is of numbers; under the semicolon none is by its name."""
    headers = ["Zeit [s]", "Druck, pressure, relativ [bar]", "Weg [mm]", "Kraft, force, zentral [N]"]
    assert read(tmp_path, headers, ";").columns["force"] == headers[3]


def test_a_contraction_in_millimetres_is_a_displacement(tmp_path):
    headers = ["time_s", "pressure_bar", "Contraction [mm]", "force_N"]
    assert np.allclose(read(tmp_path, headers).inputs.displacement_mm, WAY, atol=1e-4)


@pytest.mark.parametrize("header", ["F [g]", "Kraft [kp]", "F [mlb]", "mass_lb", "load_g"])
def test_no_unit_that_is_not_known_is_taken_for_that_of_the_key(tmp_path, header):
    path = written(tmp_path, ["time_s", "pressure_bar", "displacement_mm", header])
    keys = "time_s = 'time_s'\npressure_bar = 'pressure_bar'\ndisplacement_mm = 'displacement_mm'\n"
    (tmp_path / "columns.toml").write_text(f"[columns]\n{keys}force_N = '{header}'\n", encoding="utf-8")
    with pytest.raises(DataError, match="is no unit that is known; give the factor"):
        read_record(path, MUSCLE)


@pytest.mark.parametrize("factor", ["", "0.1"])
def test_a_unit_that_nobody_knows_needs_a_factor(tmp_path, factor):
    path = written(tmp_path, ["t (s)", "P (V)", "x (mm)", "F (N)"])
    with pytest.raises(DataError, match=re.escape('pressure_bar = {column = "P (V)", factor = "?"}')):
        read_record(path, MUSCLE)
    pressure = f"{{column = 'P (V)', factor = {factor}}}" if factor else "'P (V)'"
    keys = f"time_s = 't (s)'\npressure_MPa = {pressure}\ndisplacement_mm = 'x (mm)'\nforce_N = 'F (N)'\n"
    (tmp_path / "columns.toml").write_text(f"[columns]\n{keys}", encoding="utf-8")
    if factor:
        assert np.allclose(read_record(path, MUSCLE).inputs.pressure, 0.2)
    else:
        with pytest.raises(DataError, match="'V' is no unit that is known; give the factor"):
            read_record(path, MUSCLE)


def test_two_columns_that_may_each_be_it_are_both_told(tmp_path):
    rows = np.column_stack([ROWS, ROWS[:, 1]])
    told = "('P1 (bar)' and 'P2 (bar)' may each be the pressure); name it pressure_MPa"
    with pytest.raises(DataError, match=re.escape(told)):
        read(tmp_path, ["time_s", "P1 (bar)", "displacement_mm", "force_N", "P2 (bar)"], rows=rows)
