"""Very many samples are fitted to the same minimum as by the long way."""

import numpy as np
import pytest

from pam_ident.fitting import fit
from pam_ident.fitting.large import solve_large
from pam_ident.fitting.solve import solve
from pam_ident.model import Model


@pytest.mark.parametrize("name", ["exponential_law", "modified_chou_hannaford", "polynomial", "sarosi"])
def test_the_short_way_ends_where_the_long_way_ends(name, record):
    many = record(n=100_000)
    model = Model.build(name)
    short = solve_large(model, many.inputs, many.force, {})
    long = solve(model, many.inputs, many.force, lambda m: m)
    assert short is not None
    for key, value in long.values.items():
        assert short.values[key] == pytest.approx(value, rel=1e-6, abs=1e-7)
    assert fit(model, many, detail=False).values == short.values


def test_what_remembers_the_past_goes_the_long_way(record):
    many = record(n=60_000)
    assert solve_large(Model.build("exponential_law", ("creep",)), many.inputs, many.force, {}) is None
    assert solve_large(Model.build("exponential_law"), record(n=1000).inputs, record(n=1000).force, {}) is None


def test_an_answer_at_a_bound_goes_the_long_way(record):
    many = record(n=60_000)
    force = np.where(many.inputs.direction > 0, many.force, many.force - 3.0)  # friction that would have to push
    assert solve_large(Model.build("exponential_law", ("coulomb_friction",)), many.inputs, force, {}) is None
