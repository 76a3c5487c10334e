"""One thread for linear algebra, whatever the caller's environment says: the same bits and the same speed for all."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """BLAS computes on one thread inside, also as a decorator. Matrices of a few columns gain nothing from a second,
    and the order of their sums would hang on how many there are."""
    with _controller().limit(limits=1, user_api="blas"):
        yield


@cache
def _controller() -> "ThreadpoolController":
    """Of the libraries that NumPy and SciPy have loaded; finding them takes 10 ms, asking them 0.03 ms."""
    import scipy.linalg  # noqa: F401 - it has a BLAS of its own
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
