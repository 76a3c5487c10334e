"""The Python function, run without pam-ident."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import BY_NAME, CASES, EACH_CASE, LENGTH, assert_agrees, columns, instant

from pam_ident.core import UsageError
from pam_ident.export.fitted import Fitted, Parameter
from pam_ident.export.program import ARGUMENTS, program
from pam_ident.export.targets.python import python_function
from pam_ident.fitting import fit
from pam_ident.leg.arrays import jax, jnp
from pam_ident.model import Model
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record


def function_of(case):
    """What the exported file defines; it can import NumPy alone."""
    text = python_function(case.fitted, "muscle")
    assert [line for line in text.splitlines() if "import" in line and "#" not in line] == ["import numpy as np"]
    defined: dict = {}
    exec(compile(text, "muscle.py", "exec"), defined)
    return defined["muscle"]


@pytest.mark.long
@EACH_CASE
def test_the_python_file_agrees_with_the_model_at_ten_thousand_samples(case, numpy_forces, inputs):
    muscle, made = function_of(case), program(case.fitted)
    places = [list(ARGUMENTS).index(name) for name in made.arguments]
    if made.later is None:
        found = muscle(*columns(inputs)[:, places].T)
    else:
        state, forces = None, []
        for k in range(LENGTH):
            force, state = muscle(*columns(instant(inputs, k))[:, places].T, state)
            forces.append(force)
        found = np.array(forces).T.ravel()
    assert_agrees(found, numpy_forces[case.name])


def test_along_a_record_with_holds_the_export_is_the_fit():
    """What friction keeps in a hold and how it fades, and the creep that goes on there."""
    record = read_record(dataset_record("hidden_effect"))
    one = fit(Model("exponential_law", ["coulomb_friction:relaxing", "creep"]), record, detail=False)
    values = tuple(Parameter(p.name, one.values[p.name], math.nan, p.unit, p.doc) for p in one.model.params)
    fitted = Fitted(one.model, record.specimen, {"together": values}, "", {})
    defined: dict = {}
    exec(python_function(fitted, "muscle"), defined)
    isobar = record.inputs.take(record.inputs.segment == 0)
    places = [list(ARGUMENTS).index(name) for name in program(fitted).arguments]
    state, forces = None, []
    for row in columns(isobar)[:, places]:
        force, state = defined["muscle"](*row, state)
        forces.append(force)
    assert np.count_nonzero(~isobar.moving) > 100
    np.testing.assert_allclose(forces, one.force[record.inputs.segment == 0], rtol=0.0, atol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("name", ["rich", "creep_force_driven"])
def test_a_force_that_depends_on_itself_agrees_with_the_step_that_jax_runs(name, inputs):
    """JAX does all rounds of the iteration, as the exported file does."""
    case = BY_NAME[name]
    muscle, made, model = function_of(case), program(case.fitted), case.model
    places = [list(ARGUMENTS).index(word) for word in made.arguments]
    values = case.branches["together"]
    arrays = {k: v for k, v in vars(inputs).items() if isinstance(v, np.ndarray) and k != "displacement_mm"}

    @jax.jit
    def step(given, memory):
        return model.step(replace(inputs, **given), values, memory)

    state, memory = None, None
    for k in range(400):
        now = instant(inputs, k)
        expected, memory = step({key: jnp.asarray(getattr(now, key)) for key in arrays}, memory)
        force, state = muscle(*columns(now)[:, places].T, state)
        np.testing.assert_allclose(force, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_a_name_that_is_no_name_in_python_is_refused():
    with pytest.raises(UsageError, match="letters, digits"):
        python_function(CASES[0].fitted, "lambda")
