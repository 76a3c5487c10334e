"""The kind of a test is found from its data."""

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.records import build_record, read_record
from pam_ident.rig import PROTOCOLS, Plan, make_record, write_case

FOUND = {"combined": "dynamic", "dynamic": "dynamic", "isometric": "isometric", "isotonic": "isotonic"}


@pytest.mark.parametrize("law", ["exponential_law", pytest.param("modified_chou_hannaford", marks=pytest.mark.long)])
@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_rig_s_kind_of_test_is_found(name, law, tmp_path):
    write_case(tmp_path, make_record(Plan(11, law, protocol=name, gauges="noisy_pressure", fault="lost_rows")))
    assert read_record(tmp_path / "record.csv").kind == FOUND.get(PROTOCOLS[name].kind, "isobaric")


def test_a_muscle_that_is_clamped_at_lengths_in_any_order_is_isometric():
    rise = np.tile(np.r_[np.linspace(0.1, 0.6, 40), np.full(40, 0.6)], 6)  # the pressure turns hardly more often
    e = np.repeat([0.05, 0.25, 0.1, 0.15, 0.0, 0.2], 80)
    muscle = Specimen("m", 200.0, 10.0, 25.0)
    found = build_record("m", muscle, rise, e, muscle.ideal_force(rise, e), time=0.1 * np.arange(len(e)))
    assert found.kind == "isometric"
