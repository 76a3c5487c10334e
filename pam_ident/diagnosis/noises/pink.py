"""Noise whose spectrum rises to slow changes as a power of the frequency, 1/f and its like, in part of the variance."""

from collections.abc import Sequence

import numpy as np

from . import Array, NoiseColour

SHARES, POWERS = (0.03, 0.1, 0.2, 0.4, 0.7, 1.0), (0.6, 0.8, 1.0, 1.2)


def _spectra(half: Array) -> Sequence[Array]:
    slow = [rise / np.mean(rise) for rise in (np.sin(half) ** -power for power in POWERS)]
    return [w * rise + 1.0 - w for rise in slow for w in SHARES]


NOISE = NoiseColour("pink", "Keshner 1982, Proceedings of the IEEE 70(3), 212–218", _spectra)
