"""Whether a fitted model could be a passive muscle."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..core import Inputs
from .fit import Fit
from .isobars import loop_energies


def model_loops(fits: Mapping[str, Fit]) -> dict[float, float]:
    """Energy in J of the modelled loop of each isobar at its nominal pressure, positive where it dissipates.

    `fits` are by branch: `together`, or both of `contraction` and `extension`, each of which then gives the force on
    its own branch. Laws without effects are integrated exactly. What lies within twice its standard error, or below
    the noise of the computation, counts as 0. Empty where no two branches are modelled.
    """
    if not ("together" in fits or {"contraction", "extension"} <= set(fits)):
        return {}
    up, down = (fits.get("together", fits.get(branch)) for branch in ("contraction", "extension"))
    assert up is not None and down is not None
    record = up.record
    if up.model.terms or down.model.terms:
        inputs = replace(record.inputs, pressure=record.level)
        force = up.model.force(inputs, up.values)
        if down is not up:
            force = np.where(record.inputs.direction > 0, force, down.model.force(inputs, down.values))
        loops = loop_energies(record, force)
    else:
        loops = {level: _static_loop(up, down, level) for level in loop_energies(record, record.force)}
    return {level: (0.0 if abs(energy) < _doubt(up, down, level) else energy) for level, energy in loops.items()}


def _static_loop(up: Fit, down: Fit, level: float) -> float:
    """Energy in J of the loop of two laws without effects, over the contraction that both branches cover."""
    if up is down:
        return 0.0
    record = up.record
    here, direction, contraction = record.level == level, record.inputs.direction, record.inputs.contraction
    strokes = [contraction[here & (direction == sign)] for sign in (1.0, -1.0)]
    e = np.linspace(max(x.min() for x in strokes), min(x.max() for x in strokes), 401)
    along = Inputs(np.full(len(e), level), e, record.specimen, np.zeros(len(e)))
    gap = down.model.force(along, down.values) - up.model.force(along, up.values)
    step = (e[1] - e[0]) * record.specimen.initial_length_mm
    return float(np.trapezoid(gap, dx=step)) * 1e-3


def passive(loops: Mapping[float, float]) -> bool | None:
    """Whether no loop gives energy back; None where there is no loop."""
    return all(energy >= 0.0 for energy in loops.values()) if loops else None


def energy_warning(loops: Mapping[float, float]) -> str | None:
    """A plain warning that names the pressures at which the model's loop gives energy back."""
    bad = {p: e for p, e in sorted(loops.items()) if e < 0.0}
    if not bad:
        return None
    places = ", ".join(f"{p:g}" for p in bad)
    worst = min(bad, key=lambda p: bad[p])
    return (
        f"the modelled loop gives energy back at {places} MPa (most at {worst:g} MPa, {-bad[worst]:.3g} J a cycle): "
        "the extension force lies below the contraction force, which no passive muscle can do. "
        "Check which branch is which, and do not use this pair of branches in a control loop."
    )


def _doubt(up: Fit, down: Fit, level: float) -> float:
    """Energy in J that noise can feign on one isobar: twice the standard error of the fitted branches' distance.

    At least 0.01 % of the work along the stroke and 0.5 mJ, which binning can feign.
    """
    record = up.record
    here = record.level == level
    stroke = float(np.ptp(record.inputs.displacement_mm[here])) * 1e-3
    errors = [one.rmse * math.sqrt(len(one.model.params) / one.n) for one in (up, down)]
    work = float(np.mean(np.abs(record.force[here]))) * stroke
    return max(5e-4, 1e-4 * work, 2.0 * math.hypot(*errors) * stroke)
