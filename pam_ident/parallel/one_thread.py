"""How processes are started: with one thread each, and without the script that asked for them."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

ONE_THREAD = {
    **dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1"),
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
}


@contextmanager
def one_thread() -> Iterator[None]:
    """Processes started inside compute on one thread, for more would only get into each other's way, and do not run the
    main script again, as a new interpreter does to find what it defines.

    All that is asked of workers is found in this package, so that a script needs no `if __name__ == "__main__":`.
    """
    environment, script = dict(os.environ), vars(sys.modules["__main__"])
    names = {name: script.pop(name) for name in ("__spec__", "__file__") if name in script}
    os.environ.update(ONE_THREAD)
    script["__spec__"] = None
    try:
        yield
    finally:
        script.update(names)
        os.environ.clear()
        os.environ.update(environment)
