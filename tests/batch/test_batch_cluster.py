"""On a Dask cluster of processes, whatever of it is killed: nothing lost, nothing twice, the same table."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "parallel"))
from batch_tree import answers, finish, frame, start, write_tree
from dask_cluster import Cluster

pytestmark = pytest.mark.long

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")
COUNT = 40


@pytest.fixture
def cluster(tmp_path):
    """A scheduler with two workers."""
    with Cluster(tmp_path, 2) as found:
        yield found


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return write_tree(tmp_path_factory.mktemp("tree"), COUNT)


def wait_for(out: Path, least: int, process: subprocess.Popen) -> dict[str, tuple[int, int]]:
    end = time.monotonic() + 60
    while len(found := answers(out)) < least:
        assert process.poll() is None and time.monotonic() < end, process.communicate()
        time.sleep(0.005)
    return found


@pytest.mark.long
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


def test_no_scheduler_is_one_message(tree, tmp_path):
    code, stdout, stderr = finish(start(tree, tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9"))
    assert code == 2 and stdout == "" and len(stderr.strip().splitlines()) == 1
    assert "no Dask scheduler answers" in stderr and "Traceback" not in stderr
