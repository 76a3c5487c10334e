"""A Dask cluster of processes on loopback, any of which can be killed."""

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "batch"))
from batch_tree import environment


class Cluster:
    """A scheduler and workers of one thread, each in a process group of its own; all are killed in the end."""

    def __init__(self, folder: Path, workers: int) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.folder, self.running = folder, {}
        self.schedule()
        for number in range(1, workers + 1):
            self.hire(number)

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *error: object) -> None:
        for name in list(self.running):
            self.kill(name)

    def run(self, name: str, *words: object) -> None:
        command = [sys.executable, "-m", f"distributed.cli.dask_{name.rstrip('0123456789')}", *map(str, words)]
        path = os.pathsep.join([environment()["PYTHONPATH"], str(Path(__file__).parents[1] / "batch")])
        # a task is given up at the first worker that it kills, so that a test need not wait for four
        own = {"PYTHONPATH": path, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
        with (self.folder / f"{name}.log").open("ab") as log:
            self.running[name] = subprocess.Popen(
                command, env=environment() | own, stdout=log, stderr=log, cwd=self.folder, start_new_session=True
            )

    def schedule(self) -> None:
        self.run("scheduler", "--host", "127.0.0.1", "--port", self.port, "--no-dashboard")

    def hire(self, number: int) -> None:
        self.run(f"worker{number}", self.address, "--nthreads", 1, "--no-dashboard", "--host", "127.0.0.1")

    def kill(self, name: str) -> None:
        process = self.running.pop(name)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
