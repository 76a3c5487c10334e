"""A form that nothing reaches: what is left overturns no name that stands out from it, and proves none."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.schedule import one_speed
from pam_ident.model import Model
from pam_ident.records import Record, read_record, thinned
from pam_ident.records.datasets import dataset_record


@pytest.fixture(scope="module")
def nothing() -> Record:
    return thinned(read_record(dataset_record("nothing_hidden")), 1600)


@pytest.mark.long
@pytest.mark.parametrize(("size", "rough", "stands"), [(80.0, 0.2, False), (150.0, 0.05, True)])
def test_friction_that_no_form_reaches_keeps_its_name_if_it_explains_nearly_all(
    nothing: Record, size: float, rough: float, stands: bool
) -> None:
    inputs = nothing.inputs
    x = inputs.displacement_mm
    assert inputs.moving is not None
    place = 1 + rough * (np.tanh((x - 12) / 2) - np.tanh((x - 25) / 1.5) + np.exp(-(((x - 18) / 2) ** 2)))
    kept = np.where(inputs.moving, 1.0, 0.5) * inputs.direction
    rubbed = replace(nothing, force=nothing.force - size * kept * (0.3 + 2.0 * inputs.pressure) * place)
    found = diagnose(Model.build("exponential_law"), rubbed)
    assert found.verdict == "unknown_effect"
    assert found.selected == ("pressure_friction",) * stands
    assert not stands or found.best.rmse < 0.25 * found.base.rmse
    assert found.noise_floor < 2.5  # that of the sensor, 2 N: what no form reaches is no noise


def test_a_speed_that_only_pressure_and_branch_change_is_one_speed(nothing: Record) -> None:
    inputs = nothing.inputs
    assert not one_speed(nothing)
    own = 10.0 + 20.0 * nothing.level + 3.0 * inputs.direction
    assert one_speed(replace(nothing, inputs=replace(inputs, stroke_speed=own)))
    assert not one_speed(replace(nothing, inputs=replace(inputs, stroke_speed=own * (1.0 + (nothing.block % 2)))))
