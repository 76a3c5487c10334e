"""A muscle without its nonlinearity and hysteresis: force linear in pressure, contraction and speed."""

from types import MappingProxyType

import numpy as np

from ..core import Param
from ..effects import get_effect
from ..laws import Law
from ..model import Model, Term
from .arrays import jnp
from .muscle import Muscle

Array = np.ndarray
SPEED_MM_S = 100.0
"""Speed at which the damping is taken, that of a knee's walking."""


def _columns(p: Array, e: Array, specimen: object, shape: object) -> Array:
    return p.__array_namespace__().stack([0.0 * e + 1.0, p, e]).T


LAW = Law(
    name="linear_muscle",
    title="Linear muscle",
    formula="F = F0 + F1 p + F2 ε",
    source="least squares over the working range of another model",
    linear=(
        Param("F0", "N", "force"),
        Param("F1", "N/MPa", "force per pressure"),
        Param("F2", "N", "force per stroke"),
    ),
    columns=_columns,
)


def linearised(muscle: Muscle, pressures_MPa: tuple[float, float], contractions: tuple[float, float]) -> Muscle:
    """The plane nearest to the pull of `muscle`, where it pulls, over a grid of gauge pressures and contractions, at
    rest and moving both ways: dry friction becomes the damping that takes as much at SPEED_MM_S."""
    axes = (np.linspace(*pressures_MPa, 21), np.linspace(*contractions, 21), SPEED_MM_S * np.array([-1.0, 0.0, 1.0]))
    p, e, v = (jnp.asarray(a.ravel()) for a in np.meshgrid(*axes))
    pull, _ = muscle.force(muscle.values(), muscle.start(p, e), 0.0, p, e, v)
    columns = np.column_stack([np.asarray(_columns(p, e, None, None)), -1e-3 * np.asarray(v)])
    taut = np.asarray(pull) > 0.0
    sizes, *_ = np.linalg.lstsq(columns[taut], np.asarray(pull)[taut], rcond=None)
    model = Model(LAW, (Term(*get_effect("viscous_damping")),))
    values = MappingProxyType(dict(zip(model.names, sizes.tolist(), strict=True)))
    return Muscle(model, muscle.specimen, values, values)
