"""Learning from stride to stride: a split ahead of the PID that grows out of the last stride's errors.

Iterative learning control with the inverse of the controller's own model (Bristow, Tharayil & Alleyne 2006, IEEE
Control Systems Magazine 26(3), 96–114). The split is a Fourier series in the phase of the stride, of coefficients c.
The model's loop tells how the knee's angles over a stride follow them, φ ≈ J c; after a stride with the errors e, c
becomes c + SHARE J⁺ e. What comes again with each stride, as far as the series reaches it, shrinks by the factor
1 − SHARE from one to the next where J is right, and shrinks at all where the plant answers less than four times as
strongly. No cause need be known. A motion that never repeats gains nothing.
"""

from typing import NamedTuple

import numpy as np

from .arrays import Array, jnp
from .control import SIGN

HARMONICS = 8
"""Of the stride. Beyond them the knee hardly follows: it would take pressures that valves do not give."""
SHARE = 0.5
"""Of an error that is learned in one stride: less leaves room for a model that is wrong."""
WEAKEST = 0.05
"""Of the singular values of J that are inverted, as a share of the largest."""
PROBE = 0.005
"""Split by which J is found, MPa."""


class Lesson(NamedTuple):
    """At N samples: the series' terms and the gains of an error on its coefficients (MPa/rad), (N, m) each, and whether
    a stride ends there (N,)."""

    terms: Array
    gain: Array
    end: Array


class Learned(NamedTuple):
    """Coefficients of the series in MPa, and what the present stride will add to them, (m,) each."""

    coefficients: Array
    coming: Array


def series(phase: np.ndarray) -> np.ndarray:
    """Terms of the series at phases (N,) in strides, (N, m): one, cosines, sines."""
    turn = 2.0 * np.pi * np.outer(phase, np.arange(HARMONICS + 1))
    return np.hstack([np.cos(turn), np.sin(turn[:, 1:])])


def inverse_of(response: np.ndarray) -> np.ndarray:
    """SHARE J⁺, (m, n), of the angles' response J (n, m), without the directions that hardly show."""
    return SHARE * np.linalg.pinv(response, rcond=WEAKEST)


def nothing() -> Learned:
    """Before the first stride."""
    return Learned(jnp.zeros(2 * HARMONICS + 1), jnp.zeros(2 * HARMONICS + 1))


def advised(lesson: Lesson, learned: Learned) -> Array:
    """Pressures (2,) in MPa that earlier strides add at a sample."""
    return lesson.terms @ learned.coefficients * SIGN


def after(lesson: Lesson, learned: Learned, error: Array) -> Learned:
    """What is known after an error in rad, shape ()."""
    coming = learned.coming + lesson.gain * error
    whole = learned.coefficients + coming
    return Learned(jnp.where(lesson.end, whole, learned.coefficients), jnp.where(lesson.end, 0.0 * coming, coming))
