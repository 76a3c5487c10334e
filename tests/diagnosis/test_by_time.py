"""Whether a force builds up by the cycle, or by the time since the muscle was pressurised."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.diagnosis import diagnose
from pam_ident.model import Model
from pam_ident.records import Record, read_record
from pam_ident.rig import Plan, Secret, make_record, write_case

CHOU = "modified_chou_hannaford"


def rig_record(folder, *secrets: Secret) -> Record:
    write_case(folder, make_record(Plan(71, CHOU, secrets)))
    return read_record(folder / "record.csv")


@pytest.mark.long
def test_what_creeps_since_it_was_pressurised_is_creep(tmp_path):
    """It was Mullins softening with 0.985 and more, alone, where no form of creep began with the pressure."""
    record = rig_record(tmp_path)
    since = record.inputs.time - np.array([record.inputs.time[record.level == p].min() for p in record.level])
    crept = replace(record, force=record.force + 15.0 * record.inputs.pressure * np.log1p((since + 5.0) / 4.0))
    found = diagnose(Model.build(CHOU), crept)
    assert found.verdict == "missing_effect" and found.selected == ("creep",)


@pytest.mark.long
def test_softening_by_the_cycle_is_told_from_creep(tmp_path):
    found = diagnose(Model.build(CHOU), rig_record(tmp_path, Secret("mullins_softening", "textbook", 3.0)))
    assert found.selected == ("mullins_softening",) and found.groups == ()
