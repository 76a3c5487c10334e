"""A log whose time was not read is no static table; a table that was meant so is one."""

import numpy as np
import pandas as pd
import pytest

from pam_ident.core import Specimen
from pam_ident.records import record_from_frame

MUSCLE = Specimen("muscle", 200.0, 10.0, 25.0)
LEVELS = (0.2, 0.3, 0.4, 0.5)
STROKE = np.linspace(0.0, 40.0, 60)


def told(ways, levels=LEVELS, **more):
    """The note on its clock of a test along ways, one a level; `more` columns by header."""
    pressure = np.repeat(levels, [len(way) for way in ways])
    way = np.concatenate(ways)
    columns = {"pressure_MPa": pressure, "displacement_mm": way, "force_N": 2500.0 * pressure * (1.0 - way / 60.0)}
    columns |= {name: np.broadcast_to(column, len(way)) for name, column in more.items()}
    record = record_from_frame(pd.DataFrame(columns), MUSCLE)
    return [note for note in record.notes if note.code == "no_clock"]


def test_a_log_without_its_time_is_doubted_and_the_column_that_looks_like_it_is_named():
    way = np.r_[STROKE, STROKE[::-1]]
    clock = 0.1 * np.arange(4 * len(way))
    (note,) = told([way] * 4, AI7=clock, mark=clock**2)
    assert note.column == "AI7" and "'AI7' looks like it" in note.text
    (note,) = told([way] * 4, mark=3.0)
    assert note.column is None and "passed over are 'mark'" in note.text
    assert told([way] * 4)


def test_one_way_and_back_is_a_log_beside_a_clock_only():
    way = [np.r_[STROKE, STROKE[::-1]]]
    assert told(way, (0.3,), AI7=0.1 * np.arange(120)) and not told(way, (0.3,))


def test_a_pressure_that_goes_back_and_forth_is_a_log_too():
    pressure = 0.3 + 0.2 * np.sin(np.arange(400) / 20.0)
    assert told([np.array([0.0])] * 400, pressure)


@pytest.mark.parametrize(
    "ways",
    [
        [STROKE] * 4,
        [np.linspace(0.0, 40.0, 9)] * 4,
        [np.random.default_rng(3).uniform(0.0, 40.0, 200)] * 4,
    ],
    ids=["sorted", "few", "in any order"],
)
def test_a_static_table_is_not_doubted_for_the_numbers_of_its_rows(ways):
    assert not told(ways, No=np.arange(sum(map(len, ways))))


def test_loops_with_a_branch_are_a_table_unless_there_is_a_clock():
    way = np.r_[STROKE, STROKE[::-1]]
    branch = np.tile(np.repeat(["contraction", "extension"], 60), 4)
    assert not told([way] * 4, branch=branch) and told([way] * 4, branch=branch, AI7=0.1 * np.arange(480))
