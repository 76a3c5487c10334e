"""The plain statement of the leg beside this file is importable; a muscle without friction in a loop, compiled once."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def example():
    """The same smooth plant twice: a Pair, and in plain floats."""
    from plain_loop import smooth_example

    return smooth_example()


@pytest.fixture(scope="session")
def loop(example):
    """The smooth plant under control, an angle sensor of 40 bits."""
    from pam_ident.leg.control import Sensor
    from pam_ident.leg.loop import Loop

    return Loop(example[0], Sensor(bits=40))


@pytest.fixture(scope="session")
def course():
    """Two strides of Winter's gait at 1 Hz, the second is judged."""
    from pam_ident.leg.course import Course
    from pam_ident.leg.gait import winter

    return Course(winter(1.0))


SAMPLES = 110


@pytest.fixture(scope="session")
def task(example, course):
    """The begin of the course, 0.55 s, both muscles commanded the mean pressure."""
    import numpy as np

    from pam_ident.leg.arrays import jax

    whole = course.task(np.full(2, example[0].mean_MPa))
    return jax.tree.map(lambda a: a[:SAMPLES], whole)
