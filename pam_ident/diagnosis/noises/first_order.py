"""White noise, or noise that forgets at one rate (Ornstein & Uhlenbeck), in part of the variance."""

from collections.abc import Sequence

import numpy as np

from . import FIRST_ORDER, Array, NoiseColour

SHARES = np.array([0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0])
MEMORY_SAMPLES = np.array([0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 8.0, 13.0, 20.0, *40.0 * 2.0 ** np.arange(6)])
"""Up to a wander over minutes: noise that is slower than any here passes for a drift."""


def _spectra(half: Array) -> Sequence[Array]:
    cos = np.cos(2.0 * half)
    slow = [(1.0 - r**2) / (1.0 + r**2 - 2.0 * r * cos) for r in np.exp(-1.0 / MEMORY_SAMPLES)]
    return [np.ones(len(half)), *(share * one + 1.0 - share for one in slow for share in SHARES)]


NOISE = NoiseColour(FIRST_ORDER, "Uhlenbeck & Ornstein 1930, Physical Review 36, 823–841", _spectra)
