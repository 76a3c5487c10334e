"""A plant that is off: by how much, in the forces, masses and pressures of the pair itself."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import UsageError
from pam_ident.leg.mismatch import AS_KNOWN, Mismatch
from pam_ident.leg.pneumatics import ATMOSPHERE
from pam_ident.model import as_term

AT = {"gauge_MPa": np.array([0.3, 0.4]), "contraction": np.array([0.1, 0.12]), "speed": np.array([40.0, -40.0])}


def pull(pair, time=0.0):
    values = pair.muscle.values()
    memory = pair.muscle.start(AT["gauge_MPa"], AT["contraction"])
    return np.asarray(pair.pull(values, memory, time, **AT)[0])


@pytest.fixture
def known(example):
    return example[0]


def test_nothing_off_is_the_same_plant(known):
    plant = AS_KNOWN.plant(known, 1.0)
    assert np.array_equal(pull(plant, 3.0), pull(known, 3.0)) and plant.leg == known.leg
    assert plant.supply.pressure_Pa == pytest.approx(known.supply.pressure_Pa) and str(AS_KNOWN) == ""


def test_each_muscle_has_its_share_and_ages_with_the_strides(known):
    plant = Mismatch((0.9, 1.1), ageing=0.02).plant(known, cadence_Hz=0.5)
    assert pull(plant) == pytest.approx(pull(known) * [0.9, 1.1])
    lost = 0.98**5  # ten seconds are five strides
    assert pull(plant, 10.0) == pytest.approx(pull(known) * [0.9, 1.1] * lost)


def test_mass_and_supply_are_the_plants_and_the_thigh_is_held(known):
    leg = replace(known.leg, load_mass_kg=2.0)
    plant = Mismatch(mass=1.2, supply=0.8).plant(replace(known, leg=leg), 1.0)
    for name in ("shank", "foot"):
        one, other = getattr(plant.leg, name), getattr(leg, name)
        assert (one.mass_kg, one.inertia_kg_m2) == pytest.approx((1.2 * other.mass_kg, 1.2 * other.inertia_kg_m2))
    assert plant.leg.load_mass_kg == pytest.approx(2.4) and plant.leg.thigh == leg.thigh
    gauge = known.supply.pressure_Pa - ATMOSPHERE
    assert plant.supply.pressure_Pa - ATMOSPHERE == pytest.approx(0.8 * gauge)


def test_an_unknown_effect_is_in_the_force_by_so_many_times_its_typical_size(known):
    friction = as_term("coulomb_friction")
    typical = friction.form.linear[0].scale
    plant = Mismatch(unknown=friction, size=2.0).plant(known, 1.0)
    assert pull(plant) - pull(known) == pytest.approx([-2.0 * typical, 2.0 * typical])
    assert "coulomb_friction" in str(Mismatch(unknown=friction))


def test_an_effect_that_the_muscle_has_is_refused(known):
    with pytest.raises(UsageError, match="viscous_damping"):
        Mismatch(unknown=as_term("viscous_damping")).plant(known, 1.0)


def test_it_tells_what_is_off():
    told = str(Mismatch((0.9, 1.0), 1.2, ageing=0.01))
    assert "flexor's force -10 %" in told and "mass +20 %" in told and "1 % with each stride" in told
    assert "supply" not in told
