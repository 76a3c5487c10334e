"""Whether a form of an effect can be stepped through time, for muscles side by side, traced by JAX."""

from dataclasses import fields, replace

import numpy as np

from ..core import Inputs, Specimen
from ..core.recursion import Live
from ..effects import Form
from .arrays import Array, jax

FUNCTIONS = "take functions from the arrays, xp = x.__array_namespace__(), not from numpy"
MEMORY = "rows are muscles here, not samples: each must depend on its own row alone"


def loop_fault(form: Form, specimen: Specimen) -> str:
    """What keeps the form from being stepped, with what to do; empty where nothing does.

    It is asked at two instants: traced by JAX, then with NumPy for muscles side by side and for each alone.
    """
    shape = {p.name: p.start for p in form.nonlinear}
    instants = [_instant(specimen, 0.0), _instant(specimen, 1.0)]

    def traced(shape: dict[str, float], states: list[dict[str, Array]]) -> Array:
        return _asked(form, shape, [replace(instants[0], **state) for state in states])

    try:
        found = jax.eval_shape(traced, shape, [_arrays(one) for one in instants])
        if found.shape != (3, len(form.linear)):
            return f"it gives the shape {found.shape} for 3 muscles; {MEMORY}"
        together = _asked(form, shape, instants)
        alone = [_asked(form, shape, [one.take(slice(k, k + 1)) for one in instants]) for k in range(3)]
    except jax.errors.JAXTypeError:
        return FUNCTIONS
    except Exception as error:  # a user's code may raise anything
        return f"{type(error).__name__}: {error}"
    return "" if np.allclose(together, np.concatenate(alone), rtol=1e-9, atol=1e-12) else MEMORY


def _asked(form: Form, shape: dict[str, float], instants: list[Inputs]) -> Array:
    """Columns (n, k) at the last of some instants."""
    memory, columns = None, np.zeros(0)
    for inputs in instants:
        live = Live(memory)
        columns = form.columns(replace(inputs, live=live), shape, 500.0 - 1000.0 * inputs.contraction)
        memory = live.slots
    return columns


def _arrays(inputs: Inputs) -> dict[str, Array]:
    return {f.name: value for f in fields(inputs) if isinstance(value := getattr(inputs, f.name), np.ndarray)}


def _instant(specimen: Specimen, later: float) -> Inputs:
    """Three muscles that agree in nothing, not even in their clocks."""
    one = np.array([1.0, 2.0, 4.0])
    return Inputs(
        pressure=0.1 * one + 0.01 * later,
        contraction=0.05 * one + 0.01 * later,
        specimen=specimen,
        direction=np.array([0.9, -1.0, 1.0]),
        time=0.3 * one + 0.2 * later,
        velocity=np.array([3.0, -12.0, 40.0]),
        stroke_speed=np.array([3.0, 12.0, 40.0]),
        moving=np.ones(3, bool),
        cycle=one + later,
        temperature=20.0 + one + later * one,
        segment=np.zeros(3, int),
    )
