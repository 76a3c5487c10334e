from dataclasses import replace

import numpy as np
import pytest

from pam_ident.diagnosis.nouns import Candidate, Diagnosis, Experiment, Ladder, Pattern, Rung
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import Specimen, build_record

LAW = "modified_chou_hannaford"
SPECIMEN = Specimen("made up", 200.0, 10.0, 25.0)


def make_record(name="made up"):
    """Two isobars, two speeds, two cycles each; friction of 8 N and 0.5 N of noise."""
    rng = np.random.default_rng(7)
    stroke = np.linspace(0.0, 40.0, 41)
    x, t, p, cycle, now = [], [], [], [], 0.0
    for pressure in (0.3, 0.5):
        for speed in (4.0, 16.0):
            for number in (1, 2):
                for part in (stroke, stroke[::-1]):
                    x.append(part)
                    t.append(now + np.arange(41) / speed)
                    now = t[-1][-1] + 1.0 / speed
                    p.append(np.full(41, pressure))
                    cycle.append(np.full(41, number))
        now += 60.0
    x, t, p, cycle = map(np.concatenate, (x, t, p, cycle))
    contraction = x / 200.0
    law = Model.build(LAW).law
    sign = np.where(np.arange(len(x)) // 41 % 2 == 0, 1.0, -1.0)
    force = law.force(p, contraction, SPECIMEN, {"k0": 0.8, "k1": 1.1, "k2": -5.0})
    force = force - 8.0 * sign + rng.normal(0.0, 0.5, len(x))
    return build_record(
        name,
        SPECIMEN,
        p,
        contraction,
        force,
        time=t,
        level=p,
        cycle=cycle,
        direction=sign,
        source="made.csv",
        sha256="ab" * 32,
    )


def make_table():
    """Three isobars over five lengths, without time."""
    rng = np.random.default_rng(8)
    p, contraction = (a.ravel() for a in np.meshgrid([0.2, 0.4, 0.6], [0.0, 0.05, 0.1, 0.15, 0.2]))
    force = 2000.0 * p * (1.0 - 3.0 * contraction) + rng.normal(0.0, 2.0, len(p))
    return build_record("table", SPECIMEN, p, contraction, force)


def make_diagnosis(record, pattern=None):
    base = fit(Model.build(LAW), record)
    best = fit(Model.build(LAW, ("coulomb_friction",)), record)
    ranking = (
        Candidate("coulomb_friction", "coulomb_friction", "candidate", 0.97, best.rmse, 0.6, "explains 99 %"),
        Candidate("viscous_damping", "viscous_damping:power", "candidate", 0.02, 0.9 * base.rmse, None),
        Candidate("creep", "creep", "candidate", 0.05, 0.95 * base.rmse, 8.2),
        Candidate("force_bias", "force_bias", "absorbed_by_law", 0.0, why="the law holds k2"),
        Candidate("thermal_softening", "thermal_softening", "not_excited", 0.0, why="no temperature"),
    )
    return Diagnosis(
        base=base,
        best=best,
        verdict="missing_effect",
        selected=("coulomb_friction",),
        labels=("coulomb_friction",),
        groups=(("coulomb_friction", "pressure_friction"),),
        ranking=ranking,
        noise_floor=0.5,
        heldout_rmse=8.3,
        heldout_rmse_after=0.55,
        pattern=pattern,
        next_experiment=Experiment(("pressure",), "Repeat the strokes at 0.1 MPa."),
        sentence="The law lacks coulomb_friction: a constant gap of 16 N between the branches.",
    )


@pytest.fixture(scope="session")
def record():
    return make_record()


@pytest.fixture(scope="session")
def table():
    return make_table()


@pytest.fixture(scope="session")
def diagnosis(record):
    return make_diagnosis(record)


@pytest.fixture(scope="session")
def ladder(diagnosis):
    rungs = (Rung(diagnosis.base, 8.3, "the law alone"), Rung(diagnosis.best, 0.55, "halves the error"))
    return Ladder(rungs, 0.5, diagnosis)


@pytest.fixture
def with_pattern(diagnosis):
    return replace(diagnosis, pattern=Pattern("local", "contraction", 12.0, "mm", 0.25, "A rub at 12 mm."))
