"""Headers that are no quantity's name: taken by word and unit where these leave no choice, else refused with help."""

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
    ("headers", "missing"),
    [
        (["time_s", "p [bar]", "Supply [bar]", "force_N"], ["no pressure and no displacement"]),
        (["time_s", "p_set [bar]", "x [mm]", "F [N]"], ["no pressure column"]),
        (["time_s", "Sollwert [bar]", "x [mm]", "F [N]"], ["no pressure column"]),
        (["time_s", "p [bar]", "Sensor [mm]", "F [N]"], ["displacement_mm, contraction"]),
        (["time_s", "p [bar]", "x [mm]", "Set force [N]"], ["no force column"]),
        (["time_s", "p [bar]", "x [mm]", "cycle_N"], ["no force column"]),
        (["x [mm]", "p [bar]", "L [mm]", "F [N]"], ["displacement_mm, contraction"]),
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
