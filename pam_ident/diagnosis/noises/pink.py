"""Noise whose spectrum rises to slow changes as a power of the frequency, 1/f and its like, in part of the variance."""

import math

import numpy as np

from . import Array, NoiseColour

SHARES, POWERS = np.array([0.03, 0.1, 0.2, 0.4, 0.7, 0.95, 1.0]), np.array([-0.2, 0.0, 0.2])


def _mixtures(length: float) -> tuple[Array, Array]:
    """Processes whose memories are evenly spaced on a logarithm, two a decade, and have the same variance, make 1/f."""
    longest = max(length / 4.0, 1.0)
    memory = np.geomspace(0.5, longest, math.ceil(2.0 * math.log10(2.0 * longest)) + 1)
    rise = memory ** POWERS[:, None]
    parts = rise / rise.sum(axis=1)[:, None]
    return memory, (SHARES[:, None, None] * parts).reshape(-1, len(memory))


NOISE = NoiseColour("pink", "Keshner 1982, Proceedings of the IEEE 70(3), 212–218", _mixtures)
