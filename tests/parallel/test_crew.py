"""Whoever does the tasks, the answers are the same to the bit: this process, a cluster of this machine, another's."""

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "batch"))
from batch_tree import environment, write_tree

from pam_ident.core import UsageError
from pam_ident.core.progress import Stage, heard
from pam_ident.parallel import crew
from pam_ident.tasks import fit as fit_record
from pam_ident.tasks.fit import Wishes
from pam_ident.tasks.intervals import Crew
from pam_ident.tasks.setup import Setup

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
    folder = write_tree(tmp_path_factory.mktemp("crew"), 1)
    return folder / "muscle00" / "run.csv"


@pytest.fixture(scope="module")
def effect(tmp_path_factory):
    path = tmp_path_factory.mktemp("effect") / "bowed.py"
    path.write_text(EFFECT)
    return str(path)


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """A scheduler with one worker, as a user starts them."""
    distributed = pytest.importorskip("distributed")
    folder, running = tmp_path_factory.mktemp("dask"), []
    options = {"env": environment(), "cwd": folder, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    file = folder / "scheduler.json"
    for words in (("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"), ("worker", "--nthreads", "1")):
        command = [sys.executable, "-m", f"distributed.cli.dask_{words[0]}", "--scheduler-file", str(file), *words[1:]]
        running.append(subprocess.Popen(command, **options))
    try:
        with distributed.Client(scheduler_file=str(file), timeout=60, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
            yield client.scheduler.address
    finally:
        for process in running:
            process.terminate()
            process.wait()


def intervals(record, effect, how, by):
    """Ends of the intervals, without a word on who is to work, and with one."""
    setup = Setup("exponential_law", ("bowed",), (effect,))
    wishes = Wishes(held={"mu": 45.0}, intervals=how, seed=3, crew=by)
    (one,) = fit_record.fit_record(setup.read(record), setup, wishes).fits.values()
    return {e.name: (e.low, e.high) for e in one.estimates if e.name != "mu"}


@pytest.mark.long
@pytest.mark.parametrize("how", ["bootstrap", "profile"])
def test_intervals_are_the_same_by_any_crew(record, effect, address, how):
    alone = intervals(record, effect, how, Crew())
    assert all(math.isfinite(end) for ends in alone.values() for end in ends) and "bowed.A" in alone
    assert intervals(record, effect, how, Crew(workers=2)) == alone
    assert intervals(record, effect, how, Crew(scheduler=address)) == alone


def test_without_dask_processes_do_the_same(monkeypatch):
    monkeypatch.setattr(crew, "find_spec", lambda name: None)
    told = []
    with heard(told.append):
        found = crew.do_all(math.sqrt, [4.0, 9.0, 2.0], "roots", 2)
    assert found == [2.0, 3.0, math.sqrt(2.0)] and told == [Stage("roots", done, 3) for done in (1, 2, 3)]
    with pytest.raises(UsageError, match="needs Dask"):
        crew.do_all(math.sqrt, [4.0], "roots", scheduler="tcp://127.0.0.1:1")


@pytest.mark.long
def test_what_a_task_raises_is_raised(address):
    with pytest.raises(ValueError, match=r"math domain error|nonnegative"):
        crew.do_all(math.sqrt, [4.0, -1.0], "roots", scheduler=address)


@pytest.mark.parametrize(
    ("who", "word"),
    [
        (Crew(workers=0), "workers = 0"),
        (Crew(2, "tcp://127.0.0.1:1"), "give one of the two"),
        (Crew(workers=2), "--intervals profile or bootstrap"),
    ],
)
def test_a_crew_that_cannot_be_is_refused(who, word):
    with pytest.raises(UsageError, match=word):
        Wishes(crew=who)


@pytest.mark.long
def test_a_scheduler_that_does_not_answer_is_told(monkeypatch):
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        crew.do_all(math.sqrt, [4.0], "roots", scheduler="tcp://127.0.0.1:9")


@pytest.mark.long
def test_a_worker_of_this_machine_has_one_thread_and_keeps_its_memory():
    """Dask gives freed memory back at each array unless told otherwise, which costs a third of a fit's time."""
    pytest.importorskip("distributed")
    asked = ["OMP_NUM_THREADS", "MALLOC_TRIM_THRESHOLD_"]
    assert crew.do_all(os.environ.get, asked, "asking", workers=2) == ["1", os.environ.get("MALLOC_TRIM_THRESHOLD_")]
