"""Colours that noise may have besides that of a first-order process, one a file.

A file that defines NOISE takes part: where one of its spectra is likelier than the first-order process that was
estimated, the noise has its likelihood.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ...core.discover import instances

Array = np.ndarray
TAPERS = 3
"""Windows over which a spectrum is averaged: without one a drift leaks into all of it."""


@dataclass(frozen=True)
class NoiseColour:
    """A family of spectra; `spectra` takes half the angular frequencies per sample, (m,) in (0, π/2], and gives some
    power spectra (m,), each with a mean of about 1."""

    name: str
    source: str
    spectra: Callable[[Array], Sequence[Array]]


@cache
def catalogue() -> dict[str, NoiseColour]:
    """Every colour by name."""
    return {one.name: one for one in instances(__name__, __path__, NoiseColour)}


def likelier_colour(z: Array, share: float, decay: float) -> float:
    """By how much the deviance of z (n,) falls if its noise has one of these colours and is not the first-order process
    of a memory `decay` in a `share` of the variance; at least 0.

    All by Whittle's likelihood over the frequencies (Whittle 1953, Arkiv för Matematik 2, 423–434) of a spectrum by
    sine tapers (Riedel & Sidorenko 1995, IEEE Trans. Signal Processing 43, 188–195).
    """
    tapers = np.sin(np.outer(np.arange(1, TAPERS + 1), np.linspace(0.0, np.pi, len(z))))
    power = np.mean(np.abs(np.fft.rfft(z * tapers)[:, 1:]) ** 2, axis=0)
    half = np.pi * np.arange(1, len(power) + 1) / len(z)
    first = share * (1.0 - decay**2) / (1.0 + decay**2 - 2.0 * decay * np.cos(2.0 * half)) + 1.0 - share

    def deviance(spectrum: Array) -> float:
        return 2.0 * len(power) * float(np.log(np.mean(power / spectrum))) + 2.0 * float(np.sum(np.log(spectrum)))

    others = [deviance(spectrum) for colour in catalogue().values() for spectrum in colour.spectra(half)]
    return max(deviance(first) - min(others), 0.0)
