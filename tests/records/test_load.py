"""A record as a rig logs it: what is read, and how each kind of bad file is refused."""

import numpy as np
import pytest

from pam_ident.core import DataError, Specimen
from pam_ident.records import file_sha256, read_record, read_specimen
from pam_ident.records.record import counted_anew

SPECIMEN = """[specimen]
name = "m1"
initial_length_mm = 200
initial_radius_mm = 10.0
braid_angle_deg = 25.4
wall_thickness_mm = 1.5
"""
GOOD = "time_s,pressure_MPa,displacement_mm,force_N\n" + "".join(
    f"{0.1 * i:.1f},0.3,{2.0 * i:.1f},{900 - 10 * i}\n" for i in range(12)
)


@pytest.fixture
def write(tmp_path):
    """Writes record.csv and specimen.toml, and returns the path of the record."""

    def inner(text, specimen=SPECIMEN, name="record.csv"):
        (tmp_path / name).write_text(text, encoding="utf-8")
        if specimen is not None:
            (tmp_path / "specimen.toml").write_text(specimen, encoding="utf-8")
        return tmp_path / name

    return inner


def refusal(path, **options):
    with pytest.raises(DataError) as caught:
        read_record(path, **options)
    assert caught.value.exit_code == 4
    message = str(caught.value)
    assert str(path.parent) in message and len(message.splitlines()) <= 2
    return message


def table(header, rows):
    return header + "\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n"


def test_columns_arrive_in_internal_units_with_their_origin(write):
    path = write(GOOD)
    record = read_record(path)
    assert record.name == "m1" and record.source == str(path) and record.sha256 == file_sha256(path)
    assert record.columns == {
        "time": "time_s",
        "pressure": "pressure_MPa",
        "displacement": "displacement_mm",
        "force": "force_N",
    }
    assert record.specimen == Specimen("m1", 200.0, 10.0, 25.4, 1.5)
    np.testing.assert_allclose(record.force, 900.0 - 10.0 * np.arange(12))
    np.testing.assert_allclose(record.inputs.contraction, 0.01 * np.arange(12), atol=1e-15)
    np.testing.assert_allclose(record.inputs.displacement_mm, 2.0 * np.arange(12), atol=1e-12)


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("time_s,pressure_MPa,displacement_mm,force_N", (0.25, 0.3, 20, 440)),
        ("time_ms,pressure_kPa,displacement_cm,force_kN", (250, 300, 2, 0.44)),
        ("Time [ms],Pressure [bar],Displacement [m],Force (kN)", (250, 3, 0.02, 0.44)),
        ("Time (min),Pressure (Pa),Displacement (um),Force (mN)", (0.25 / 60, 3e5, 2e4, 4.4e5)),
        ("time_s,pressure_psi,displacement_in,force_lbf", (0.25, 43.5113213, 20 / 25.4, 98.9159351)),
        ("time_s,pressure_mbar,contraction,Force [kgf]", (0.25, 3000, 0.1, 44.86751)),
        ("time_s,pressure_bar,displacement_mm,force_daN", (0.25, 3, 20, 44)),
        ("time_s,pressure_MPa,contraction_pct,force_N", (0.25, 0.3, 10, 440)),
        ("time_s,pressure_MPa,Contraction [%],force_N", (0.25, 0.3, 10, 440)),
        ("time_s,pressure_MPa,length_mm,force_N", (0.25, 0.3, 180, 440)),
        ("TIME_S, PRESSURE [MPA], LENGTH [CM], FORCE [N]", (0.25, 0.3, 18, 440)),
    ],
)
def test_every_way_to_write_a_column_gives_the_same_record(write, header, row):
    later = [row[0] * 2, *row[1:]]
    record = read_record(write(table(header, [row, later])))
    assert record.inputs.time[0] == pytest.approx(0.25)
    assert record.inputs.pressure[0] == pytest.approx(0.3, rel=1e-8)
    assert record.inputs.contraction[0] == pytest.approx(0.1, rel=1e-8)
    assert record.force[0] == pytest.approx(440.0, rel=1e-6)


def test_optional_columns_are_read_and_others_left_alone(write):
    rows = [(0.1 * i, 0.3, 0.301, 2 * i, 900 - i, 294.15, 1 + i // 6, "x") for i in range(12)]
    header = "time_s,pressure_set_MPa,pressure_MPa,displacement_mm,force_N,temperature_K,cycle,remark"
    record = read_record(write(table(header, rows)))
    np.testing.assert_allclose(record.inputs.temperature, 21.0)
    np.testing.assert_array_equal(record.inputs.cycle, [1] * 6 + [2] * 6)
    np.testing.assert_allclose(record.level, 0.3)
    np.testing.assert_allclose(record.inputs.pressure, 0.301)
    assert "remark" not in record.columns


def test_a_branch_column_overrides_the_motion(write):
    rows = [(0.1 * i, 0.3, 2 * i, 900 - i, " Extension " if i < 5 else "contraction") for i in range(12)]
    record = read_record(write(table("time_s,pressure_MPa,displacement_mm,force_N,branch", rows)))
    np.testing.assert_array_equal(record.inputs.direction, [-1.0] * 5 + [1.0] * 7)


def test_a_byte_order_mark_windows_line_ends_and_spaces_do_no_harm(write):
    path = write(GOOD)
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").replace(",", ", ").encode())
    np.testing.assert_allclose(read_record(path).force, 900.0 - 10.0 * np.arange(12))


def test_a_static_table_needs_no_time_and_is_cut_into_isobars_and_lengths(write):
    rows = [(L, p, 10 * p - L, 0) for L in (196, 180, 160) for p in range(100, 700, 100)]
    record = read_record(write(table("length_mm,pressure_kPa,force_N,slack", rows)))
    assert record.inputs.time is None and not record.inputs.has("branch") and not record.inputs.has("motion")
    np.testing.assert_allclose(record.levels, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert record.block_kind == "length" and len(np.unique(record.block)) == 3
    for block in range(3):
        assert len(np.unique(record.inputs.contraction[record.block == block])) == 1


def test_a_static_table_of_many_lengths_is_held_out_by_isobar(write):
    rows = [(round(0.003 * i + 0.0004 * k, 5), 0.1 * k, 500 - i) for k in (1, 2, 3) for i in range(30)]
    record = read_record(write(table("contraction,pressure_MPa,force_N", rows)))
    assert record.block_kind == "isobar" and len(np.unique(record.block)) == 3


def test_rows_marked_slack_are_masked_and_counted(write):
    rows = [(196, p, max(p - 250, 0), int(p < 250)) for p in range(100, 700, 100)]
    record = read_record(write(table("length_mm,pressure_kPa,force_N,slack", rows)))
    assert record.masked == 2 and len(record) == 4 and record.force.min() == 50.0


def test_a_table_that_is_all_slack_is_refused(write):
    message = refusal(write(table("length_mm,pressure_kPa,force_N,slack", [(196, 100, 0, 1)] * 3)))
    assert "slack" in message


# --- bad records -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("column", ["pressure_MPa", "force_N", "displacement_mm"])
def test_a_missing_column_is_named_with_those_that_are_there(write, column):
    path = write(GOOD.replace(column, "column_9"))
    message = refusal(path)
    assert str(path) in message and "row 1" in message and column.split("_")[0] in message and "column_9" in message


@pytest.mark.parametrize(
    ("old", "new", "unit"),
    [
        ("force_N", "Force [stone]", "stone"),
        ("pressure_MPa", "pressure [torr]", "torr"),
        ("time_s", "time [weeks]", "weeks"),
    ],
)
def test_an_unknown_unit_is_named_with_its_column_and_the_known_ones(write, old, new, unit):
    path = write(GOOD.replace(old, new))
    message = refusal(path)
    assert str(path) in message and repr(new) in message and repr(unit) in message and "expected one of" in message


def test_a_column_without_unit_is_refused(write):
    message = refusal(write(GOOD.replace("force_N", "force")))
    assert "column 'force'" in message and "no unit given" in message


@pytest.mark.parametrize(("old", "new"), [("time_s", "time_hr"), ("force_N", "force_stone")])
def test_an_unknown_unit_in_a_suffix_is_never_passed_over_in_silence(write, old, new):
    message = refusal(write(GOOD.replace(old, new)))
    assert new in message


def test_a_unit_of_another_dimension_is_refused(write):
    message = refusal(write(GOOD.replace("force_N", "force_mm")))
    assert "'force_mm'" in message and "'mm'" in message


@pytest.mark.parametrize("column", ["time_s", "pressure_MPa", "displacement_mm", "force_N"])
@pytest.mark.parametrize("cell", ["abc", "1,5", "inf", "12 N"])
def test_a_cell_that_is_no_number_is_named_by_row_and_column(write, column, cell):
    lines = [line.split(",") for line in GOOD.splitlines()]
    lines[7][lines[0].index(column)] = f'"{cell}"' if "," in cell else cell
    path = write("\n".join(",".join(line) for line in lines) + "\n")
    message = refusal(path)
    assert str(path) in message and "row 8," in message and repr(column) in message and cell in message


@pytest.mark.parametrize("column", ["time_s", "pressure_MPa", "displacement_mm", "force_N"])
@pytest.mark.parametrize("cell", ["NaN", "", "-", "N/A"])
def test_a_row_with_an_empty_cell_is_left_out_and_counted(write, column, cell):
    lines = [line.split(",") for line in GOOD.splitlines()]
    lines[7][lines[0].index(column)] = cell
    record = read_record(write("\n".join(",".join(line) for line in lines) + "\n"))
    np.testing.assert_allclose(record.force, np.delete(900.0 - 10.0 * np.arange(12), 6))
    (note,) = record.notes
    assert (note.code, note.column, note.rows) == ("empty_cells", column, 1) and "row 8)" in note.text


def test_a_column_with_nothing_in_it_is_bad_data(write):
    lines = [line.split(",") for line in GOOD.splitlines()]
    path = write("\n".join(",".join([*line[:3], "" if k else line[3]]) for k, line in enumerate(lines)) + "\n")
    assert "'force_N': holds nothing" in refusal(path)


def test_further_bad_cells_are_counted(write):
    message = refusal(write(GOOD.replace("890", "x").replace("850", "y")))
    assert "row 3," in message and "'x'" in message and "1 more" in message


def test_an_empty_file_is_refused(write):
    path = write("")
    assert f"{path}: the file is empty" in refusal(path)


def test_a_file_with_a_header_only_is_refused(write):
    path = write(GOOD.splitlines()[0] + "\n")
    assert f"{path}: a header but no rows" in refusal(path)


def test_a_saved_answer_is_no_record(write):
    path = write('{\n  "schema": "pam-ident/fit/1",\n  "law": "sarosi"\n}\n')
    assert f"{path}: JSON that this program wrote" in refusal(path)


def test_no_name_is_no_folder(write):
    write(GOOD)
    with pytest.raises(DataError, match="no record was named"):
        read_record("")


def test_a_length_in_place_of_a_displacement_is_recognised(write):
    lines = [line.split(",") for line in GOOD.splitlines()]
    place = lines[0].index("displacement_mm")
    for k, line in enumerate(lines[1:]):
        line[place] = str(200.0 - 2.0 * k)
    said = refusal(write("\n".join(map(",".join, lines)) + "\n"))
    assert "'displacement_mm'" in said and "looks like the muscle's length: call the column length_mm" in said


def test_a_missing_file_is_refused(write, tmp_path):
    write(GOOD)
    assert "no such file" in refusal(tmp_path / "gone.csv")


def test_a_folder_in_place_of_a_file_is_refused(write, tmp_path):
    write(GOOD)
    (tmp_path / "folder.csv").mkdir()
    assert "folder.csv" in refusal(tmp_path / "folder.csv")


def test_a_file_that_is_no_text_is_refused(write):
    path = write(GOOD)
    path.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff\xfe\xfa")
    assert "not a readable CSV" in refusal(path)


def test_a_row_with_too_many_cells_is_refused(write):
    message = refusal(write(GOOD + "1.3,0.3,1,2,3,4,5\n"))
    assert "14" in message


def test_time_that_runs_backwards_is_named_by_row(write):
    path = write(GOOD.replace("\n0.5,", "\n0.05,"))
    message = refusal(path)
    assert str(path) in message and "row 7," in message and "'time_s'" in message and "backwards" in message


def test_two_columns_for_one_quantity_are_refused(write):
    path = write(GOOD.replace("time_s", "force_kN"))
    message = refusal(path)
    assert str(path) in message and "'force_kN'" in message and "'force_N'" in message


def test_the_same_header_twice_is_refused(write):
    lines = GOOD.splitlines()
    path = write("\n".join([lines[0] + ",force_N", *(line + ",1" for line in lines[1:])]) + "\n")
    message = refusal(path)
    assert str(path) in message and "force_N" in message


def test_two_columns_for_the_shape_are_refused(write):
    path = write(GOOD.replace("time_s", "contraction"))
    message = refusal(path)
    assert str(path) in message and "displacement_mm" in message and "contraction" in message and "keep one" in message


@pytest.mark.parametrize(
    ("column", "value"),
    [("contraction", 12.0), ("length_mm", 0.2), ("displacement_mm", 230), ("displacement_mm", -300)],
)
def test_a_wild_contraction_is_refused_by_row_and_column_with_advice_on_the_unit(write, column, value):
    good = {"contraction": 0.1, "length_mm": 190, "displacement_mm": 10}[column]
    path = write(table(f"pressure_MPa,{column},force_N", [(0.3, good, 500)] * 4 + [(0.3, value, 400)]))
    message = refusal(path)
    assert str(path) in message and "row 6," in message and repr(column) in message and "initial_length_mm" in message


def test_a_pressure_in_the_wrong_unit_is_refused_by_row(write):
    message = refusal(write(GOOD.replace("0.5,0.3,", "0.5,300,")))
    assert "row 7," in message and "'pressure_MPa'" in message


def test_an_unknown_branch_is_refused_by_row(write):
    rows = [(0.3, 0.01 * i, 500, "contraction" if i < 3 else "sideways") for i in range(5)]
    message = refusal(write(table("pressure_MPa,contraction,force_N,branch", rows)))
    assert "row 5," in message and "'branch'" in message and "'sideways'" in message


# --- specimen ----------------------------------------------------------------------------------------------------


def test_a_specimen_file_can_be_given_by_path_or_as_an_object(write, tmp_path):
    path = write(GOOD, specimen=None)
    other = tmp_path / "other.toml"
    other.write_text(SPECIMEN.replace("200", "400"), encoding="utf-8")
    assert read_record(path, other).inputs.contraction[1] == pytest.approx(0.005)
    assert read_record(path, Specimen("z", 100.0)).inputs.contraction[1] == pytest.approx(0.02)


def test_a_missing_specimen_file_is_refused_with_what_to_write(write):
    message = refusal(write(GOOD, specimen=None))
    assert "specimen.toml" in message and "initial_length_mm" in message


def test_the_wall_may_be_left_out_of_a_specimen(write):
    path = write(GOOD, specimen=SPECIMEN.replace("wall_thickness_mm = 1.5\n", ""))
    assert read_record(path).specimen.wall_thickness_mm is None


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("wall_thickness_mm", "wall_thicknes_mm", "wall_thicknes_mm is no key of it; did you mean wall_thickness_mm?"),
        ("initial_radius_mm", "initial_diameter_mm", "lacks initial_radius_mm (initial_diameter_mm is not it); add it"),
        ("initial_", "", "lacks initial_length_mm (length_mm is not it), initial_radius_mm (radius_mm is not it); add"),
    ],
)
def test_a_slip_in_a_key_of_a_specimen_is_told(write, old, new, told):
    assert told in refusal(write(GOOD, specimen=SPECIMEN.replace(old, new)))


def test_a_note_in_a_specimen_and_a_mark_of_its_bytes_are_no_slip(write):
    path = write(GOOD, specimen="\ufeff" + SPECIMEN + "material = 'latex'\nmin_length_mm = 150\n")
    assert read_record(path).specimen.wall_thickness_mm == 1.5


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[specimen]", "[muscle]", "no table"),
        ('name = "m1"\n', "", "name"),
        ("initial_length_mm = 200\n", "", "initial_length_mm"),
        ("braid_angle_deg = 25.4\n", "", "braid_angle_deg"),
        ("= 25.4", '= "steep"', "'steep'"),
        ("= 25.4", "= true", "True"),
        ("= 25.4", "= 80", "braid_angle_deg = 80"),
        ("= 200", "= -200", "initial_length_mm = -200"),
        ("= 10.0", "= nan", "initial_radius_mm = nan"),
        ("= 200", "= = 200", "TOML"),
    ],
)
def test_a_bad_specimen_file_is_refused_by_file_and_field(tmp_path, old, new, told):
    path = tmp_path / "specimen.toml"
    path.write_text(SPECIMEN.replace(old, new), encoding="utf-8")
    with pytest.raises(DataError) as caught:
        read_specimen(path)
    assert str(path) in str(caught.value) and told in str(caught.value)


def test_cycles_that_are_counted_on_from_isobar_to_isobar_begin_anew_there():
    held = np.repeat([0.1, 0.3, 0.2], 6)
    on = np.repeat(np.arange(1.0, 10.0), 2)
    assert counted_anew(on, held).tolist() == np.tile(np.repeat([1.0, 2.0, 3.0], 2), 3).tolist()
    anew = np.tile(np.repeat([4.0, 5.0, 6.0], 2), 3)
    assert counted_anew(anew, held) is anew, "whoever counts anew says where"
    single = np.repeat([1.0, 2.0, 3.0], 6)
    assert counted_anew(single, held) is single, "then cycles of the whole test are all there is"
    assert counted_anew(anew - 4.0, held).tolist() == (anew - 3.0).tolist(), "no effect knows a cycle 0"
