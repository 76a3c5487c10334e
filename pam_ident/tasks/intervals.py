"""Intervals of a fit's parameters by likelihood profiles or a bootstrap, whoever computes them."""

from dataclasses import replace
from functools import partial

from ..fitting import Fit
from ..fitting.bootstrap import Bootstrap, Draws, bootstrap
from ..fitting.profile import Profile, profile
from ..fitting.refit import refit_weights
from ..parallel.executor import Executor
from .setup import Setup

DRAWS = 2000
"""Refits of a bootstrap."""


def profiles_of(one: Fit, setup: Setup, executor: Executor) -> dict[str, Profile]:
    """Profile of each fitted parameter that stands at no bound, by name, a task each."""
    work = partial(_profile, *_packed(one, setup))
    return dict(zip(one.free, executor.all(work, one.free, "profiles"), strict=True))


def bootstrap_of(one: Fit, setup: Setup, seed: int, executor: Executor) -> Bootstrap:
    """A bootstrap by cycles; its draws are made here, some hundred refits to them are a task."""
    work = partial(_refit, *_packed(one, setup))
    return bootstrap(one, DRAWS, "cycle", seed, lambda parts: executor.all(work, parts, "hundreds of refits"))


def _packed(one: Fit, setup: Setup) -> tuple[Setup, Fit]:
    """The two as they can be sent to another process, which loads the user's own effects itself."""
    return setup.bare(), replace(one, model=setup.law_alone)


def _profile(setup: Setup, one: Fit, name: str) -> Profile:
    return profile(replace(one, model=setup.model), name)


def _refit(setup: Setup, one: Fit, draws: Draws):
    return refit_weights(replace(one, model=setup.model), *draws)
