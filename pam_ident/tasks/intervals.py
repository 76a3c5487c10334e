"""Intervals of a fit's parameters by likelihood profiles or a bootstrap, shared out among a crew."""

import os
from dataclasses import dataclass, replace
from functools import partial

from ..fitting import Fit
from ..fitting.bootstrap import Bootstrap, Draws, bootstrap
from ..fitting.profile import Profile, profile
from ..fitting.refit import refit_weights
from ..parallel.crew import do_all
from .setup import Setup

DRAWS = 2000
"""Refits of a bootstrap."""


@dataclass(frozen=True)
class Crew:
    """Who works: `workers` processes of this machine, or the Dask cluster at `scheduler`; this process where neither is
    said."""

    workers: int | None = None
    scheduler: str | None = None


NOBODY = Crew()


def profiles_of(one: Fit, setup: Setup, crew: Crew) -> dict[str, Profile]:
    """Profile of each fitted parameter that stands at no bound, by name, a task each."""
    work = partial(_profile, *_packed(one, setup))
    return dict(zip(one.free, do_all(work, one.free, "profiles", crew.workers, crew.scheduler), strict=True))


def bootstrap_of(one: Fit, setup: Setup, seed: int, crew: Crew) -> Bootstrap:
    """A bootstrap by cycles; its draws are made here, some hundred refits to them are a task."""

    def refit(parts: list[Draws]) -> list:
        return do_all(partial(_refit, *_packed(one, setup)), parts, "hundreds of refits", crew.workers, crew.scheduler)

    return bootstrap(one, DRAWS, "cycle", seed, refit)


def _packed(one: Fit, setup: Setup) -> tuple[Setup, Fit]:
    """The two as they can be sent to another process, which loads the user's own effects itself."""
    files = tuple(os.path.abspath(path) for path in setup.effect_files)
    return replace(setup, effect_files=files), replace(one, model=setup.law_alone)


def _profile(setup: Setup, one: Fit, name: str) -> Profile:
    return profile(replace(one, model=setup.model), name)


def _refit(setup: Setup, one: Fit, draws: Draws):
    return refit_weights(replace(one, model=setup.model), *draws)
