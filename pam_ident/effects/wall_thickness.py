"""The wall takes room from the gas."""

import math

from ..core import Inputs, Param, Range
from .base import AddsForce, Array, Effect, Values, bladder_area, one

WHOLE = Range(0.0, 2.0, "the wall as it was measured, or twice that (Chou & Hannaford 1996)")
SHARE = Param("wall_share", "1", "share of the wall's thickness that acts", 0.0, 5.0, scale=0.3, range=WHOLE)
ENDS = Param("end_share", "1", "the same for the wall's section at the ends", 0.0, 5.0, scale=1.0, range=WHOLE)


def _thick(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(_wall(inputs, inputs.specimen.wall_thickness_mm or 1.0))


def _thinning(inputs: Inputs, values: Values, force: Array) -> Array:
    """Rubber keeps its volume: the wall thins as the muscle grows, and thickens as it shortens."""
    return one(_wall(inputs, (inputs.specimen.wall_thickness_mm or 1.0) / bladder_area(inputs)))


def _parts(inputs: Inputs, values: Values, force: Array) -> Array:
    """The two terms of the textbook's sum by themselves."""
    t = inputs.specimen.wall_thickness_mm or 1.0
    ends = -math.pi * inputs.pressure * t**2
    return inputs.xp.stack([_wall(inputs, t) - ends, ends]).T


def _wall(inputs: Inputs, t: Array | float) -> Array:
    s, xp = inputs.specimen, inputs.xp
    cos = (1.0 - inputs.contraction) * math.cos(math.radians(s.braid_angle_deg))
    sin = xp.sqrt(xp.maximum(1.0 - cos**2, 1e-4))
    d90 = 2.0 * s.initial_radius_mm / math.sin(math.radians(s.braid_angle_deg))
    return math.pi * inputs.pressure * (d90 * t * (2.0 * sin - 1.0 / sin) - t**2)


EFFECT = Effect(
    name="wall_thickness",
    title="thickness of the wall",
    source="Chou & Hannaford 1996, IEEE Trans. Robotics and Automation 12(1), 90–102, thick wall",
    forms=(
        AddsForce("textbook", "π p [D90 t (2 sinθ − 1/sinθ) − t²]", (SHARE,), _thick),
        AddsForce("thinning", "the same with t = t0 L0 r0/(L r)", (SHARE,), _thinning),
        AddsForce("parts", "π p [w D90 t (2 sinθ − 1/sinθ) − w_e t²]", (SHARE, ENDS), _parts),
    ),
    follows=("map",),
    test="an independent measurement of the radius",
    levers=("pressure",),
)
