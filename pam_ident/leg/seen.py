"""Whether the leg asks of its muscles what their fit has seen."""

import math

import numpy as np

from ..records.doubt import Doubt
from .course import Course
from .muscle import Muscle
from .pair import Pair

WORDS = {
    "pressure_MPa": "{:.3g} to {:.3g} MPa gauge",
    "contraction": "contraction {:.3f} to {:.3f}",
    "speed_mm_s": "{:.0f} to {:.0f} mm/s",
}
MARGIN = 0.02
"""Of a range, by which it may be left: sensors are not finer."""


def outside(pair: Pair, model: Muscle, course: Course, pressure_MPa: np.ndarray) -> list[Doubt]:
    """Where a gait, followed at gauge pressures (N, 2) over the samples judged, leaves what the record behind `model`
    covered: at which flexion, in which part of the stride. Nothing where that is not known."""
    time = course.time[course.judged]
    phase, knee = 100.0 * (time * course.gait.cadence_Hz % 1.0), course.gait.at(time).knee
    posture = pair.leg.knee.at(knee.angle)
    strokes = pair.leg.contraction(posture.sprocket, 1e-3 * pair.muscle.specimen.initial_length_mm)
    speed = 1e3 * pair.leg.sprocket_radius_m * np.abs(posture.ratio * knee.rate)
    asked = {"pressure_MPa": pressure_MPa.T, "contraction": strokes, "speed_mm_s": (speed, speed)}
    found = []
    for quantity, both in asked.items():
        low, high = model.seen.get(quantity, (-math.inf, math.inf))
        least = -math.inf if quantity == "speed_mm_s" else low - MARGIN * (high - low)
        for name, values in zip(("flexor", "extensor"), both, strict=True):
            beyond = (values < least) | (values > high + MARGIN * (high - low))
            if beyond.any():
                there, part = np.degrees(knee.angle)[beyond], phase[beyond]
                found.append(
                    Doubt(
                        "outside_range",
                        f"{name} at {WORDS[quantity].format(values.min(), values.max())}, where the fit has seen "
                        f"{WORDS[quantity].format(low, high)}: {100.0 * beyond.mean():.0f} % of the time judged, "
                        f"knee at {there.min():.0f}° to {there.max():.0f}°, within {part.min():.0f} to "
                        f"{part.max():.0f} % of the stride; there the model is extrapolated",
                        quantity,
                    )
                )
    return found
