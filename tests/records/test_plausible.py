"""What a record's zeros and units can be, beside an ideal braid."""

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import Specimen
from pam_ident.records import record_from_frame
from pam_ident.records.gate import doubts_of

MUSCLE = Specimen("m", 200.0, 10.0, 25.4, 1.5)


def stroke(contracting_only: bool = False, pressure: str = "pressure_MPa", less: float = 0.0) -> pd.DataFrame:
    """A stroke out and back at five gauge pressures, of a muscle that begins to pull at 0.06 MPa."""
    there = np.linspace(0.0, 20.0, 60)
    x = there if contracting_only else np.r_[there, there[::-1]]
    p, x = np.repeat([0.1, 0.2, 0.3, 0.4, 0.5], len(x)), np.tile(x, 5)
    force = np.maximum(MUSCLE.ideal_force(p - 0.06, x / 200.0), 0.0)
    frame = {"time_s": np.arange(len(p)) * 0.1, "displacement_mm": x, "force_N": force}
    return pd.DataFrame(frame | {pressure: p * (1000.0 if "kPa" in pressure else 1.0) - less})


def grave(frame: pd.DataFrame) -> list[str]:
    return [doubt.code for doubt in doubts_of(record_from_frame(frame, MUSCLE)) if doubt.grave]


@pytest.mark.parametrize("contracting_only", [False, True])
def test_one_branch_begins_to_pull_where_both_do(contracting_only):
    assert grave(stroke(contracting_only)) == []


def test_gauge_pressure_under_a_name_that_says_absolute_is_seen():
    absolute = stroke(pressure="pressure_kPa_abs", less=-101.325)
    assert grave(absolute) == []
    assert grave(stroke(pressure="pressure_kPa_abs")) == ["pressure_absolute"]
