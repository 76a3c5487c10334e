"""A record that is read in chunks is the record that is read whole."""

from dataclasses import fields

import numpy as np
import pytest

from pam_ident.core import DataError
from pam_ident.records import read_record, text_table, turning
from pam_ident.records.columns_on_disk import Columns
from pam_ident.records.long import noise_on_disk, open_long
from pam_ident.records.roughness import position_noise
from pam_ident.rig import Plan, Protocol, make_record, write_case

PLAN = Plan(7, protocol=Protocol((0.2, 0.4), (5.0, 20.0), 2, move_rows=60, hold_rows=20))


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    """A rig record's text, its folder with a specimen beside it."""
    folder = tmp_path_factory.mktemp("long")
    write_case(folder, make_record(PLAN))
    return folder, (folder / "record.csv").read_text()


def without(text, name):
    """The same table without a column."""
    rows = [line.split(",") for line in text.splitlines()]
    gone = rows[0].index(name)
    return "\n".join(",".join(cell for k, cell in enumerate(row) if k != gone) for row in rows) + "\n"


def german(text):
    return text.replace(",", ";").replace(".", ",")


def joined(path, rows):
    """The chunks of a record put together again: a record's arrays by name."""
    found: dict[str, list] = {}
    with open_long(path) as long:
        for record, turn in long.chunks(rows):
            inputs = {f.name: getattr(record.inputs, f.name) for f in fields(record.inputs)}
            arrays = inputs | {"force": record.force, "level": record.level, "stroke": record.stroke, "turn": turn}
            for name, column in arrays.items():
                if isinstance(column, np.ndarray):
                    found.setdefault(name, []).append(column[1:])
        assert long.sample(50).force.tolist() == np.concatenate(found["force"])[:: (long.n - 1) // 50 | 1].tolist()
        assert len(long) == sum(map(len, found["force"]))
        return {name: np.concatenate(parts) for name, parts in found.items()}, long.levels


def assert_same(path, rows):
    chunks, levels = joined(path, rows)
    whole = read_record(path)
    arrays = {f.name: getattr(whole.inputs, f.name) for f in fields(whole.inputs)}
    arrays |= {"force": whole.force, "level": whole.level, "stroke": whole.stroke, "turn": whole.turn}
    if whole.inputs.time is None:
        del arrays["turn"], arrays["stroke"], chunks["turn"], chunks["stroke"]
    assert {k for k, v in arrays.items() if isinstance(v, np.ndarray)} == set(chunks)
    for name, column in chunks.items():
        np.testing.assert_array_equal(column, arrays[name], err_msg=name)
    np.testing.assert_array_equal(levels, whole.levels)


@pytest.mark.parametrize("gone", [(), ("pressure_set_MPa",), ("cycle", "pressure_set_MPa"), ("time_s", "cycle")])
@pytest.mark.parametrize("piece", [150, 1 << 20])
def test_its_chunks_are_the_rows_of_the_whole_record(text, monkeypatch, gone, piece):
    folder, content = text
    for name in gone:
        content = without(content, name)
    (folder / "other.csv").write_text(content)
    monkeypatch.setattr(text_table, "BLOCK_BYTES", 700)
    monkeypatch.setattr(turning, "PIECE", piece)
    assert_same(folder / "other.csv", 97)


@pytest.mark.parametrize(("encoding", "write"), [("utf-16", str), ("utf-8", german), ("utf-16", german)])
def test_the_text_may_be_written_in_any_way(text, monkeypatch, encoding, write):
    folder, content = text
    (folder / "other.csv").write_bytes(write(content).encode(encoding))
    monkeypatch.setattr(text_table, "BLOCK_BYTES", 1000)
    assert_same(folder / "other.csv", 1000)


def test_runs_in_several_files_are_joined_alike(text, tmp_path):
    folder, content = text
    head, *rows = content.splitlines()
    (tmp_path / "specimen.toml").write_text((folder / "specimen.toml").read_text())
    for k in range(2):
        (tmp_path / f"r{k}.csv").write_text("\n".join([head, *rows[: 300 + 100 * k]]) + "\n")
    assert_same(f"{tmp_path}/r*.csv", 128)


@pytest.mark.parametrize(
    ("row", "cell", "words"), [(900, "x", "row 900, column 'force_N'"), (800, "-.", "row 800, column 'force_N'")]
)
def test_a_bad_cell_of_a_later_block_is_named_by_its_row(text, monkeypatch, row, cell, words):
    folder, content = text
    lines = content.splitlines()
    cells = lines[row - 1].split(",")
    cells[lines[0].split(",").index("force_N")] = cell
    lines[row - 1] = ",".join(cells)
    (folder / "other.csv").write_text("\n".join(lines))
    monkeypatch.setattr(text_table, "BLOCK_BYTES", 500)
    with pytest.raises(DataError, match=words), open_long(folder / "other.csv"):
        pass


def test_time_that_runs_backwards_from_one_block_to_the_next_is_named(text, monkeypatch):
    folder, content = text
    lines = content.splitlines()
    monkeypatch.setattr(text_table, "BLOCK_BYTES", len(lines[1]) + 1)  # about a row a block
    lines[500], lines[501] = lines[501], lines[500]
    (folder / "other.csv").write_text("\n".join(lines))
    with pytest.raises(DataError, match=r"row 502.*time runs backwards"), open_long(folder / "other.csv"):
        pass


@pytest.mark.parametrize("n", [3, 4, 5, 1000, 1001])
def test_a_quantile_on_disk_is_numpys(tmp_path, n):
    rng = np.random.default_rng(n)
    values = np.cumsum(rng.choice([0.0, 0.1, 0.1, rng.random()], n))
    on_disk = Columns(tmp_path)
    on_disk.append("x", values)
    for order, share in ((1, 0.95), (2, 0.5)):
        steps = np.abs(np.diff(values, order))
        expected = np.quantile(steps, share) if len(steps) else 0.0
        assert on_disk.quantile("x", 0, n, order, share) == pytest.approx(expected, rel=1e-15, abs=0.0)


@pytest.mark.parametrize("clock", ["jitters", "stands still", "is even"])
def test_the_noise_of_the_position_is_that_of_the_record_in_memory(clock, tmp_path, monkeypatch):
    """By the clock that was logged: evenly spaced rows would take its jitter for noise of 0.1 mm."""
    monkeypatch.setattr("pam_ident.records.long.STRETCH", 97)
    random = np.random.default_rng(4)
    rows = np.arange(2000.0)
    time = {"jitters": 0.02 * (rows + random.uniform(-0.35, 0.35, 2000)), "stands still": 0.0 * rows, "is even": rows}
    x = 20.0 * np.abs((0.1 * time["jitters"] + 1.0) % 2.0 - 1.0) + random.normal(0.0, 0.01, 2000)
    on_disk = Columns(tmp_path)
    on_disk.append("time", time[clock])
    on_disk.append("contraction", x / 250.0)
    found = noise_on_disk(on_disk, 2000, 250.0)
    assert found == pytest.approx(position_noise(x / 250.0 * 250.0, time[clock]), rel=1e-14)
    assert not on_disk.has("roughness")
    if clock == "jitters":
        assert found == pytest.approx(0.01, rel=0.1)


def test_a_jittering_clock_gives_the_motion_of_the_record_in_memory(text, tmp_path):
    """Jitter that were taken for noise of the position would widen what counts as a hold or a reversal."""
    folder, content = text
    head, *lines = content.splitlines()
    names, cells = head.split(","), [line.split(",") for line in lines]
    when, where = names.index("time_s"), names.index("displacement_mm")
    time, x = (np.array([float(row[k]) for row in cells]) for k in (when, where))
    step = np.minimum(np.diff(time, prepend=-1.0), np.diff(time, append=1e9))
    moved = time + step * np.random.default_rng(3).uniform(-0.4, 0.4, len(time))
    for row, t, position in zip(cells, moved, np.interp(moved, time, x), strict=True):
        row[when], row[where] = f"{t:.6f}", f"{position:.6f}"
    (tmp_path / "specimen.toml").write_text((folder / "specimen.toml").read_text())
    (tmp_path / "record.csv").write_text("\n".join([head, *(",".join(row) for row in cells)]) + "\n")
    assert_same(tmp_path / "record.csv", 97)
