"""Whoever does the tasks, the answers are the same to the bit: this process, a cluster of this machine, another's."""

import math
import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "batch"))
from batch_tree import work_that_kills, work_that_runs_out, write_tree
from dask_cluster import Cluster

from pam_ident.batch.request import Item
from pam_ident.core import PamError, UsageError
from pam_ident.core.progress import Stage, heard
from pam_ident.parallel import executor
from pam_ident.parallel.executor import Executor, WorkerLost
from pam_ident.tasks import fit as fit_record
from pam_ident.tasks.diagnose import diagnose_records
from pam_ident.tasks.fit import FitOptions
from pam_ident.tasks.setup import Setup
from pam_ident.validation.challenge import answer_all, write_challenge

EFFECT = """
from pam_ident.core import Param
from pam_ident.effects import AddsForce, Effect
def _columns(inputs, shape, force):
    return inputs.contraction[:, None] ** 2
SIZE = Param("A", "N", "size", -1e5, 1e5, scale=10.0)
FORM = AddsForce("textbook", "+A x²", (SIZE,), _columns)
EFFECT = Effect(name="bowed", title="Bowed", source="made up", forms=(FORM,), test="none", levers=("pressure",))
"""


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    folder = write_tree(tmp_path_factory.mktemp("tree"), 1)
    return folder / "muscle00" / "run.csv"


@pytest.fixture(scope="module")
def effect(tmp_path_factory):
    path = tmp_path_factory.mktemp("effect") / "bowed.py"
    path.write_text(EFFECT)
    return str(path)


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """A scheduler with one worker, as a user starts them."""
    pytest.importorskip("distributed")
    with Cluster(tmp_path_factory.mktemp("dask"), 1) as cluster:
        yield cluster.address


def intervals(record, effect, how, by):
    """Ends of the intervals, without a word on who is to work, and with one."""
    setup = Setup("exponential_law", ("bowed",), (effect,))
    wishes = FitOptions(held={"mu": 45.0}, intervals=how, seed=3, executor=by)
    (one,) = fit_record.fit_record(setup.read(record), setup, wishes).fits.values()
    return {e.name: (e.low, e.high) for e in one.estimates if e.name != "mu"}


@pytest.mark.long
@pytest.mark.parametrize("how", ["bootstrap", "profile"])
def test_intervals_are_the_same_by_any_executor(record, effect, address, how):
    alone = intervals(record, effect, how, Executor())
    assert all(math.isfinite(end) for ends in alone.values() for end in ends) and "bowed.A" in alone
    assert intervals(record, effect, how, Executor(2)) == alone
    assert intervals(record, effect, how, Executor(scheduler=address)) == alone


@pytest.mark.parametrize("workers", [None, 2])
def test_processes_need_no_dask_and_tell_how_far_they_are(workers, monkeypatch):
    monkeypatch.setattr(executor, "find_spec", lambda name: None)
    told = []
    with heard(told.append):
        found = Executor(workers).all(math.sqrt, [4.0, 9.0, 2.0], "roots")
    assert found == [2.0, 3.0, math.sqrt(2.0)] and told == [Stage("roots", done, 3) for done in (0, 1, 2, 3)]
    with pytest.raises(UsageError, match="needs Dask"):
        Executor(scheduler="tcp://127.0.0.1:1")


def test_what_a_task_raises_is_raised(address):
    for by in (Executor(), Executor(2), Executor(scheduler=address)):
        with pytest.raises(ValueError, match=r"math domain error|nonnegative"):
            by.all(math.sqrt, [4.0, -1.0], "roots")


@pytest.mark.parametrize(
    ("who", "word"),
    [
        ((0,), "workers = 0"),
        ((2, "tcp://127.0.0.1:1"), "give one of the two"),
        ((2,), "--intervals profile or bootstrap"),
    ],
)
def test_an_executor_that_cannot_be_is_refused(who, word):
    with pytest.raises(UsageError, match=word):
        FitOptions(executor=Executor(*who))


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch):
    monkeypatch.setattr("pam_ident.parallel.executor.ANSWER_S", 0.3)
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        Executor(scheduler="tcp://127.0.0.1:9").all(math.sqrt, [4.0], "roots")


def test_a_worker_of_this_machine_has_one_thread_and_keeps_its_memory():
    """To give freed memory back at each array takes a third of a fit's time."""
    asked = ["OMP_NUM_THREADS", "MALLOC_TRIM_THRESHOLD_"]
    assert Executor(2).all(os.getenv, asked, "asking") == ["1", os.getenv("MALLOC_TRIM_THRESHOLD_")]


def killing(tmp_path):
    names = ("a", "bad", "b", "once", "c", "d")
    return [Item(name, str(tmp_path / name), "", "", name) for name in names]


def held(items, executor, work=work_that_kills):
    """That all tasks but the one that kills each of its workers are done."""
    found = {items[k].name: result for k, result in executor.map(work, items, "items")}
    lost = found.pop("bad")
    assert isinstance(lost, WorkerLost) and found == {name: name for name in ("a", "b", "c", "d", "once")}
    return str(lost)


def test_a_process_that_dies_is_replaced_and_only_its_task_given_up(tmp_path):
    assert held(killing(tmp_path), Executor(2)).startswith("its worker was killed 2 times")


@pytest.mark.long
def test_a_process_that_runs_out_of_memory_is_replaced_and_only_its_task_given_up(tmp_path):
    assert held(killing(tmp_path), Executor(2), work_that_runs_out).startswith("its worker was killed 2 times")


@pytest.mark.long
def test_a_worker_of_dask_that_dies_is_replaced_and_only_its_task_given_up(address, tmp_path):
    """What waited beside it at the same worker is asked again, not given up with it."""
    assert held(killing(tmp_path), Executor(scheduler=address)).startswith("its worker was killed 1 times")


def test_a_task_that_was_lost_is_told_where_all_are_needed(tmp_path):
    with pytest.raises(PamError, match=r"items, 2 of 6: its worker was killed 2 times"):
        Executor(1).all(work_that_kills, killing(tmp_path), "items")


STAGES = {"profile": "profiles", "bootstrap": "hundreds of refits", "challenge": "cases"}


@pytest.mark.long
@pytest.mark.parametrize(
    ("verb", "back"), [("profile", True), ("profile", False), ("bootstrap", True), ("challenge", True)]
)
def test_a_scheduler_that_dies_in_mid_run(verb, back, record, effect, tmp_path):
    """Back again, the answer is the same to the bit; else it is one error that says what to do."""
    told = []

    def ask(by):
        if verb != "challenge":
            return intervals(record, effect, verb, by)
        return [{**one, "record": ""} for one in answer_all(tmp_path / "set", by).values()]

    write_challenge(str(tmp_path / "set"), 4, 5, "null")
    with Cluster(tmp_path, 1) as cluster:

        def ear(stage):
            if stage.what != STAGES[verb]:
                return
            told.append(stage.done)
            if stage.done == 1:
                for name in ("scheduler", "worker1"):
                    cluster.kill(name)
                if back:
                    cluster.schedule()
                    cluster.hire(2)

        by = Executor(scheduler=cluster.address, patience_s=60.0 if back else 0.5)
        with heard(ear):
            if back:
                found = ask(by)
            else:
                with pytest.raises(UsageError, match=r"no Dask scheduler answers .* start one"):
                    ask(by)
    if back:
        assert found == ask(Executor())
        assert told == list(range(len(told))) and len(told) > 2
    else:
        assert told == [0, 1]


def test_a_record_whose_worker_is_killed_is_an_error_of_that_record_alone(monkeypatch):
    monkeypatch.setattr(
        Executor, "in_order", lambda self, work, tasks, what: iter([work(tasks[0]), WorkerLost(2), (3, None)])
    )
    first, (path, lost, _), third = diagnose_records(["none.csv", "b.csv", "c.csv"], Setup("exponential_law"))
    assert third == ("c.csv", 3, None) and isinstance(first[1], PamError)
    assert path == "b.csv" and str(lost).startswith("b.csv: its worker was killed 2 times")
