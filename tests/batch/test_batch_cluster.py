"""On a Dask cluster of processes, whatever of it is killed: nothing lost, nothing twice, the same table."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from batch_tree import answers, environment, finish, frame, start, write_tree

from pam_ident.batch.cluster import work_on_cluster
from pam_ident.batch.question import Item
from pam_ident.batch.work import Done

pytestmark = pytest.mark.long

distributed = pytest.importorskip("distributed")
pytest.importorskip("pyarrow")
COUNT = 40


class Cluster:
    """A scheduler on loopback and workers of one thread, each in a process group of its own."""

    def __init__(self, folder: Path) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.folder, self.running = folder, {}

    def run(self, name: str, *words: object) -> None:
        command = [sys.executable, "-m", f"distributed.cli.dask_{name.rstrip('0123456789')}", *map(str, words)]
        with (self.folder / f"{name}.log").open("ab") as log:
            self.running[name] = subprocess.Popen(
                command, env=environment(), stdout=log, stderr=log, cwd=self.folder, start_new_session=True
            )

    def schedule(self) -> None:
        self.run("scheduler", "--host", "127.0.0.1", "--port", self.port, "--no-dashboard")

    def hire(self, number: int) -> None:
        self.run(f"worker{number}", self.address, "--nthreads", 1, "--no-dashboard", "--host", "127.0.0.1")

    def kill(self, name: str) -> None:
        process = self.running.pop(name)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.fixture
def cluster(tmp_path):
    """A scheduler with two workers; all is killed in the end."""
    found = Cluster(tmp_path)
    found.schedule()
    found.hire(1)
    found.hire(2)
    yield found
    for name in list(found.running):
        found.kill(name)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return write_tree(tmp_path_factory.mktemp("tree"), COUNT)


def wait_for(out: Path, least: int, process: subprocess.Popen) -> dict[str, tuple[int, int]]:
    end = time.monotonic() + 60
    while len(found := answers(out)) < least:
        assert process.poll() is None and time.monotonic() < end, process.communicate()
        time.sleep(0.005)
    return found


def test_a_worker_the_scheduler_and_the_client_are_killed_in_mid_run(tree, cluster, tmp_path):
    out, seen = tmp_path / "results", {}
    client = start(tree, out, "--scheduler", cluster.address)
    seen |= wait_for(out, 4, client)
    cluster.kill("worker1")
    seen |= wait_for(out, 8, client)
    cluster.hire(3)
    cluster.kill("scheduler")
    cluster.kill("worker2")
    cluster.kill("worker3")
    seen |= answers(out)
    assert len(seen) < COUNT
    cluster.schedule()
    cluster.hire(4)
    seen |= wait_for(out, len(seen) + 4, client)
    client.kill()
    client.communicate()
    time.sleep(0.5)  # what workers had in hand they finish
    seen |= answers(out)
    assert len(seen) < COUNT and not (out / "results.parquet").exists()
    code, stdout, stderr = finish(start(tree, out, "--scheduler", cluster.address))
    assert code == 0 and f"{COUNT} records ({len(seen)} from an earlier run), 0 with an error" in stdout, stderr
    assert seen.items() <= answers(out).items() and len(answers(out)) == COUNT
    code, _, stderr = finish(start(tree, tmp_path / "local", "--workers", 2))
    assert code == 0, stderr
    assert (tmp_path / "local" / "results.parquet").read_bytes() == (out / "results.parquet").read_bytes()
    assert len(frame(out)) == COUNT


@pytest.fixture
def address():
    """A cluster of one worker in this process."""
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as found:
        yield found.scheduler_address


def item(k: int) -> Item:
    return Item(f"run{k}.csv", f"/run{k}.csv", "", "", f"key{k}")


def test_a_line_that_breaks_before_a_result_is_fetched_loses_no_record(address, monkeypatch):
    whole, asked, told = distributed.Future.result, [], []

    def result(future):
        asked.append(future.key)
        if len(asked) == 2:
            raise distributed.CancelledError("connection lost")
        return whole(future)

    monkeypatch.setattr(distributed.Future, "result", result)
    items = [item(k) for k in range(5)]
    found = list(work_on_cluster(lambda item: Done(), items, address, told.append))
    assert sorted(item.key for item, _ in found) == [item.key for item in items]
    assert all(done == Done() for _, done in found) and len(asked) == 6
    assert told == [f"the scheduler at {address} is gone; waiting for it"]


def test_what_a_worker_raises_is_no_broken_line(address):
    def work(item):
        raise OSError("no such disk")

    found = list(work_on_cluster(work, [item(0)], address))
    assert found == [(item(0), Done(stop="a worker failed at run0.csv: OSError: no such disk"))]


def test_no_scheduler_is_one_message(tree, tmp_path):
    code, stdout, stderr = finish(start(tree, tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9"))
    assert code == 2 and stdout == "" and len(stderr.strip().splitlines()) == 1
    assert "no Dask scheduler answers" in stderr and "Traceback" not in stderr
