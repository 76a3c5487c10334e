"""A first-order recursion along a record, without a loop over its samples."""

import numpy as np

Array = np.ndarray


def decaying_sum(decay: Array, gain: Array) -> Array:
    """y with y[0] = 0 and y[i+1] = exp(−decay[i]) y[i] + gain[i]; decay (n,) ≥ 0, gain (n,) or (n, k) → (n + 1, …).

    Summed in stretches short enough that the decay inside one stays within the range of a float.
    """
    out = np.zeros((len(gain) + 1, *gain.shape[1:]))
    total = np.r_[0.0, np.cumsum(np.minimum(decay, 250.0))]
    start = 0
    while start < len(decay):
        stop = max(start + 1, int(np.searchsorted(total, total[start] + 300.0, side="right")) - 1)
        since = (total[start + 1 : stop + 1] - total[start]).reshape(-1, *[1] * (gain.ndim - 1))
        out[start + 1 : stop + 1] = np.exp(-since) * (out[start] + np.cumsum(gain[start:stop] * np.exp(since), axis=0))
        start = stop
    return out
