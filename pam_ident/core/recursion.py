"""Recursions: along a whole record without a loop over its samples, and live, from one instant to the next."""

from collections.abc import Callable, Iterable

import numpy as np

Array = np.ndarray
Slot = tuple[Array, ...]
Memory = tuple[Slot, ...]
"""What n muscles side by side remember of an instant: a slot of arrays (n,) for each operator that remembers."""
BLOCK, LEAST = 16, 1e-18
"""Terms of a sum taken at once, and the least decay reckoned with: less is lost in rounding, and its BLOCKth power is
still a number."""


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
    out = np.zeros((len(gain) + 1, *gain.shape[1:]))
    if gain.size == len(gain):
        out[1:] = _one_sum(decay, gain.ravel()).reshape(gain.shape)
    elif gain.size:
        from scipy.linalg.lapack import dtbtrs  # pyright: ignore[reportAttributeAccessIssue]

        band = np.zeros((2, len(gain)), order="F")  # the diagonal, of ones, is not read
        band[1, :-1] = -decay[1:]
        rows, _ = dtbtrs(band, gain.reshape(len(gain), -1), uplo="L", diag="U")
        out[1:] = rows.reshape(gain.shape)
    return out


def _one_sum(decay: Array, gain: Array) -> Array:
    """y[1:] for one gain, by blocks: y over the product of the decays so far is a plain sum; block ends sum alike.

    LAPACK takes half the time, but SciPy a fifth of a second to import, which is more than a diagnosis saves by it.
    """
    n = len(gain)
    if n <= 1:
        return gain
    blocks = -(-n // BLOCK)
    gains, decays = np.zeros(blocks * BLOCK), np.ones(blocks * BLOCK)
    gains[:n] = gain
    np.maximum(decay, LEAST, out=decays[:n])
    kept = np.multiply.accumulate(decays.reshape(blocks, BLOCK), axis=1)
    sums = np.add.accumulate(gains.reshape(blocks, BLOCK) / kept, axis=1) * kept
    if blocks > 1:
        sums[1:] += kept[1:] * _one_sum(kept[:, -1], sums[:, -1])[:-1, None]
    return sums.ravel()[:n]
