"""A batch is resumed where it was killed, does nothing twice, and its table hangs on nothing but its answers."""

import contextlib
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import curve_fit

from pam_ident.batch import run
from pam_ident.batch import table as batch_table
from pam_ident.batch.record import Store, answer
from pam_ident.batch.request import BatchRequest, plan
from pam_ident.batch.run import run_batch
from pam_ident.core import UsageError
from pam_ident.parallel.executor import Executor
from pam_ident.tasks.setup import Setup

sys.path.insert(0, str(Path(__file__).parent))
from batch_tree import TRUTH, a1_of, answers, environment, finish, frame, start, write_tree

pytest.importorskip("pyarrow")
SETUP = Setup("exponential_law")
COUNT = 12


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """Twelve good records, one that is none, and one without a specimen."""
    folder = write_tree(tmp_path_factory.mktemp("tree"), COUNT)
    (folder / "muscle03" / "notes.csv").write_text("time_s,remark\n0,all well\n")
    (folder / "alone.csv").write_text("time_s,pressure_MPa,displacement_mm,force_N\n0,0.1,0,10\n")
    return folder


@pytest.fixture(scope="module")
def undisturbed(tree, tmp_path_factory):
    """Results of a run in one go with one worker."""
    out = tmp_path_factory.mktemp("undisturbed") / "results"
    found = run_batch(tree, SETUP, out, branch="separate", executor=Executor(1))
    assert (found.records, found.kept, len(found.errors)) == (COUNT + 2, 0, 2)
    return out


def same(out, other):
    return (out / "results.parquet").read_bytes() == (other / "results.parquet").read_bytes()


def test_the_table_has_a_row_a_record_and_branch_with_the_true_parameters(undisturbed):
    table = frame(undisturbed)
    assert list(table.columns[:7]) == ["record", "branch", "law", "effects", "verdict", "rmse_N", "noise_floor_N"]
    rows = list(zip(table["record"], table["branch"], strict=True))
    assert rows == sorted(rows) and len(rows) == 2 * (COUNT + 2)
    good = table[table["error"].isna()]
    assert len(good) == 2 * COUNT
    for name in ("a0", "a1", "b0", "b1", "c0", "c1", "mu"):
        true = a1_of(good["specimen_initial_length_mm"].to_numpy()) if name == "a1" else TRUTH[name]
        off = np.abs(good[name] - true) / good[f"{name}_stderr"]
        assert 0.2 < off.median() < 1.6  # of a Student variable: about 0.7
    assert good["rmse_N"].between(0.85, 1.15).all() and good["noise_floor_N"].between(0.8, 1.2).all()
    assert table.attrs["units"]["a1"] == "N/MPa" and table.attrs["question"]["law"] == "exponential_law"
    text = pd.read_csv(undisturbed / "results.csv")
    assert list(text) == list(table) and text["a1"].to_numpy() == pytest.approx(table["a1"].to_numpy(), nan_ok=True)


@pytest.mark.long
def test_values_and_errors_are_those_of_scipy_on_the_same_rows(tmp_path):
    tree = write_tree(tmp_path / "tree", 2)
    run_batch(tree, SETUP, tmp_path / "out", executor=Executor())
    for _, row in frame(tmp_path / "out").iterrows():
        data = pd.read_csv(tree / row["record"])
        p, e = data["pressure_MPa"], data["displacement_mm"] / row["specimen_initial_length_mm"]

        def law(_, a0, a1, b0, b1, c0, c1, mu, p=p, e=e):
            return a0 + a1 * p - (b0 + b1 * p) * e + (c0 + c1 * p) * np.exp(-mu * e)

        force = data["force_N"].to_numpy()
        best, _ = curve_fit(law, p, force, list(TRUTH.values()), xtol=1e-14, ftol=1e-14)
        assert row[list(TRUTH)].to_numpy(float) == pytest.approx(best, rel=1e-5)
        assert row["rmse_N"] == pytest.approx(np.sqrt(np.mean((law(p, *best) - force) ** 2)), rel=1e-8)
        assert row["n"] == len(data)


def test_bad_files_are_told_by_their_place_in_the_tree_and_passed_over(undisturbed):
    bad = frame(undisturbed).dropna(subset="error").drop_duplicates("record").set_index("record")["error"]
    assert bad["alone.csv"].startswith("alone.csv: no specimen.toml")
    assert bad["muscle03/notes.csv"].startswith("muscle03/notes.csv: a header but no rows of numbers")


@pytest.mark.long
def test_two_workers_give_the_bytes_of_one(tree, undisturbed, tmp_path):
    run_batch(tree, SETUP, tmp_path / "two", branch="separate", executor=Executor(2))
    assert same(tmp_path / "two", undisturbed)


@pytest.mark.long
def test_killed_in_mid_run_it_goes_on_and_does_nothing_twice(tree, undisturbed, tmp_path):
    out = tmp_path / "killed"
    for least in (2, 6):  # killed twice, each time with more behind it
        process = start(tree, out, "--branch", "separate", "--workers", 2)
        while len(answers(out)) < least:
            assert process.poll() is None, process.communicate()
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.communicate()
    time.sleep(0.5)  # workers that lost their master finish the record in hand
    before = answers(out)
    assert 6 <= len(before) < COUNT + 1 and not (out / "results.parquet").exists()
    code, stdout, stderr = finish(start(tree, out, "--branch", "separate", "--workers", 1))
    assert code == 0 and f"({len(before)} from an earlier run)" in stdout, stderr
    assert before.items() <= answers(out).items() and len(answers(out)) == COUNT + 1
    assert same(out, undisturbed)


@pytest.mark.long
def test_twenty_kills_at_random_moments_lose_nothing_and_leave_nothing(tree, undisturbed, tmp_path):
    out, rng, kept = tmp_path / "killed", random.Random(11), {}
    for _ in range(20):
        process = start(tree, out, "--branch", "separate", "--workers", 2, start_new_session=True)
        time.sleep(rng.uniform(0.3, 3.0))
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        assert kept.items() <= answers(out).items(), "what was answered stays, to the byte"
        kept = answers(out)
    code, _, stderr = finish(start(tree, out, "--branch", "separate", "--workers", 2))
    assert code == 0, stderr
    assert kept.items() <= answers(out).items() and same(out, undisturbed)


@pytest.mark.long
def test_two_batches_on_one_output_give_the_table_of_one(tree, undisturbed, tmp_path):
    out = tmp_path / "both"
    both = [start(tree, out, "--branch", "separate", "--workers", 2) for _ in range(2)]
    ends = [finish(process) for process in both]
    assert [code for code, *_ in ends] == [0, 0], ends
    assert len(answers(out)) == COUNT + 1 and same(out, undisturbed)
    assert not list(out.rglob(".*"))


@pytest.mark.long
def test_an_answer_that_was_cut_short_is_found_anew(tree, undisturbed, tmp_path):
    out = tmp_path / "results"
    run_batch(tree, SETUP, out, branch="separate", executor=Executor(2))
    victim = sorted(out.glob("records/*/*.json"))[4]
    victim.write_bytes(victim.read_bytes()[:100])
    (victim.parent / f".{victim.name}.left").write_text("half")
    found = run_batch(tree, SETUP, out, branch="separate", executor=Executor(1))
    assert found.kept == COUNT and same(out, undisturbed)
    assert not list(out.glob("records/*/.*"))


@pytest.mark.long
def test_only_what_changed_is_asked_again(tmp_path):
    folder, out = write_tree(tmp_path / "tree", 4), tmp_path / "results"
    run_batch(folder, SETUP, out, executor=Executor())
    path = folder / "muscle01" / "specimen.toml"
    path.write_text(path.read_text().replace("25.4", "25.5"))
    assert run_batch(folder, SETUP, out, executor=Executor()).kept == 3
    path = folder / "muscle02" / "run.csv"
    path.write_text("\n".join(path.read_text().splitlines()[:-1]) + "\n")
    assert run_batch(folder, SETUP, out, executor=Executor()).kept == 3
    run_batch(folder, SETUP, tmp_path / "anew", executor=Executor())
    assert same(out, tmp_path / "anew")
    assert run_batch(folder, Setup("exponential_law", ("coulomb_friction",)), out, executor=Executor()).kept == 0


def test_a_worker_that_fails_ends_the_batch_with_what_is_finished(tree, tmp_path, monkeypatch):
    def failing(question, item):
        if item.name.startswith("muscle02"):
            raise RuntimeError("no such disk")
        return answer(question, item)

    monkeypatch.setattr(run, "answer", failing)
    with pytest.raises(UsageError, match=r"a worker failed: RuntimeError: no such disk\. The 2 records"):
        run_batch(tree, SETUP, tmp_path / "out", executor=Executor())
    assert len(answers(tmp_path / "out")) == 2


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:os.fork:RuntimeWarning")  # JAX is loaded; the child only sets a signal
def test_ctrl_c_ends_the_command_and_its_workers(tree, tmp_path):
    out = tmp_path / "results"

    def heard():  # what a shell starts in the background does not hear it
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    words = ("--branch", "separate", "--workers", 2)
    process = start(tree, out, *words, start_new_session=True, preexec_fn=heard)
    while not answers(out):
        assert process.poll() is None, process.communicate()
        time.sleep(0.002)
    os.killpg(process.pid, signal.SIGINT)
    code, _, stderr = finish(process)
    assert code == 130 and "Traceback" not in stderr
    end = time.monotonic() + 10.0
    with pytest.raises(ProcessLookupError):
        while time.monotonic() < end:  # Python's own tracker of resources ends after what it tracks
            os.killpg(process.pid, 0)
            time.sleep(0.01)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:os.fork:RuntimeWarning")  # other tests have loaded JAX; the child only limits files
def test_a_full_disk_is_told_and_takes_nothing_away(tree, undisturbed, tmp_path):
    out = tmp_path / "results"
    limit = 12_000  # an answer is smaller, the table is larger
    assert (undisturbed / "results.parquet").stat().st_size > limit

    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    code, _, stderr = finish(start(tree, out, "--branch", "separate", "--workers", 2, preexec_fn=small_files))
    assert code == 2 and "File too large" in stderr and "same command again" in stderr
    assert "Traceback" not in stderr and len(stderr.strip().splitlines()) == 1
    before = answers(out)
    assert len(before) == COUNT + 1
    found = run_batch(tree, SETUP, out, branch="separate", executor=Executor(1))
    assert found.kept == COUNT + 1 and answers(out) == before and same(out, undisturbed)


@pytest.mark.long
def test_a_disk_that_fills_up_in_mid_run(tree, undisturbed, tmp_path):
    small = tmp_path / "small"
    small.mkdir()
    options = ["-t", "tmpfs", "-o", "size=32k", "tmpfs", str(small)]
    if os.geteuid() or subprocess.run(["mount", *options], capture_output=True).returncode:
        pytest.skip("a small disk can be mounted by root only")
    try:
        out = small / "results"
        code, _, stderr = finish(start(tree, out, "--branch", "separate", "--workers", 2))
        assert code == 2 and "No space left" in stderr and len(stderr.strip().splitlines()) == 1
        before = answers(out)
        assert 0 < len(before) < COUNT + 1
        subprocess.run(["mount", "-o", "remount,size=4m", str(small)], check=True)
        code, stdout, stderr = finish(start(tree, out, "--branch", "separate", "--workers", 2))
        assert code == 0 and f"({len(before)} from an earlier run)" in stdout, stderr
        assert before.items() <= answers(out).items() and same(out, undisturbed)
    finally:
        subprocess.run(["umount", "-l", str(small)], check=True)


def test_a_folder_that_cannot_be_written_to_is_refused_before_any_work(tree, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(UsageError, match=r"cannot be written to .* name another folder by --out"):
        run_batch(tree, SETUP, blocked / "results")


def test_what_cannot_be_asked_is_refused(tree, tmp_path, monkeypatch):
    with pytest.raises(UsageError, match="no such folder"):
        run_batch(tmp_path / "none", SETUP, tmp_path / "out")
    with pytest.raises(UsageError, match="no CSV file"):
        run_batch(tmp_path, SETUP, tmp_path / "out")
    with pytest.raises(UsageError, match="workers = 0"):
        run_batch(tree, SETUP, tmp_path / "out", executor=Executor(0))
    with pytest.raises(UsageError, match="--branch 'up'"):
        run_batch(tree, SETUP, tmp_path / "out", branch="up")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(UsageError, match=r"pip install 'pam-ident\[cluster\]'"):
        run_batch(tree, SETUP, tmp_path / "out")


def test_specimens_lie_beside_or_above_and_results_inside_the_tree_are_no_records(tmp_path):
    tree = write_tree(tmp_path / "tree", 1)
    deep = tree / "muscle00" / "day2" / "a"
    deep.mkdir(parents=True)
    (tree / "muscle00" / "run.csv").rename(deep / "run.csv")
    (tree / ".hidden.csv").write_text("no record")
    out = tree / "results"
    out.mkdir()
    (out / "export.csv").write_text("no record")
    (item,) = plan(tree, BatchRequest(SETUP), out).items
    assert item.name == "muscle00/day2/a/run.csv"
    assert item.specimen == str((tree / "muscle00" / "specimen.toml").resolve())


@pytest.mark.long
def test_a_diagnosis_says_what_each_record_lacks(root, tmp_path):
    for name in ("hidden_effect", "nothing_hidden"):
        shutil.copytree(root / "datasets" / name, tmp_path / "tree" / name)
    found = run_batch(tmp_path / "tree", SETUP, tmp_path / "out", diagnose=True)
    assert not found.errors
    table = frame(tmp_path / "out").set_index("record")
    assert dict(table["verdict"]) == {
        "hidden_effect/record.csv": "missing_effect",
        "nothing_hidden/record.csv": "adequate",
    }
    assert [list(names) for names in table["selected"]] == [["pressure_friction"], []]
    assert pd.read_csv(tmp_path / "out" / "results.csv")["selected"][0] == "pressure_friction"
    page = found.page.read_text(encoding="utf-8")
    assert (
        "lacks friction that grows with pressure" in page
        and ">missing effect</td>" in page
        and ">error</td>" not in page
    )


@pytest.mark.long
def test_effects_of_ones_own_are_loaded_by_the_workers(root, tmp_path):
    own = tmp_path / "own.py"
    source = (root / "pam_ident" / "effects" / "force_drift.py").read_text(encoding="utf-8")
    source = source.replace("from ..core", "from pam_ident.core").replace("from .", "from pam_ident.effects.")
    own.write_text(source.replace('"force_drift"', '"my_drift"'), encoding="utf-8")
    setup = Setup("exponential_law", ("my_drift",), (str(own),))
    found = run_batch(write_tree(tmp_path / "tree", 1), setup, tmp_path / "out", executor=Executor(1))
    (row,) = frame(found.folder).to_dict("records")
    assert not found.errors and list(row["effects"]) == ["my_drift"]
    (name,) = (column for column in row if column.startswith("my_drift.") and not column.endswith("_stderr"))
    assert abs(row[name]) < 4.0 * row[f"{name}_stderr"]  # there is none


def test_results_of_older_versions_are_read_and_of_later_ones_refused(root, tmp_path):
    old = frame(root / "tests" / "batch" / "batch-0.1.0")
    assert len(old) == 2 and old.attrs["question"]["version"] == "0.1.0"
    assert old["a1"][0] == pytest.approx(2400.0, abs=5 * old["a1_stderr"][0])
    store = Store(tmp_path)
    store.put("ab12", {"schema": "pam-ident/batch-record/2", "rows": []})
    with pytest.raises(UsageError, match="Update pam-ident"):
        store.get("ab12")
    with pytest.raises(UsageError, match="not a table of a batch"):
        batch_table.read_results(root / "README.md")


SCRIPT = """
import sys
from pam_ident.batch.run import run_batch
from pam_ident.parallel.executor import Executor
from pam_ident.tasks.setup import Setup

print("begun")
found = run_batch(sys.argv[1], Setup("exponential_law"), sys.argv[2], executor={executor})
print(found.records, found.errors)
"""


@pytest.mark.long
@pytest.mark.parametrize("executor", ["None", "Executor(2)"])
def test_a_script_needs_no_guard_around_the_call(executor, tmp_path):
    """A worker that ran the script again would begin a batch of its own, which multiprocessing refuses."""
    tree = write_tree(tmp_path / "tree", 3)
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(executor=executor))
    words = [sys.executable, script, tree, tmp_path / "out"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300, env=environment())
    assert (done.returncode, done.stdout) == (0, "begun\n3 {}\n"), done.stderr
    assert "Traceback" not in done.stderr


def test_what_looks_gravely_wrong_is_told_though_it_was_fitted(tmp_path, capsys):
    from pam_ident.cli.batch import _print

    tree = write_tree(tmp_path / "tree", 2)
    path = next(path for path in sorted(tree.rglob("*.csv")) if "muscle00" in str(path))
    rows = pd.read_csv(path)
    rows.assign(pressure_MPa=0.1 * rows["pressure_MPa"]).to_csv(path, index=False)
    found = run_batch(tree, SETUP, tmp_path / "out", executor=Executor(1))
    assert not found.errors and len(found.grave) == 1
    record, doubt = next(iter(found.grave.items()))
    assert "muscle00" in record and doubt.startswith("scale: ")
    _print(found)
    assert f"{record}: fitted all the same, but scale: " in " ".join(capsys.readouterr().err.split())
