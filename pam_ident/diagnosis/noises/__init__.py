"""Colours that noise may have, one a file.

A file that defines NOISE takes part: where one of its spectra is likelier than all first-order processes, which the
estimate is made with, the noise has its likelihood.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ...core.discover import instances

Array = np.ndarray
FIRST_ORDER = "first-order process"
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


def likelier_colour(z: Array) -> float:
    """By how much the deviance of z (n,) falls if its noise has the best of these colours, not of the first order.

    All by Whittle's likelihood over the frequencies (Whittle 1953, Arkiv för Matematik 2, 423–434) of a spectrum by
    sine tapers (Riedel & Sidorenko 1995, IEEE Trans. Signal Processing 43, 188–195). It is the best first-order process
    by that likelihood that a colour is held against: the one of the time domain knows gaps, which no spectrum does.
    """
    tapers = np.sin(np.outer(np.arange(1, TAPERS + 1), np.linspace(0.0, np.pi, len(z))))
    power = np.mean(np.abs(np.fft.rfft(z * tapers)[:, 1:]) ** 2, axis=0)
    best = {
        name: float(np.min(2.0 * len(power) * np.log(inverse @ power / len(power)) + volume))
        for name, (inverse, volume) in _spectra(len(z)).items()
    }
    return best[FIRST_ORDER] - min(best.values())


@lru_cache(maxsize=2)
def _spectra(n: int) -> dict[str, tuple[Array, Array]]:
    """Of n samples, by colour, all spectra's inverses (k, n // 2) and twice the sums of their logarithms, (k,)."""
    half = np.pi * np.arange(1, n // 2 + 1) / n
    found = {name: np.array(colour.spectra(half)) for name, colour in catalogue().items()}
    return {name: (1.0 / spectra, 2.0 * np.sum(np.log(spectra), axis=1)) for name, spectra in found.items()}
