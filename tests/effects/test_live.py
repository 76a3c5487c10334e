"""Effects asked instant by instant say what they say along a whole record, for muscles side by side."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Inputs, Specimen
from pam_ident.core.recursion import Live
from pam_ident.effects import catalogue
from pam_ident.leg.arrays import jax, jnp
from pam_ident.validation.effect_contract import LAW_VALUES, model_of, plausible

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)
HALF_A_STEP_BEHIND = {"moving_mass"}
"""What needs the next sample, too, which live is not there yet; held against small steps in test_optional.py."""
FORMS = [(e, form) for e in catalogue().values() if e.name not in HALF_A_STEP_BEHIND for form in e.forms]
EACH_FORM = pytest.mark.parametrize(("effect", "form"), FORMS, ids=[f"{e.name}:{f.name}" for e, f in FORMS])
EACH_FORM_SLOWLY = pytest.mark.parametrize(
    ("effect", "form"),
    [pytest.param(e, f, id=f"{e.name}:{f.name}", marks=() if f is e.forms[0] else pytest.mark.long) for e, f in FORMS],
)
"""The first form of each effect, and all of them in the long tier."""
REMEMBER = {
    *(
        f"creep:{form}"
        for form in (
            "textbook",
            "pressed",
            "logarithmic",
            "prony_3",
            "elastic",
            "force_driven",
            "following",
            "free",
            "free_begun",
            "free_pressurised",
            "free_tension",
        )
    ),
    *(
        f"presliding_hysteresis:{form}"
        for form in ("textbook", "dahl", "pressed", "lugre", "maxwell_slip_3", "rested", "free")
    ),
    *(f"force_drift:{form}" for form in ("textbook", "settling", "settling_on", "logarithmic", "swinging", "free")),
    *(
        f"thermal_softening:{form}"
        for form in ("textbook", "quadratic", "from_cold", "lagging", "pressure", "elastic", "linear", "free")
    ),
    *(f"coulomb_friction:{form}" for form in ("stuck", "relaxing", "free")),
    *(f"stribeck_friction:{form}" for form in ("relaxing", "bending")),
    "pressure_friction:bending",
    *(f"pressure_lag:{form}" for form in ("lagging", "filling", "conductance", "valve", "choking", "free_lagging")),
    "mullins_softening:pseudo_elastic",
    *(f"mullins_softening:{form}" for form in ("travelled", "travelled_on", "free_travelled", "free_travelled_on")),
    *(f"nonlocal_hysteresis:{form}" for form in ("textbook", "growing", "curved")),
    *(f"first_cycle:{form}" for form in ("textbook", "shaped", "rested")),
}


def track(seed, n=240, dt=(0.004, 0.09)):
    """A muscle that goes to and fro without a rest, 30 samples each way, while pressure and temperature wander.

    Cycles are counted as in a record, each second reversal a new one.
    """
    rng = np.random.default_rng(seed)
    time = np.cumsum(np.random.default_rng(1).uniform(*dt, n))
    ends = np.where(
        np.arange(n // 30 + 1) % 2, rng.uniform(22.0, 45.0, n // 30 + 1), rng.uniform(0.0, 15.0, n // 30 + 1)
    )
    x = np.interp(np.arange(n), np.arange(0, n + 30, 30), ends)
    x += 0.1 * np.sin(np.arange(n) * np.pi / 30.0)  # not straight, still one way
    direction = np.where((np.arange(n) - 1) // 30 % 2, -1.0, 1.0)
    assert np.all(np.diff(x) * direction[1:] > 0.0)
    velocity = np.r_[0.0, np.diff(x) / np.diff(time)]
    return Inputs(
        pressure=0.35 + 0.1 * np.sin(np.arange(n) * rng.uniform(0.03, 0.08)),
        contraction=x / 200.0,
        specimen=MUSCLE,
        direction=direction,
        time=time,
        velocity=velocity,
        stroke_speed=np.abs(velocity),
        moving=np.ones(n, bool),
        cycle=1.0 + np.r_[0, np.cumsum(np.diff(direction) != 0.0)] // 2,
        temperature=20.0 + rng.uniform(0.0, 5.0) + 3.0 * np.sin(time),
        segment=np.zeros(n, int),
    )


TRACKS = [track(seed) for seed in (2, 3, 4)]


def instant(k):
    """The muscles of all tracks side by side at sample k."""
    names = [name for name, value in vars(TRACKS[0]).items() if isinstance(value, np.ndarray) and len(value) > 1]
    rows = {name: np.array([getattr(one, name)[k] for one in TRACKS]) for name in names if name != "displacement_mm"}
    return replace(TRACKS[0], **rows)


def forces(k=slice(None)):
    """A force in N for each track that has nothing to do with any model, (samples, muscles)."""
    return np.stack([800.0 - 3000.0 * one.contraction + 900.0 * one.pressure for one in TRACKS], axis=-1)[k]


def shape_of(form):
    return {p.name: p.clip(1.15 * p.start if p.start else 0.1 * p.scale) for p in form.nonlinear}


@EACH_FORM
def test_columns_asked_live_are_those_along_the_record(effect, form):
    shape = shape_of(form)
    batch = np.stack([form.columns(one, shape, forces()[:, k]) for k, one in enumerate(TRACKS)], axis=1)
    memory, found = None, []
    for k in range(len(TRACKS[0])):
        live = Live(memory)
        found.append(form.columns(replace(instant(k), live=live), shape, forces(k)))
        memory = live.slots
    assert bool(memory) == (f"{effect.name}:{form.name}" in REMEMBER)
    np.testing.assert_allclose(np.array(found), batch, rtol=1e-9, atol=1e-9 * np.abs(batch).max())


@EACH_FORM_SLOWLY
def test_a_model_asked_live_has_the_force_along_the_record(effect, form):
    model = model_of(effect, form, "exponential_law")
    values = LAW_VALUES | plausible(effect, form)
    batch = np.stack([model.force(one, values) for one in TRACKS], axis=1)
    memory, found = None, []
    for k in range(len(TRACKS[0])):
        force, memory = model.step(instant(k), values, memory)
        found.append(force)
    np.testing.assert_allclose(np.array(found), batch, rtol=1e-9, atol=1e-8)


@EACH_FORM_SLOWLY
def test_jax_steps_a_model_as_numpy_does(effect, form):
    """Compiled, with the parameters traced; the second and third instant, so that the memory is traced too."""
    model = model_of(effect, form, "exponential_law")
    values = LAW_VALUES | plausible(effect, form)

    @jax.jit
    def stepped(states, values):
        memory, force = None, None
        for state in states:
            force, memory = model.step(replace(TRACKS[0], **state), values, memory)
        return force, memory

    instants = [instant(k) for k in (31, 32, 33)]
    states = [{k: jnp.asarray(v) for k, v in vars(one).items() if isinstance(v, np.ndarray)} for one in instants]
    memory, force = None, None
    for one in instants:
        force, memory = model.step(one, values, memory)
    got, remembered = stepped(states, values)
    assert got.dtype == np.float64
    np.testing.assert_allclose(got, force, rtol=1e-10)
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12), remembered, memory)


@pytest.mark.parametrize(
    "name", ["creep", "creep:prony_3", "creep:logarithmic", "presliding_hysteresis", "presliding_hysteresis:dahl"]
)
def test_a_step_is_two_half_steps_and_a_trial_changes_nothing(name):
    """Exact along a straight way: what a step's trial evaluations ask for does not depend on how it is cut."""
    base, _, word = name.partition(":")
    form = next(f for f in catalogue()[base].forms if f.name == (word or "textbook"))
    shape, here, there = shape_of(form), instant(40), instant(41)
    half = replace(
        there,
        time=0.5 * (here.time + there.time),
        contraction=0.5 * (here.contraction + there.contraction),
    )

    def after(memory, *ways):
        columns = None
        for one in ways:
            live = Live(memory)
            columns = form.columns(replace(one, live=live), shape, np.zeros(3))
            memory = live.slots
        return columns, memory

    _, accepted = after(None, *(instant(k) for k in range(35, 41)))
    kept = jax.tree.map(np.copy, accepted)
    once, twice = after(accepted, there)[0], after(accepted, half, there)[0]
    np.testing.assert_allclose(once, twice, rtol=1e-12)
    jax.tree.map(np.testing.assert_array_equal, accepted, kept)
    np.testing.assert_array_equal(after(accepted, there)[0], once)


@pytest.mark.parametrize("name", ["coulomb_friction", "stribeck_friction", "pressure_friction"])
def test_what_a_rig_keeps_in_holds_is_not_there_live(name):
    """At rest in a free joint: no sliding, nothing held, in any form."""
    rest = replace(instant(5), direction=np.zeros(3), velocity=np.zeros(3), stroke_speed=np.zeros(3), live=Live(None))
    for form in catalogue()[name].forms:
        columns = form.columns(rest, shape_of(form), np.zeros(3))
        assert columns.shape == (3, len(form.linear)) and not columns.any()
