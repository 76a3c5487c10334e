"""A first-order recursion along a record, without a loop over its samples."""

import numpy as np

Array = np.ndarray


def decaying_sum(decay: Array, gain: Array) -> Array:
    """y with y[0] = 0 and y[i+1] = decay[i] y[i] + gain[i]; decay (n,), gain (n,) or (n, k) → (n + 1, …)."""
    from scipy.linalg.lapack import dtbtrs  # pyright: ignore[reportAttributeAccessIssue]

    out = np.zeros((len(gain) + 1, *gain.shape[1:]))
    if gain.size:
        band = np.vstack([np.ones(len(gain)), np.r_[-decay[1:], 0.0]])
        rows, _ = dtbtrs(band, gain.reshape(len(gain), -1), uplo="L", diag="U")
        out[1:] = rows.reshape(gain.shape)
    return out
