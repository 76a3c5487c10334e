"""Lines in the spectrum of what is left: a beat that keeps its period through a whole test."""

import numpy as np

Array = np.ndarray
BINS = 8
"""Bins of time in the shortest period looked for: a beat loses a hundredth of its height in them."""
MOST = 1 << 21
"""Bins at most; of a longer record the fastest beats are not looked for."""
NEAR = 200
"""Frequencies to either side among which a line must stand out."""
MARGIN = 10.0
"""What a line must have beyond the highest that chance gives among all frequencies, in units of their level."""


def beats(time: Array, residual: Array, most: int = 3) -> list[float]:
    """Periods in s of the highest lines, at most `most`, in the spectrum of a residual (n,) at times (n,), s.

    Every frequency from three beats in the record to two samples in a beat, at the middle one of the record's rates, is
    looked at. A line stands out from its neighbours, whatever the noise's colour.
    """
    begin, duration = float(time.min()), float(np.ptp(time))
    gaps = np.diff(time)
    gaps = gaps[gaps > 0.0]
    if len(gaps) < 8:
        return []
    width = max(2.0 * float(np.median(gaps)) / BINS, duration / MOST)
    count = int(duration / width) + 1
    place = np.minimum(((time - begin) / width).astype(int), count - 1)
    binned = np.bincount(place, residual, count)
    padded = 1 << (2 * count - 1).bit_length()
    power = np.abs(np.fft.rfft(binned, padded)[: padded // BINS]) ** 2
    frequency = np.arange(len(power)) / (padded * width)
    power[frequency * duration < 3.0] = 0.0
    blocks = power[: len(power) // NEAR * NEAR].reshape(-1, NEAR)
    if not len(blocks):
        return []
    level = np.repeat(np.median(blocks, axis=1) / np.log(2.0), NEAR)
    level = np.maximum(level, 0.5 * np.r_[level[NEAR:], level[-NEAR:]][: len(level)])
    power = np.where(power[: len(level)] > (np.log(len(level)) + MARGIN) * level, power[: len(level)], 0.0)
    found: list[float] = []
    while len(found) < most and np.any(power):
        k = int(np.argmax(power))
        found.append(float(1.0 / frequency[k]))
        power[max(0, k - 2 * padded // count) : k + 2 * padded // count + 1] = 0.0
    return found
