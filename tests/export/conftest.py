"""Samples, and what NumPy says of them, once for all tests of exports."""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
import pytest
from cases import Expected, samples

from pam_ident.core import Inputs


@pytest.fixture(scope="session")
def inputs() -> Inputs:
    return samples()


@pytest.fixture(scope="session")
def numpy_forces(inputs) -> dict[str, np.ndarray]:
    """Force of every case along all tracks, by its name."""
    return Expected(inputs)


_made = runpy.run_path(str(Path(__file__).parents[1] / "plot" / "conftest.py"))
record, table, diagnosis, ladder = (_made[name] for name in ("record", "table", "diagnosis", "ladder"))
"""The made-up results of the figures' tests."""
