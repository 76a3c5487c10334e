"""What every law in the catalogue promises. A new file in laws/ is tested here unnamed."""

import re
from itertools import product

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.fitting import fit
from pam_ident.laws import Law, catalogue
from pam_ident.model import Model
from pam_ident.records import build_record

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)
UNITS = {"1", "N", "MPa", "mm", "deg"}
EACH_LAW = pytest.mark.parametrize("law", catalogue().values(), ids=catalogue())


def each_law_that_has(what: str):
    """The laws of which a list of parameters, such as `nonlinear`, holds any."""
    found = {name: law for name, law in catalogue().items() if getattr(law, what)}
    return pytest.mark.parametrize("law", found.values(), ids=found)


def states(seed: int, n: int = 40):
    """Pressure in MPa and contraction over the working range."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0.05, 0.7, n), rng.uniform(-0.02, 0.3, n)


def random_values(law: Law, seed: int) -> dict[str, float]:
    """Linear parameters of the typical size, positive where bounds ask for it; others between their grid's ends."""
    rng = np.random.default_rng(seed)
    values = {}
    for q in law.linear:
        size = q.scale * rng.uniform(0.2, 1.5)
        values[q.name] = size if q.lower >= 0.0 else size * rng.choice([-1.0, 1.0])
    return values | {q.name: rng.uniform(min(q.grid), max(q.grid)) for q in law.nonlinear}


@EACH_LAW
def test_a_law_is_linear_in_what_it_calls_linear(law):
    p, e = states(4)
    values, other = random_values(law, 5), random_values(law, 6)
    columns, fixed = law.columns(p, e, MUSCLE, values), law.fixed(p, e, MUSCLE, values)
    assert columns.shape == (len(p), len(law.linear)) and fixed.shape == (len(p),)
    force = law.force(p, e, MUSCLE, values)
    np.testing.assert_allclose(force, fixed + sum(columns[:, k] * values[q.name] for k, q in enumerate(law.linear)))
    mixed = {q.name: 2.0 * values[q.name] - 3.0 * other[q.name] for q in law.linear}
    shape = {q.name: values[q.name] for q in law.nonlinear}
    second = law.force(p, e, MUSCLE, other | shape)
    expected = 2.0 * (force - fixed) - 3.0 * (second - fixed) + fixed
    np.testing.assert_allclose(law.force(p, e, MUSCLE, mixed | shape), expected, rtol=1e-9, atol=1e-9)


@EACH_LAW
def test_a_law_is_finite_at_the_corners_of_its_bounds_and_of_the_working_range(law):
    p, e = (np.ravel(g) for g in np.meshgrid([0.0, 0.3, 0.8], [-0.02, 0.0, 0.15, 0.35]))
    ends = [
        [x if np.isfinite(x) else np.sign(x) * 10.0 * q.scale for x in (q.lower, q.start, q.upper)] for q in law.params
    ]
    for corner in product(*ends):
        values = {q.name: x for q, x in zip(law.params, corner, strict=True)}
        for specimen in (MUSCLE, Specimen("steep", 30.0, 20.0, 5.0), Specimen("flat", 500.0, 3.0, 54.0)):
            assert np.isfinite(law.force(p, e, specimen, values)).all(), values


@each_law_that_has("linear")
def test_the_columns_of_a_law_are_told_apart_by_as_many_pressures_as_it_says(law):
    shape = {q.name: q.start for q in law.nonlinear}

    def rank(levels):
        p, e = (np.ravel(g) for g in np.meshgrid(np.linspace(0.1, 0.6, levels), np.linspace(0.0, 0.25, 20)))
        columns = law.columns(p, e, MUSCLE, shape)
        return np.linalg.matrix_rank(columns / np.linalg.norm(columns, axis=0), tol=1e-8)

    assert rank(law.min_levels) == len(law.linear)
    assert law.min_levels == 1 or rank(law.min_levels - 1) < len(law.linear)


@each_law_that_has("params")
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_fit_finds_the_parameters_that_made_clean_data(law, seed):
    p, e = (np.ravel(g) for g in np.meshgrid(np.linspace(0.1, 0.7, 7), np.linspace(-0.01, 0.28, 30)))
    values = random_values(law, seed)
    record = build_record("clean", MUSCLE, p, e, law.force(p, e, MUSCLE, values))
    found = fit(Model(law), record)
    assert found.valid, found.problems
    for name, value in values.items():
        assert found.values[name] == pytest.approx(value, rel=1e-6), name


@EACH_LAW
def test_jax_and_numpy_agree(law):
    jax = pytest.importorskip("jax")
    p, e = states(7)
    values = random_values(law, 8)
    shape = {q.name: values[q.name] for q in law.nonlinear}
    with jax.enable_x64(True):

        @jax.jit
        def traced(p, e, values):
            parts = law.columns(p, e, MUSCLE, values), law.fixed(p, e, MUSCLE, values)
            return *parts, law.force(p, e, MUSCLE, values)

        answers = traced(jax.numpy.asarray(p), jax.numpy.asarray(e), values)
        expected = law.columns(p, e, MUSCLE, shape), law.fixed(p, e, MUSCLE, shape), law.force(p, e, MUSCLE, values)
        for answer, wanted in zip(answers, expected, strict=True):
            assert answer.shape == wanted.shape and answer.dtype == np.float64
            # 1e-12 of what is added up, where pressure and rubber cancel
            size = np.abs(wanted) if wanted.ndim == 2 else np.max(np.abs(wanted), initial=1e-9)
            assert np.all(np.abs(np.asarray(answer) - wanted) <= 1e-12 * size)


@each_law_that_has("nonlinear")
def test_jax_traces_many_values_at_once(law):
    jax = pytest.importorskip("jax")
    p, e = states(9)
    names = [q.name for q in law.nonlinear]
    several = np.array([[q.start, *q.grid] for q in law.nonlinear]).T
    with jax.enable_x64(True):

        def columns(shape):
            return law.columns(jax.numpy.asarray(p), jax.numpy.asarray(e), MUSCLE, dict(zip(names, shape, strict=True)))

        together = np.asarray(jax.jit(jax.vmap(columns))(jax.numpy.asarray(several)))
    for answer, shape in zip(together, several, strict=True):
        np.testing.assert_allclose(answer, law.columns(p, e, MUSCLE, dict(zip(names, shape, strict=True))), rtol=1e-12)


@pytest.mark.long
@EACH_LAW
def test_the_derivatives_that_jax_takes_are_those_of_finite_differences(law):
    """By pressure, contraction and every parameter; Richardson's extrapolation of central differences."""
    jax = pytest.importorskip("jax")
    p, e = states(10)
    e = np.where(np.abs(e) < 5e-3, 0.01, e)  # ε^(2/3) has no slope at 0
    values = random_values(law, 11)
    names = [q.name for q in law.params]
    point = np.array([0.0, 0.0, *values.values()])

    def force(x, p, e):
        """Force with shifts of p and ε for the first two of `x`, then the parameters."""
        return law.force(p + x[0], e + x[1], MUSCLE, dict(zip(names, x[2:], strict=True)))

    with jax.enable_x64(True):
        slopes = jax.jit(jax.jacfwd(lambda x: force(x, *map(jax.numpy.asarray, (p, e)))))(jax.numpy.asarray(point))
        slopes = np.asarray(slopes)
    for k in range(len(point)):
        step = np.eye(len(point))[k] * (1e-4 * abs(point[k]) if k > 1 else 1e-4)

        def slope(h, k=k, step=step):
            return (force(point + h * step, p, e) - force(point - h * step, p, e)) / (2.0 * h * step[k])

        expected = (4.0 * slope(0.5) - slope(1.0)) / 3.0
        np.testing.assert_allclose(slopes[:, k], expected, rtol=1e-6, atol=1e-6 * (1.0 + np.abs(expected).max()))


@EACH_LAW
def test_arrays_are_left_as_they_were(law):
    p, e = states(12)
    before = p.copy(), e.copy()
    law.force(p, e, MUSCLE, random_values(law, 13))
    assert np.array_equal(p, before[0]) and np.array_equal(e, before[1])


@EACH_LAW
def test_a_law_names_itself_its_source_and_its_parameters(law):
    assert law.name.isidentifier() and law.title and law.formula and law.source
    assert all(q.name.isidentifier() and q.doc for q in law.params)
    assert len({q.name for q in law.params}) == len(law.params)
    assert all(q.grid and q.lower <= min(q.grid) and max(q.grid) <= q.upper for q in law.nonlinear)
    for q in law.params:
        symbols = set(re.split(r"[·/()]", re.sub(r"\^\d", "", q.unit))) - {""}
        assert symbols and symbols <= UNITS, f"{q.name}: {q.unit!r}"


@EACH_LAW
def test_a_law_of_the_package_is_called_as_its_file(law, root):
    home = root / "pam_ident" / "laws" / f"{law.name}.py"
    assert "LAW = Law(" in home.read_text(encoding="utf-8")


def test_the_laws_do_without_jax(root):
    files = list((root / "pam_ident" / "laws").glob("*.py"))
    assert len(files) > len(catalogue())
    for file in files:
        assert not re.search(r"^\s*(import|from) jax", file.read_text(encoding="utf-8"), re.M), file.name
