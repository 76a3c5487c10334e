"""pam-ident batch: what it prints, how it ends."""

import shutil

import pytest

pytest.importorskip("pyarrow")


@pytest.fixture
def tree(clean, tmp_path):
    """A good record and one that is none."""
    folder = tmp_path / "tree"
    folder.mkdir()
    for name in ("record.csv", "specimen.toml"):
        shutil.copy(clean.parent / name, folder)
    (folder / "bad.csv").write_text("time_s,pressure_MPa\n0,1\n")
    return folder


@pytest.mark.long
def test_a_bad_record_is_told_and_the_rest_is_done(ask, tree, tmp_path, truth):
    from pam_ident.batch.table import read_results

    out = tmp_path / "results"
    result = ask("batch", tree, "--law", "exponential_law", "--out", out, "--workers", 1)
    assert result.exit_code == 0, result.stderr
    told = "bad.csv, row 1: no force and no displacement column among 'time_s', 'pressure_MPa'; name it"
    assert result.stderr.strip().startswith(told) and len(result.stderr.strip().splitlines()) == 1
    assert result.stdout.splitlines() == [
        "2 records, 1 with an error",
        "verdicts of the fits: 1 adequate",
        f"table: {out / 'results.parquet'}",
        f"page: {out / 'index.html'}",
    ]
    row = read_results(out).set_index("record").loc["record.csv"]
    assert row["mu"] == pytest.approx(truth["mu"], abs=5 * row["mu_stderr"])
    page = (out / "index.html").read_text(encoding="utf-8")
    assert "--law exponential_law --branch together" in page and page.count(">error</td>") == 1


def test_nothing_but_bad_records_is_bad_data(ask, tree, tmp_path):
    (tree / "record.csv").unlink()
    result = ask("batch", tree, "--law", "exponential_law", "--out", tmp_path / "results", "--workers", 1)
    assert result.exit_code == 4 and "1 record, 1 with an error" in result.stdout


def test_wrong_calls_are_refused_before_any_work(ask, tree, tmp_path):
    for words, message in (
        (("--law", "no_such_law"), "no_such_law"),
        (("--law", "sarosi", "--workers", 1, "--scheduler", "tcp://127.0.0.1:1"), "cluster has its own workers"),
        (("--law", "sarosi", "--branch", "up"), "--branch 'up'"),
    ):
        result = ask("batch", tree, *words, "--out", tmp_path / "results")
        assert result.exit_code == 2 and message in result.stderr and len(result.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "results").exists()
