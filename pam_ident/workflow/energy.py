"""Whether a fitted model could be a passive muscle."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..fitting import Fit, loop_energies
from ..records import Record


def model_loops(fits: Mapping[str, Fit]) -> dict[float, float]:
    """Energy in J of the modelled loop of each isobar at its nominal pressure, positive where it dissipates.

    `fits` are by branch: `together`, or both of `contraction` and `extension`, each of which then gives the force on
    its own branch. What is below the noise of the computation counts as 0. Empty where no two branches are modelled.
    """
    record = next(iter(fits.values())).record
    inputs = replace(record.inputs, pressure=record.level)
    if "together" in fits:
        force = fits["together"].model.force(inputs, fits["together"].values)
    elif {"contraction", "extension"} <= set(fits):
        up, down = fits["contraction"], fits["extension"]
        force = np.where(
            record.inputs.direction > 0, up.model.force(inputs, up.values), down.model.force(inputs, down.values)
        )
    else:
        return {}
    noise = _noise(record)
    return {p: (0.0 if abs(e) < noise[p] else e) for p, e in loop_energies(record, force).items()}


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


def _noise(record: Record) -> dict[float, float]:
    """Energy in J per isobar that binning alone can feign: 0.01 % of the work along the stroke, at least 0.5 mJ."""
    found = {}
    for level in record.levels:
        here = record.level == level
        work = np.mean(np.abs(record.force[here])) * np.ptp(record.inputs.displacement_mm[here]) * 1e-3
        found[float(level)] = max(5e-4, 1e-4 * float(work))
    return found
