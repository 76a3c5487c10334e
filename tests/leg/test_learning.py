"""Learning from stride to stride: on a linear plant as the arithmetic has it, and in the leg where the plant is off."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.leg.arrays import jax
from pam_ident.leg.control import Gains
from pam_ident.leg.course import Course
from pam_ident.leg.feed_forward import FeedForward
from pam_ident.leg.gait import winter
from pam_ident.leg.learning import HARMONICS, SHARE, Lesson, after, inverse_of, nothing, series
from pam_ident.leg.loop import Loop, Scale
from pam_ident.leg.mismatch import Mismatch

N = 50
TERMS = 2 * HARMONICS + 1


@pytest.mark.parametrize(("wrong", "factor"), [(1.0, 1.0 - SHARE), (1.3, 1.0 - 1.3 * SHARE), (0.7, 1.0 - 0.7 * SHARE)])
def test_an_error_that_comes_again_shrinks_as_fast_as_the_model_is_right(wrong, factor):
    """Angles are wrong · J c + d: the part of d that J reaches shrinks by 1 − wrong · SHARE a stride."""
    rng = np.random.default_rng(3)
    response = rng.standard_normal((N, TERMS))
    cause = rng.standard_normal(TERMS)
    gain = inverse_of(response).T
    basis = series(np.arange(N) / N)
    learned, sizes = nothing(), []
    for _ in range(4):
        error = -response @ (cause + wrong * np.asarray(learned.coefficients))
        sizes.append(np.linalg.norm(error))
        for k in range(N):
            learned = after(Lesson(basis[k], gain[k], k == N - 1), learned, error[k])
    assert np.array(sizes[1:]) / sizes[:-1] == pytest.approx(factor)


def test_nothing_changes_within_a_stride():
    lesson = Lesson(np.ones(TERMS), np.ones(TERMS), False)
    learned = after(lesson, nothing(), 0.1)
    assert not np.any(np.asarray(learned.coefficients)) and np.asarray(learned.coming) == pytest.approx(0.1)


def test_a_series_has_the_mean_and_both_phases_of_every_harmonic():
    basis = series(np.arange(200) / 200.0)
    assert basis.shape == (200, TERMS) and np.linalg.matrix_rank(basis) == TERMS
    assert basis.T @ basis == pytest.approx(np.diag([200.0] + [100.0] * (TERMS - 1)), abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("cadence", [1.0, 0.9])
def test_the_last_model_stays_ahead_of_the_pid_where_each_muscle_is_a_tenth_off(example, cadence):
    """At 0.9 Hz a stride is no whole number of samples."""
    known, _ = example
    gains, course = Gains(2.0, 1.0, 0.1), Course(winter(cadence), None, 5)
    plant = Loop(Mismatch((0.9, 1.1), mass=1.1).plant(known, cadence))
    sets = jax.tree.map(lambda value: np.full(1, value), known.muscle.values())
    plan = course.plans(FeedForward(known), sets).reference[0]
    plain = course.task(plan)
    taught = plain._replace(lesson=course.lesson(Loop(known), plan, gains))
    part, before = course.judged, replace(course, lessons=0).judged

    def rms(task, part):
        log = plant.run(known.muscle.values(), gains, Scale(), task)
        return float(np.sqrt(np.mean(np.degrees(log.flexion - task.target)[part] ** 2)))

    assert rms(taught, before) == pytest.approx(rms(plain, before), rel=1e-9)  # nothing learned yet
    assert rms(taught, part) < 0.35 * rms(plain, part)
