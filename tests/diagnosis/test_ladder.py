"""Which effects become steps of a ladder."""

from dataclasses import replace

import numpy as np

from pam_ident.core import Specimen
from pam_ident.diagnosis import climb
from pam_ident.diagnosis.sentence import why_it_ends
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import build_record

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)


def braid_with_friction(seed):
    """Five isobars of an ideal braid, whose force has no exponential part, with friction that grows with pressure."""
    t = np.arange(160) * 0.3
    way = 1.0 - np.abs(2.0 * ((t / 12.0) % 1.0) - 1.0)
    p = np.repeat((0.1, 0.2, 0.3, 0.4, 0.5), len(t))
    e, branch = np.tile(0.2 * way, 5), np.tile(np.sign(np.gradient(way)), 5)
    noise = np.random.default_rng(seed).standard_normal(len(p))
    force = 300.0 * p * (9.0 * (1.0 - e) ** 2 - 4.5) - 30.0 * p * branch + noise
    return build_record("r", MUSCLE, p, e, force, time=np.concatenate([t + 200.0 * k for k in range(5)]))


def test_an_effect_is_added_though_the_law_s_own_parameters_are_loose_once_it_is():
    """What friction leaves hides that this record never determined the law's decay."""
    record, law = braid_with_friction(4), Model.build("exponential_law")
    below, above = (fit(model, record) for model in (law, Model("exponential_law", ["pressure_friction"])))
    assert below.valid and "mu" in above.undetermined and "pressure_friction.mu_f" not in above.undetermined
    first, *steps = climb(law, record, detail=False).rungs
    assert [step.fit.model.effect_names for step in steps] == [["pressure_friction"]]
    assert steps[-1].fit.rmse < 0.3 * first.fit.rmse and not steps[-1].fit.valid


def test_a_ladder_says_from_which_effects_the_record_cannot_tell_its_own():
    ladder = climb(Model.build("exponential_law"), braid_with_friction(4), detail=False)
    below, step = ladder.rungs
    assert ladder.groups == step.found.groups and "cannot tell" in why_it_ends(ladder), "all strokes have one speed"
    groups = (("pressure_friction", "coulomb_friction"), ("creep", "force_drift"))
    unsure = replace(ladder, rungs=(below, replace(step, found=replace(step.found, groups=groups))))
    assert unsure.groups == groups[:1], "of effects that it holds"
    assert "cannot tell friction that grows with pressure from Coulomb friction" in why_it_ends(unsure)
