"""Files damaged by chance: never a traceback, never a silently wrong unit."""

import numpy as np
import pytest
from corpus import SPECIMEN, as_text
from mutations import one, verdict

from pam_ident.records import read_record


@pytest.mark.parametrize("count", [300, pytest.param(20_000, marks=pytest.mark.long)])
def test_damaged_files_are_read_right_or_refused(tmp_path, count):
    (tmp_path / "specimen.toml").write_text(SPECIMEN)
    found = [one(tmp_path, np.random.default_rng([7, k])) for k in range(count)]
    assert [x for x in found if x[2]] == []
    assert {x[1] for x in found} == {"read", "refused"}


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("pressure_MPa", "pressure_bar", "row 0"),
        ("force_N", "force_kN", "row 0"),
        ("1375.25,1", "1", ""),
        ("1350.25", "1350.26", ""),
        ("50.25", "50.26", "rows differ"),
    ],
)
def test_the_judge_sees_what_is_wrong(put, old, new, fault):
    text = as_text()
    record = read_record(put(text.replace(old, new)))
    assert fault in verdict(record, text.splitlines()[0], 1, 1 if fault != "row 0" else 0)
