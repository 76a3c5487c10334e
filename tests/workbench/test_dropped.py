"""Files from a browser: none is larger inside than is stated, and no message tells where they lay."""

import gzip
import io
import zipfile

import pytest

from pam_ident.core import DataError, PamError
from pam_ident.workbench import draft as dropped
from pam_ident.workbench.draft import Draft

HEADER = b"time_s,pressure_bara,displacement_mm,force_N\n"


@pytest.fixture
def specimen(folder):
    return (folder / "specimen.toml").read_bytes()


def workbook(size):
    with (
        zipfile.ZipFile(out := io.BytesIO(), "w", zipfile.ZIP_DEFLATED) as book,
        book.open("xl/worksheets/sheet1.xml", "w") as sheet,
    ):
        sheet.write(b" " * size)
    return out.getvalue()


@pytest.mark.parametrize("name", ["r.csv.gz", "r.xlsx", "r.parquet"])
def test_small_files_that_are_large_inside_are_refused(name, specimen, monkeypatch):
    monkeypatch.setattr(dropped, "MOST_UNPACKED", 1 << 20)
    if name == "r.parquet":
        import pandas as pd

        pd.DataFrame({"force_N": [0.0] * (1 << 18)}).to_parquet(out := io.BytesIO())
        content = out.getvalue()
    else:
        lines = gzip.compress(HEADER + b"0,3,1,500\n" * (1 << 17))
        content = lines * 2 if name == "r.csv.gz" else workbook(2 << 20)  # members one after the other are one text
    assert len(content) < 1 << 16
    with pytest.raises(DataError, match=rf"^{name}: unpacks to more than 1 MiB"):
        dropped.read_dropped({name: content, "specimen.toml": specimen}, None)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("r.csv", HEADER + b"0,3,1,x\n"),
        ("r.csv", b""),
        ("r.xlsx", b"no workbook"),
        ("r.mat", b"no matrix"),
        ("r.xls", b"old"),
        ("r.csv.gz", b"no gzip"),
        ("columns.toml", b"[columns]\nforce_N = 9"),
    ],
)
def test_no_message_tells_where_they_lay(name, content, specimen, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    files = {"run.csv": HEADER + b"0,3,1,500\n0.1,3,2,400\n", "specimen.toml": specimen, name: content}
    with pytest.raises(PamError) as caught:
        dropped.read_dropped(files if name == "columns.toml" else {**files, "run.csv": content}, None)
    assert str(tmp_path) not in str(caught.value) and list(tmp_path.iterdir()) == []


def test_what_was_assumed_is_told_without_it(specimen):
    rows = b"".join(b"%d,3,%d,500\n" % (k, k) for k in range(20))
    record, _ = dropped.read_dropped({"r.csv": HEADER + rows + b"21,,5,500\n", "specimen.toml": specimen}, None)
    assert [note.code for note in record.notes] == ["absolute_pressure", "empty_cells"]
    assert "(first r.csv, row 22)" in record.notes[1].text


def test_the_range_that_is_shown_of_a_column_is_that_of_the_whole_file():
    rows = b"".join(b"%d,3,%d,500\n" % (k, k // 100) for k in range(9000))
    (time, _, stroke, _) = Draft.of({"r.csv": HEADER + rows}).columns
    assert time.high == pytest.approx(9000, rel=0.01) and stroke.high >= 88 and (time.low, stroke.low) == (0, 0)
