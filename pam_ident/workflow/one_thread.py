"""Processes that compute on one thread each."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

ONE_THREAD = {
    **dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1"),
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
}


@contextmanager
def one_thread() -> Iterator[None]:
    """Processes started inside compute on one thread: more would only get into each other's way."""
    before = dict(os.environ)
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
