"""The Python function, run without pam-ident."""

import numpy as np
import pytest
from cases import CASES, EACH_CASE, LENGTH, assert_agrees, columns, instant

from pam_ident.core import UsageError
from pam_ident.export.program import ARGUMENTS, program
from pam_ident.export.python import python_function


def function_of(case):
    """What the exported file defines; it can import NumPy alone."""
    text = python_function(case.fitted, "muscle")
    assert [line for line in text.splitlines() if "import" in line and "#" not in line] == ["import numpy as np"]
    defined: dict = {}
    exec(compile(text, "muscle.py", "exec"), defined)
    return defined["muscle"]


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
    assert_agrees(case, found, numpy_forces[case.name], inputs)


def test_a_name_that_is_no_name_in_python_is_refused():
    with pytest.raises(UsageError, match="letters, digits"):
        python_function(CASES[0].fitted, "lambda")
