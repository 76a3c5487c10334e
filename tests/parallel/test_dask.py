"""A line to the scheduler that breaks at a bad instant, and a task's own error, which is none of the line's."""

import logging

import pytest

from pam_ident.parallel.executor import Executor

distributed = pytest.importorskip("distributed")


@pytest.fixture
def address():
    """A cluster of one worker in this process."""
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as found:
        yield found.scheduler_address


def test_a_line_that_breaks_before_a_result_is_fetched_loses_no_task(address, monkeypatch, caplog):
    whole, asked = distributed.Future.result, []

    def result(future):
        asked.append(future.key)
        if len(asked) == 2:
            raise distributed.CancelledError("connection lost")
        return whole(future)

    monkeypatch.setattr(distributed.Future, "result", result)
    with caplog.at_level(logging.WARNING, "pam_ident"):
        found = list(Executor(scheduler=address).map(str, range(5), "numbers"))
    assert sorted(found) == [(k, str(k)) for k in range(5)] and len(asked) == 6
    told = [one.getMessage() for one in caplog.records if one.name.startswith("pam_ident")]
    assert told == [f"the scheduler at {address} is gone; waiting for it"]


def test_a_worker_that_dies_with_a_result_before_it_is_fetched_loses_no_task(address, monkeypatch):
    whole, asked = distributed.Future.result, []

    def result(future):
        asked.append(future.key)
        if len(asked) == 2:
            raise distributed.KilledWorker(future.key, None, 0)
        return whole(future)

    monkeypatch.setattr(distributed.Future, "result", result)
    found = list(Executor(scheduler=address).map(str, range(5), "numbers"))
    assert sorted(found) == [(k, str(k)) for k in range(5)] and len(asked) == 6


def test_what_a_worker_raises_is_no_broken_line(address):
    def work(task):
        raise OSError("no such disk")

    with pytest.raises(OSError, match="no such disk"):
        list(Executor(scheduler=address).map(work, [0], "disks"))
