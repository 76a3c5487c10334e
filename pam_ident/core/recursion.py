"""Recursions: along a whole record without a loop over its samples, and live, from one instant to the next."""

from collections.abc import Callable, Iterable

import numpy as np

Array = np.ndarray
Slot = tuple[Array, ...]
Memory = tuple[Slot, ...]
"""What n muscles side by side remember of an instant: a slot of arrays (n,) for each operator that remembers."""


class Live:
    """A walk along a memory, slot by slot, by those who remember; they must ask in the same order at each instant.

    `memory` is that of the last accepted instant, which stays as it is, or None at the first. `slots` is what it
    has become at the present one.
    """

    def __init__(self, memory: Iterable[Slot] | None) -> None:
        self._before = None if memory is None else iter(memory)
        self.slots: Memory = ()

    def step(self, first: Slot, advance: Callable[..., Slot]) -> Slot:
        """The next slot at the present instant: `first` at the first, later `advance(*slot before)`."""
        slot = first if self._before is None else advance(*next(self._before))
        self.slots += (slot,)
        return slot


def decaying_sum(decay: Array, gain: Array) -> Array:
    """y with y[0] = 0 and y[i+1] = decay[i] y[i] + gain[i]; decay (n,) in 0 … 1, gain (n,) or (n, k) → (n + 1, …)."""
    from scipy.linalg.lapack import dtbtrs, stbtrs  # pyright: ignore[reportAttributeAccessIssue]

    out = np.zeros((len(gain) + 1, *gain.shape[1:]), gain.dtype)
    if gain.size:
        band = np.zeros((2, len(gain)), gain.dtype, order="F")  # the diagonal, of ones, is not read
        band[1, :-1] = -decay[1:]
        solve = stbtrs if gain.dtype == np.float32 else dtbtrs
        rows, _ = solve(band, gain.reshape(len(gain), -1), uplo="L", diag="U")
        out[1:] = rows.reshape(gain.shape)
    return out
