"""The wall takes room from the gas."""

import math

from ..core import Inputs, Param
from .base import AddsForce, Array, Effect, Shape, one

SHARE = Param("wall_share", "1", "share of the wall's thickness that acts", 0.0, 5.0, scale=0.3)


def _thick(inputs: Inputs, shape: Shape, force: Array) -> Array:
    s, xp = inputs.specimen, inputs.xp
    t = s.wall_thickness_mm or 1.0
    cos = (1.0 - inputs.contraction) * math.cos(math.radians(s.braid_angle_deg))
    sin = xp.sqrt(xp.maximum(1.0 - cos**2, 1e-4))
    d90 = 2.0 * s.initial_radius_mm / math.sin(math.radians(s.braid_angle_deg))
    return one(math.pi * inputs.pressure * (d90 * t * (2.0 * sin - 1.0 / sin) - t**2))


EFFECT = Effect(
    name="wall_thickness",
    title="Thickness of the wall",
    source="Chou & Hannaford 1996, IEEE Trans. Robotics and Automation 12(1), 90–102, thick wall",
    forms=(AddsForce("textbook", "π p [D90 t (2 sinθ − 1/sinθ) − t²]", (SHARE,), _thick),),
    test="an independent measurement of the radius",
    levers=("pressure",),
)
