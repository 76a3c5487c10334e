"""The kind of a test is found from its data."""

import pytest

from pam_ident.records import read_record
from pam_ident.rig import PROTOCOLS, Plan, make_record, write_case

FOUND = {"combined": "dynamic", "dynamic": "dynamic", "isometric": "isometric", "isotonic": "isotonic"}


@pytest.mark.parametrize("law", ["exponential_law", pytest.param("modified_chou_hannaford", marks=pytest.mark.long)])
@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_rig_s_kind_of_test_is_found(name, law, tmp_path):
    write_case(tmp_path, make_record(Plan(11, law, protocol=name, gauges="noisy_pressure", fault="lost_rows")))
    assert read_record(tmp_path / "record.csv").kind == FOUND.get(PROTOCOLS[name].kind, "isobaric")
