"""Workbooks, MATLAB, TDMS, LVM and Parquet files, and several files that are one record."""

import builtins
from datetime import datetime, timedelta

import numpy as np
import pandas as pd
import pytest
from corpus import DISPLACEMENT, FORCE, HEADERS, PRESSURE, ROWS, TIME, as_text, assert_right, values

from pam_ident.core import DataError, UsageError
from pam_ident.records import file_sha256, read_record
from pam_ident.records.columns import read_columns
from pam_ident.records.mapping import read_mapping
from pam_ident.records.text_table import read_text

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
    refusal(workbook(path, ("run 1", [HEADERS, *rows])), "row 6", "'force_N'", "empty")


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
    refusal(folder / "r.parquet", "row 5", "'force_N'", "19 more")
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
        (lvm([[]]), ["no samples"]),
        (lvm([]), ["End_of_Header"]),
        (lvm([values()]).replace("\tN\t", "\ttorr\t"), ["'torr'"]),
        (lvm([values()], x=False).replace("1.000000E-01", "x"), ["'time [s]'", "row 16"]),
    ],
    ids=["bad cell", "short row", "no samples", "no segment", "bad unit", "no step"],
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


# --- several files -----------------------------------------------------------------------------------------------


def test_a_file_for_each_isobar_by_pattern_or_folder(put, tmp_path):
    for k, name in enumerate(("run10.csv", "run2.csv")):
        rows = values()[12:] if k == 0 else values()[:12]
        put(as_text(rows=rows * [1, 1, 1, 1] - [rows[0, 0], 0, 0, 0]), f"runs/{name}")
    (tmp_path / "runs" / "specimen.toml").write_text((tmp_path / "specimen.toml").read_text())
    pattern = f"{tmp_path}/runs/*.csv"
    for given in (pattern, tmp_path / "runs"):
        record = read_record(given)
        np.testing.assert_allclose(record.force, FORCE)
        np.testing.assert_allclose(record.inputs.pressure, PRESSURE)
        np.testing.assert_allclose(record.inputs.displacement_mm, DISPLACEMENT, atol=1e-9)
        assert np.all(np.diff(record.inputs.time) > 0.0) and record.inputs.time[12] - record.inputs.time[11] >= 60.0
        assert record.name == "m1" and record.source == str(given)
    one = read_record(tmp_path / "runs" / "run2.csv")
    assert one.sha256 == file_sha256(tmp_path / "runs" / "run2.csv") != record.sha256


def test_two_runs_at_one_pressure_stay_apart(put, tmp_path):
    for k in range(2):
        put(as_text(rows=values()[:12]), f"r{k}.csv")
    record = read_record(f"{tmp_path}/r*.csv")
    assert len(record) == 24 and list(np.unique(record.inputs.segment)) == [0, 1]


def test_files_may_differ_in_units_and_format(put, folder):
    put(as_text(rows=values()[:12]), "a1.csv")
    savemat(folder / "a2.mat", **{**HALVES[1], "note": 1})
    record = read_record(folder)
    assert_right(record)
    assert record.columns["force"] == "force_N"


def test_files_that_are_not_one_test_are_refused(put, tmp_path):
    put(as_text(), "a1.csv")
    put(as_text((*HEADERS, "temperature_C"), np.column_stack([values(), TIME])), "a2.csv")
    refusal(tmp_path, "temperature")
    put("time_s,pressure_MPa\n", "a2.csv")
    refusal(tmp_path / "a2.csv", "no rows")
    refusal(tmp_path, "a2.csv", "no rows")
    put("rows of text\n", "a2.csv")
    refusal(tmp_path, "a2.csv")


def test_a_pattern_or_folder_without_files_is_refused(folder):
    refusal(folder, "folder without a record", ".csv")
    refusal(folder / "*.csv", "no file fits")


# --- real files --------------------------------------------------------------------------------------------------

SPECIMENS = {"psu": (274.0, 10.0, 25.4), "mit": (300.0, 5.0, 23.0), "map": (300.0, 10.0, 25.4)}


@pytest.fixture
def mapped(root):
    """Reads a real file by one of the mappings beside this file."""
    from pam_ident.core import Specimen

    def read(path, mapping, specimen):
        file = root / "tests" / "records" / "mappings" / f"{mapping}.toml"
        assert len(file.read_text().splitlines()) <= 5
        return read_record(path, Specimen(specimen, *SPECIMENS[specimen]), file)

    return read


def test_raw_logger_files_without_a_header(realdata, mapped, root):
    files = sorted((realdata / "psu_festo20mm_isometric" / "raw").glob("*.csv.gz"))
    assert len(files) == 3
    for file in files[:1]:
        record = mapped(file, "psu_logger", "psu")
        assert len(record) == 29000 and np.all(record.inputs.contraction == 0.0)
    mapping = read_mapping(root / "tests" / "records" / "mappings" / "psu_logger.toml")
    for file in files:
        raw = np.genfromtxt(file, delimiter=",")
        (table,) = read_text(file, mapping)
        (run,) = read_columns(table, mapping.sources(table), 274.0)
        np.testing.assert_allclose(run["force"], raw[:, 0], rtol=1e-12)
        np.testing.assert_allclose(run["pressure"], raw[:, 1] * 1e-3, rtol=1e-12)
        np.testing.assert_array_equal(run["time"], raw[:, 2])


def test_plateaus_and_sines_of_a_hand_made_muscle(realdata, mapped):
    home = realdata / "mit2151_mckibben300mm"
    raw = np.genfromtxt(home / "plateaus.csv", delimiter=",", names=True)
    record = mapped(home / "plateaus.csv", "mit_plateaus", "mit")
    np.testing.assert_allclose(record.force, raw["F_N"])
    np.testing.assert_allclose(record.inputs.pressure, raw["p_kPa_span12bar"] * 1e-3)
    np.testing.assert_allclose(record.inputs.displacement_mm, raw["contraction_mm"], atol=1e-12)
    for file in sorted((home / "freq_noload_amp50pct").glob("*.csv")):
        raw = np.genfromtxt(file, delimiter=",", names=True)
        record = mapped(file, "mit_sine", "mit")
        np.testing.assert_allclose(record.inputs.displacement_mm, 137.3906 - raw["x_mm"], atol=1e-9)
        np.testing.assert_allclose(record.inputs.time, raw["t_s"])


def test_the_published_map_by_its_own_names(root, mapped, put):
    source = (root / "datasets" / "dmsp20_300" / "record.csv").read_text().splitlines()
    rows = [line.split(",") for line in source[1:]]
    kept = [source[0].split(",").index(name) for name in ("length_mm", "pressure_kPa", "force_N", "slack")]
    path = put(as_text(("L_mm", "p_kPa", "F_N", "slack_zero"), [[row[k] for k in kept] for row in rows]), "map.csv")
    record = mapped(path, "martens_boblan", "map")
    assert (len(record), record.masked, record.force.max()) == (60, 66, 1653.5)
