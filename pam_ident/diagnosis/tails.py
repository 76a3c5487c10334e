"""Heavy tails: noise in which far samples are less rare than in normal noise."""

import math

import numpy as np

Array = np.ndarray
NORMAL = 200.0
"""Degrees of freedom from which Student's t is as good as normal."""


def deviance_saved(before: Array, after: Array) -> float:
    """By how much minus twice the log likelihood falls from one model to another, of innovations (n,) that each leaves.

    Noise has Student's t distribution, with the scale and the degrees of freedom that are likeliest of `after`. In
    normal noise of unit variance that is the fall of the squares; with heavy tails a far sample counts for much less,
    and so does what brings it near.
    """
    from scipy.optimize import minimize  # slow to import, and seldom needed

    def kernel(z: Array, at: Array) -> float:
        freedom, scale = 1.0 + np.exp(at[0]), np.exp(at[1])
        return (freedom + 1.0) * float(np.sum(np.log1p((z / scale) ** 2 / freedom)))

    def deviance(at: Array) -> float:
        freedom = 1.0 + np.exp(at[0])
        whole = math.lgamma(freedom / 2.0) - math.lgamma((freedom + 1.0) / 2.0) + 0.5 * np.log(freedom) + at[1]
        return kernel(after, at) + 2.0 * len(after) * float(whole)

    bounds = [(0.0, np.log(NORMAL)), (None, None)]
    size = np.log(max(float(np.sqrt(np.mean(after**2))), 1e-9))
    found = minimize(deviance, (np.log(5.0), size), method="L-BFGS-B", bounds=bounds)
    return kernel(before, found.x) - kernel(after, found.x)
