"""What a record says of each parameter: pinned, or in words why not."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np

from ..core import Array, Inputs, Param
from ..model import Model, Values
from ..records import Record
from .covariance import FLAT, Covariance

Kind = Literal["pinned", "held", "at_bound", "dead", "flat", "traded", "loose"]
INFLATION = 10.0
"""Standard error over what it were with all else known, from which a parameter may be called traded."""
TOGETHER = 0.95
"""Correlation of two errors from which one parameter is named as traded against the other."""
ONE = 0.9995
"""Correlation of two errors that is printed as 1.000: with a third parameter at its bound, nothing tells them apart."""
SWEPT = 0.15
"""Range of the pressure beside its largest from which it counts as many levels, however they are grouped."""
WILD = 20.0
"""Half of a 95 % interval, over the value or the parameter's usual size, from which nothing is known of it."""
SAME = 1e-5
"""Part of a sensitivity, by its norm, that may be left over where it is called a combination of others."""


@dataclass(frozen=True)
class Identifiability:
    """What the record says of a parameter. `partners` are the parameters that can take its part, `tie` the correlation
    of its error with that of the first of them."""

    kind: Kind
    text: str
    partners: tuple[str, ...] = ()
    tie: float = 0.0

    @property
    def determined(self) -> bool:
        """Whether the data determine the value, so that its standard error means something."""
        return self.kind in ("pinned", "traded", "loose")


PINNED = Identifiability("pinned", "pinned")
DEAD = Identifiability("dead", "dead: the force does not depend on it anywhere in this record")
HELD = Identifiability("held", "held where it was set")
AT_BOUND = Identifiability("at_bound", "at its bound: the data pull it further")
LOOSE = Identifiability("loose", "not pinned by this record: its interval is wider than the value itself")


def flat_directions(names: Sequence[str], triangle: Array) -> dict[str, Identifiability]:
    """Verdicts of the parameters on which the force does not depend, alone (dead) or in company (flat).

    `triangle` (m, k), with triangleᵀ · triangle = JᵀJ, has a column for each of `names`.
    """
    sizes = np.linalg.norm(triangle, axis=0)
    found = {name: DEAD for name, size in zip(names, sizes, strict=True) if size < 1e-300}
    alive = np.flatnonzero(sizes >= 1e-300).tolist()
    if not alive:
        return found
    live = [str(names[k]) for k in alive]
    _, sigma, vt = np.linalg.svd(triangle[:, alive] / sizes[alive])
    null = vt[np.r_[sigma, np.zeros(len(alive) - len(sigma))] < FLAT * sigma[0]]
    overlap = null.T @ null
    for i in np.flatnonzero(np.diag(overlap) > 1e-3).tolist():
        span = np.abs(overlap[i])
        partners = tuple(live[j] for j in np.argsort(-span).tolist() if j != i and span[j] > 1e-3)
        text = f"flat: moves with {', '.join(partners)} without any change of force"
        found[live[i]] = Identifiability("flat", text, partners)
    return found


def verdicts(params: Sequence[Param], values: Values, cov: Covariance, half: Array) -> list[Identifiability]:
    """Verdict of each parameter that is not flat; `half` (k,) is half the width of its 95 % interval."""
    names = [p.name for p in params]
    matrix = cov.matrix
    spread = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    inflation = np.sqrt(np.sum(cov.basis**2, axis=1)) * cov.sizes
    found = []
    for i, p in enumerate(params):
        reference = max(abs(values[p.name]), p.scale)
        with np.errstate(invalid="ignore", divide="ignore"):
            tie = np.nan_to_num(np.abs(matrix[i]) / (spread[i] * spread))
        tie[i] = 0.0
        partner = int(np.argmax(tie)) if len(tie) > 1 else i
        wide = half[i] > reference or half[i] > 0.5 * (p.upper - p.lower)
        if half[i] > WILD * reference:
            partners = (names[partner],) if tie[partner] > TOGETHER else ()
            text = f"not determined: its 95 % interval reaches {half[i] / reference:.2g} times the value to either side"
            found.append(Identifiability("flat", text, partners))
        # However tied, a parameter known to a tenth of its size is of use as it is.
        elif inflation[i] > INFLATION and tie[partner] > TOGETHER and half[i] > 0.1 * reference:
            text = f"traded against {names[partner]} (errors correlated {tie[partner]:.3f})"
            text += ", and not pinned: its interval is wider than the value itself" if wide else ""
            found.append(Identifiability("traded", text, (names[partner],), float(tie[partner])))
        elif wide:
            found.append(LOOSE)
        else:
            found.append(PINNED)
    return found


@dataclass(frozen=True)
class StandIn:
    """A fault of the measuring chain that changes the force as a change of these parameters does, to first order."""

    calibration: str
    parameters: tuple[str, ...]


def stand_ins(
    model: Model, inputs: Inputs, values: Values, jacobian: Array, names: Sequence[str]
) -> tuple[StandIn, ...]:
    """Scales and zeros of the sensors that the free parameters `names`, of Jacobian (n, k), take up without trace.

    Each with the fewest parameters that do so. A record cannot tell the one from the other; steel bar, dead weight,
    gauge block and reference gauge can. Calibrations: force_scale, force_bias, pressure_scale, pressure_bias,
    displacement_scale, length_offset.
    """
    sizes = np.linalg.norm(jacobian, axis=0)
    alive = np.flatnonzero(sizes > 0).tolist()
    u, sigma, vt = np.linalg.svd(jacobian[:, alive] / sizes[alive], full_matrices=False)
    rank = sigma > 1e-8 * sigma[:1]
    u, r = u[:, rank], sigma[rank, None] * vt[rank]
    found = []
    for name, column in _calibrations(model, inputs, values).items():
        norm = float(np.linalg.norm(column))
        seen = u.T @ column
        if norm == 0.0 or np.linalg.norm(column - u @ seen) > SAME * norm:
            continue
        seen /= norm
        for count in range(1, min(len(alive), 4) + 1):
            fits = [c for c in combinations(range(len(alive)), count) if _left(r[:, c], seen) < SAME]
            if fits:
                found += [StandIn(name, tuple(names[alive[j]] for j in c)) for c in fits]
                break
    return tuple(found)


def _left(columns: Array, target: Array) -> float:
    return float(np.linalg.norm(target - columns @ np.linalg.lstsq(columns, target, rcond=1e-10)[0]))


def slopes(model: Model, inputs: Inputs, values: Values) -> tuple[Array, Array]:
    """∂F/∂p in N/MPa and ∂F/∂ε in N at every sample, shape (n,) each, by central differences."""

    def moved(**change: Array) -> Array:
        return model.force(replace(inputs, **change), values)

    p, e, step = inputs.pressure, inputs.contraction, 1e-5
    by_pressure = (moved(pressure=p + step) - moved(pressure=p - step)) / (2.0 * step)
    return by_pressure, (moved(contraction=e + step) - moved(contraction=e - step)) / (2.0 * step)


def _calibrations(model: Model, inputs: Inputs, values: Values) -> dict[str, Array]:
    """Change of the force in N, shape (n,), with a small fault of each sensor."""
    by_pressure, by_contraction = slopes(model, inputs, values)
    return {
        "force_scale": model.force(inputs, values),
        "force_bias": np.ones(len(inputs)),
        "pressure_scale": inputs.pressure * by_pressure,
        "pressure_bias": by_pressure,
        "displacement_scale": inputs.contraction * by_contraction,
        "length_offset": by_contraction,
    }


def at_its_pressures(model: Model, record: Record, rows: Array) -> Model:
    """The model with those parameters of its law pinned at 0 that `rows` (mask (n,)) at one pressure do not tell from
    others."""
    law, level, measured = model.law, record.level[rows], record.inputs.pressure[rows]
    swept = np.ptp(measured) > SWEPT * np.abs(measured).max()
    if law.min_levels == 1 or swept or np.any(level != level[0]):
        return model
    return replace(model, law=law.at_one(float(level[0]), record.inputs.contraction[rows], record.specimen))
