"""Workbooks, MATLAB, TDMS, LVM and Parquet files, and several files that are one record."""

import builtins
import gzip
from datetime import datetime, timedelta

import numpy as np
import pandas as pd
import pytest
from corpus import FORCE, HEADERS, PRESSURE, ROWS, TIME, as_text, assert_right, values

from pam_ident.core import DataError, UsageError
from pam_ident.records import read_record
from pam_ident.records.formats.base import reading

NAMES = ("time", "pressure", "displacement", "force")
UNITS = ("s", "MPa", "mm", "N")
COLUMNS = dict(zip(HEADERS, values().T, strict=True))
HALVES = [{key: column[half] for key, column in COLUMNS.items()} for half in (slice(0, 12), slice(12, None))]
MAPPING = "[columns]\ntime_s = 1\npressure_MPa = 2\ndisplacement_mm = 3\nforce_N = 4\n"


@pytest.fixture
def folder(put):
    """A folder with a specimen in it."""
    path = put("", "empty.csv")
    path.unlink()
    return path.parent


def refusal(path, *words, error=DataError, **options):
    with pytest.raises(error) as caught:
        read_record(path, **options)
    message = str(caught.value)
    assert str(path) in message and len(message.splitlines()) <= 2
    for word in words:
        assert word in message, message


# --- Excel -------------------------------------------------------------------------------------------------------


def workbook(path, *sheets):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets:
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(list(row))
    book.save(path)
    return path


def test_a_sheet_with_preamble_and_row_of_units(folder):
    rows = [("Rig 3", "muscle 7"), (), NAMES, UNITS, *values().tolist(), (), ()]
    assert_right(read_record(workbook(folder / "r.xlsx", ("data", rows))))


def test_sheets_without_a_record_are_passed_over(folder):
    path = workbook(
        folder / "r.xlsx", ("notes", [("by", "N. N."), ("on", "Friday")]), ("1", [HEADERS, *values().tolist()])
    )
    assert_right(read_record(path))


def test_a_sheet_that_is_passed_over_beside_a_record_is_told(folder):
    """A mean in the row of units hid its headers, and a summary was taken for the record without a word."""
    log = [("t", "P", "x", "F", "mean"), ("s", "bar", "mm", "N", 414.7), *[(*row, "") for row in values().tolist()]]
    record = read_record(workbook(folder / "r.xlsx", ("log", log), ("summary", [HEADERS, *values()[:12].tolist()])))
    (note,) = [note for note in record.notes if note.code == "other_table"]
    assert "sheet 'log' is passed over" in note.text and "columns.toml" in note.text


def test_a_sheet_for_each_isobar_is_one_record(folder):
    sheets = [(str(k), [HEADERS, *values()[12 * k : 12 * k + 12].tolist()]) for k in range(2)]
    record = read_record(workbook(folder / "r.xlsx", *sheets))
    assert_right(record)
    np.testing.assert_array_equal(record.levels, [0.3, 0.45])


def test_the_clock_of_a_sheet_is_read_in_seconds(folder):
    start = datetime(2024, 5, 3, 23, 59, 59)
    rows = [(start + timedelta(seconds=float(t)), *row[1:]) for t, row in zip(TIME, values().tolist(), strict=True)]
    assert_right(read_record(workbook(folder / "r.xlsx", ("1", [("time", *HEADERS[1:]), *rows]))))


def test_a_bad_cell_of_a_sheet_is_named(folder):
    rows = values().tolist()
    rows[4][3] = "12,5"
    path = workbook(folder / "r.xlsx", ("run 1", [("Rig 3",), HEADERS, *rows]))
    refusal(path, "sheet 'run 1'", "row 7", "'force_N'", "'12,5'")
    rows[4][3] = None
    (note,) = read_record(workbook(path, ("run 1", [HEADERS, *rows]))).notes
    assert note.code == "empty_cells" and note.rows == 1 and "row 6" in note.text and "'force_N'" in note.text


def test_a_sheet_can_be_chosen_and_its_columns_numbered(put, folder):
    path = workbook(folder / "r.xlsx", ("a", [HEADERS, *(2.0 * values()).tolist()]), ("b", values().tolist()))
    put("", mapping=MAPPING + "[file]\npart = 'b'")
    assert_right(read_record(path))
    put("", mapping=MAPPING + "[file]\npart = 'c'")
    refusal(path, "'c'", "a, b")


@pytest.mark.parametrize(("rows", "word"), [([], "empty"), ([HEADERS], "no rows"), ([("a", "b"), (1, 2)], "pressure")])
def test_a_workbook_without_a_record_is_refused(folder, rows, word):
    refusal(workbook(folder / "r.xlsx", ("1", rows)), word)


# --- Parquet -----------------------------------------------------------------------------------------------------


def test_parquet(folder):
    pytest.importorskip("pyarrow")
    pd.DataFrame(COLUMNS).to_parquet(folder / "r.parquet")
    assert_right(read_record(folder / "r.parquet"))
    pd.DataFrame({**COLUMNS, "force_N": np.where(TIME > 0.35, np.nan, FORCE)}).to_parquet(folder / "r.parquet")
    refusal(folder / "r.parquet", "row 5", "'force_N'", "20 of 24")
    pd.DataFrame(COLUMNS)[:0].to_parquet(folder / "r.parquet")
    refusal(folder / "r.parquet", "no rows")


# --- MATLAB ------------------------------------------------------------------------------------------------------


def savemat(path, **content):
    from scipy.io import savemat

    savemat(path, content)
    return path


def test_vectors_by_name(folder):
    assert_right(read_record(savemat(folder / "r.mat", **COLUMNS, note="rig 3", gain=4.0)))


def test_a_struct_of_vectors(folder):
    assert_right(read_record(savemat(folder / "r.mat", run=COLUMNS)))


def test_an_array_of_structs_is_a_run_each(folder):
    runs = np.array(HALVES, dtype=object)
    assert_right(read_record(savemat(folder / "r.mat", run=runs)))


def test_a_matrix_by_columns_of_a_mapping(put, folder):
    put("", mapping=MAPPING)
    assert_right(read_record(savemat(folder / "r.mat", data=values())))


def test_mat_files_that_are_no_records(folder):
    refusal(savemat(folder / "r.mat", a=3.0), "table2struct")
    refusal(savemat(folder / "r.mat", **{**COLUMNS, "force_N": FORCE[:-1]}), "23", "24")
    refusal(savemat(folder / "r.mat", data=values()), "pressure")


def test_a_mat_file_of_version_7_3(folder):
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "r.mat", "w", userblock_size=512) as file:
        for name, column in COLUMNS.items():
            file.create_dataset(f"run/{name}", data=column[None, :])
    with (folder / "r.mat").open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(512))
    assert_right(read_record(folder / "r.mat"))


# --- TDMS --------------------------------------------------------------------------------------------------------


def tdms(path, groups, waveform=False):
    nptdms = pytest.importorskip("nptdms")
    channels = []
    for group, columns in groups.items():
        for name, unit, data in columns:
            properties = {"unit_string": unit} if unit else {}
            if waveform:
                properties |= {"wf_increment": 0.1, "wf_start_offset": 0.0, "wf_samples": len(data)}
            channels.append(nptdms.ChannelObject(group, name, np.asarray(data), properties))
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(channels)
    return path


def test_channels_with_units_as_properties(folder):
    channels = [(name, unit, column) for name, unit, column in zip(NAMES, UNITS, values().T, strict=True)]
    assert_right(read_record(tdms(folder / "r.tdms", {"run": channels})))


def test_the_time_of_a_waveform(folder):
    channels = [(header, None, COLUMNS[header]) for header in HEADERS[1:]]
    assert_right(read_record(tdms(folder / "r.tdms", {"run": channels}, waveform=True)))


def test_groups_are_runs_and_others_are_passed_over(folder):
    groups = {str(k): [(name, None, column) for name, column in half.items()] for k, half in enumerate(HALVES)}
    assert_right(read_record(tdms(folder / "r.tdms", {**groups, "slow": [("valve", "V", [1.0, 2.0])]})))


def test_channels_of_different_lengths_are_refused(folder):
    channels = [(header, None, column[: 20 if header == "force_N" else ROWS]) for header, column in COLUMNS.items()]
    refusal(tdms(folder / "r.tdms", {"run": channels}), "'force_N'", "20", "24")


@pytest.mark.parametrize("broken", ["first", "last", "both"])
def test_data_that_are_not_whole_chunks_are_refused(folder, broken):
    """A channel of half the bytes a sample, from here on others' samples are read as its own."""
    nptdms = pytest.importorskip("nptdms")
    path = folder / "r.tdms"
    with nptdms.TdmsWriter(path) as writer:
        for half in HALVES:
            writer.write_segment([nptdms.ChannelObject("run", name, half[name]) for name in HEADERS[1:]])
    assert len(read_record(path)) == ROWS
    name = b"'run'/'pressure_MPa'" + (20).to_bytes(4, "little")
    doubles, floats = name + b"\x0a", name + b"\x19"
    head, first, last = path.read_bytes().split(doubles)
    one, other = (floats if broken in (which, "both") else doubles for which in ("first", "last"))
    path.write_bytes(head + one + first + other + last)
    refusal(path, "copy it again")


def test_a_scale_that_is_not_known_is_refused(folder):
    nptdms = pytest.importorskip("nptdms")
    scale = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Logarithmic"}
    channels = [nptdms.ChannelObject("run", name, column, scale) for name, column in COLUMNS.items()]
    with nptdms.TdmsWriter(folder / "r.tdms") as writer:
        writer.write_segment(channels)
    refusal(folder / "r.tdms", "Unsupported scale type")


def test_a_run_is_one_group(folder):
    time, *others = [(name, None, column) for name, column in COLUMNS.items()]
    refusal(tdms(folder / "r.tdms", {"clock": [time], "run": others}), "'run'", "'clock'", "time", "one group")
    assert_right(read_record(tdms(folder / "r.tdms", {"run": [time, *others], "slow": [("valve", None, TIME)]})))


# --- LVM ---------------------------------------------------------------------------------------------------------


def lvm(segments, sep="\t", mark=".", x=True, end="\r\n", delta=0.1, dimension="Time"):
    """Text of a LabVIEW measurement file; a segment is rows of time, pressure, displacement and force."""

    def line(*cells):
        return sep.join(cells) + sep

    name = {"\t": "Tab", ",": "Comma"}[sep]
    lines = [line("LabVIEW Measurement"), line("Writer_Version", "2"), line("Separator", name)]
    lines += [line("Decimal_Separator", mark), line("X_Columns", "One" if x else "No"), line("***End_of_Header***"), ""]
    for rows in segments:
        lines += [line("Channels", "3"), line("Samples", *[str(len(rows))] * 3), line("Y_Unit_Label", *UNITS[1:])]
        lines += [line("X_Dimension", *[dimension] * 3), line("X0", *["0"] * 3), line("Delta_X", *[f"{delta:E}"] * 3)]
        lines += [line("***End_of_Header***"), sep.join(["X_Value", *NAMES[1:], "Comment"])]
        for row in rows:
            cells = [f"{v:.6f}".replace(".", mark) for v in row]
            lines.append(sep.join(cells if x else ["", *cells[1:]]))
        lines.append("")
    return end.join(lines)


@pytest.mark.parametrize(
    "text",
    [
        lvm([values()]),
        lvm([values()], mark=",", end="\n"),
        lvm([values()], sep=","),
        lvm([values()], x=False),
        lvm([values()[:12], values()[12:]]),
        as_text(sep="\t"),
    ],
    ids=["tabs", "decimal comma", "commas", "time counted", "segments", "plain text"],
)
def test_labview_measurement_files(put, text):
    assert_right(read_record(put(text, "r.lvm")))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (lvm([values()]).replace("0.500000", "half"), ["row 21", "'half'"]),
        (lvm([values()]).replace("0.500000\t", ""), ["row 21", "3 cells"]),
        (lvm([values()])[:900].rpartition("\r\n")[0], ["row 15", "says 24"]),
        (lvm([[]]), ["no samples"]),
        (lvm([]), ["End_of_Header"]),
        (lvm([values()]).replace("\tN\t", "\ttorr\t"), ["'torr'"]),
        (lvm([values()], x=False).replace("1.000000E-01", "x"), ["'time [s]'", "row 16"]),
    ],
    ids=["bad cell", "short row", "cut off", "no samples", "no segment", "bad unit", "no step"],
)
def test_labview_measurement_files_that_are_refused(put, text, words):
    refusal(put(text, "r.lvm"), *words)


# --- any of them -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["xlsx", "mat", "tdms", "parquet", "lvm", "csv.gz", "xls"])
@pytest.mark.parametrize(
    "content", [b"", b"no such thing", b"\x89HDF\r\n\x1a\n" + b"\0" * 600, b"PK\x03\x04" + b"\0" * 200]
)
def test_files_that_are_not_what_their_ending_says(put, ending, content):
    refusal(put(content, f"r.{ending}"))


@pytest.mark.parametrize(
    ("ending", "package"), [("xlsx", "openpyxl"), ("tdms", "nptdms"), ("parquet", "pyarrow"), ("mat", "h5py")]
)
def test_a_missing_package_is_named_with_how_to_install_it(put, ending, package, monkeypatch):
    def without(name, *more, **options):
        if name.partition(".")[0] == package:
            raise ImportError(name)
        return real(name, *more, **options)

    real = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", without)
    content = b"MATLAB 7.3 MAT-file" if ending == "mat" else b"x"
    refusal(put(content, f"r.{ending}"), "pip install 'pam-ident[formats]'", error=UsageError)


def test_of_what_a_package_says_of_a_broken_file_a_line_is_told(tmp_path):
    with pytest.raises(DataError) as caught, reading(tmp_path / "r.xlsx", "openpyxl", "Excel workbook", "save it"):
        raise ValueError("these bytes: " + 5000 * "0" + "\nand more")
    message = str(caught.value)
    assert "(these bytes: 0" in message and message.endswith("0); save it") and len(message) < 600


GOOD_FILES = {
    "r.xlsx": lambda path: workbook(path, ("1", [HEADERS, *values().tolist()])),
    "r.mat": lambda path: savemat(path, **COLUMNS),
    "r.tdms": lambda path: tdms(path, {"run": [(name, None, column) for name, column in COLUMNS.items()]}),
    "r.parquet": lambda path: pd.DataFrame(COLUMNS).to_parquet(path, write_page_checksum=True),
    "r.lvm": lambda path: path.write_text(lvm([values()])),
    "r.csv.gz": lambda path: path.write_bytes(gzip.compress(as_text().encode())),
}


@pytest.mark.parametrize("name", GOOD_FILES)
def test_damaged_files_of_these_formats_are_read_or_refused(folder, name):
    GOOD_FILES[name](folder / name)
    data = (folder / name).read_bytes()
    for k in range(25):
        rng = np.random.default_rng([5, k])
        damaged = bytearray(data)
        damaged[rng.integers(len(data))] = rng.integers(256)
        (folder / name).write_bytes(damaged[: rng.integers(len(data))] if k % 5 == 0 else damaged)
        try:
            record = read_record(folder / name)
        except DataError as error:
            assert name in str(error) and len(str(error).splitlines()) <= 2
        else:
            told = sum(note.rows for note in record.notes if note.code == "spike")  # a number that became a far one
            both = [(record.force, FORCE), (record.inputs.pressure, PRESSURE)]
            right = np.all([np.isclose(one[:, None], good, rtol=1e-7) for one, good in both], axis=0).any(axis=1)
            assert (~right).sum() + told <= 1 and len(record) + told == len(FORCE)
