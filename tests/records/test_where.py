"""Rows by a condition: names with units, comparisons, and, or, not, and nothing else."""

import numpy as np
import pytest
from corpus import DISPLACEMENT, FORCE, HEADERS, PRESSURE, ROWS, as_text, values

from pam_ident.core import DataError, UsageError
from pam_ident.records import read_record
from pam_ident.records.record import rebuilt
from pam_ident.records.where import rows_where
from pam_ident.tasks.setup import Setup


@pytest.fixture
def record(put):
    text = as_text((*HEADERS, "cycle"), np.column_stack([values(), 1 + np.arange(ROWS) // 6]))
    return read_record(put(text))


@pytest.mark.parametrize(
    ("condition", "mask"),
    [
        ("pressure_MPa > 0.4", PRESSURE > 0.4),
        ("pressure_bar > 4", PRESSURE > 0.4),
        ("`Pressure [bar]` > 4 and force_kN < 1.2", (PRESSURE > 0.4) & (FORCE < 1200)),
        ("5 <= displacement_mm < 10 or cycle == 4", (DISPLACEMENT >= 5) & (DISPLACEMENT < 10) | (np.arange(ROWS) > 17)),
        ("not (cycle == 1 or cycle == 2)", np.arange(ROWS) > 11),
        ("length_cm >= 19 and force_N > -1e3", DISPLACEMENT <= 10),
        ("contraction != 0 and pressure_set_MPa > 0", DISPLACEMENT != 0),
        ("branch == 'contraction'", np.ones(ROWS, bool)),
        ("time_s < 0.55", np.arange(ROWS) < 6),
    ],
)
def test_the_rows_for_which_it_holds(record, condition, mask):
    found = rows_where(record, condition)
    np.testing.assert_array_equal(found.force, FORCE[mask])
    assert mask.all() == (found is record)
    if not mask.all():
        (note,) = found.notes
        assert (note.code, note.rows) == ("rows_chosen", ROWS - mask.sum()) and condition in note.text


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        ("pressure_MPa >", "cannot be read"),
        ("pressure > 0.1", "no unit given"),
        ("pressure_N > 0.1", "unknown unit"),
        ("valve > 1", "no 'valve'"),
        ("temperature_C > 20", "no 'temperature_C'"),
        ("force_N", "neither true nor false"),
        ("force_N + 1 > 2", "neither a name nor a number"),
        ("force_N > 1 & cycle > 2", "neither a name nor a number"),
        ("force_N > 'x'", "cannot be compared"),
        ("cycle in [1, 2]", "neither a name"),
        ("1 < 2", "names no column"),
        ("__import__('os').system('true') == 0", "neither a name"),
        ("force_N.__class__ == 1", "neither a name"),
        ("[x for x in (1,)] == 1", "neither a name"),
        ("(lambda: 1)() > 0", "neither a name"),
        ("not " * 600 + "cycle > 1", "characters"),
        ("(" * 400 + "cycle > 1" + ")" * 400, "cannot be read"),
        ("\0", "cannot be read"),
        ("", "cannot be read"),
    ],
)
def test_anything_else_is_refused(record, condition, words):
    with pytest.raises(UsageError, match=words) as caught:
        rows_where(record, condition)
    assert "--where" in str(caught.value) and len(str(caught.value)) < 1000


def test_no_row_is_bad_data(record):
    with pytest.raises(DataError, match="nothing is left"):
        rows_where(record, "force_N > 1e6")


def test_a_gap_begins_a_segment_and_strokes_stay(record):
    """A pause of the clock is 2 s at least: rows that go for less leave no gap."""
    slow = rebuilt(record, record.specimen, "isobaric")
    assert len(np.unique(rows_where(slow, "time_s < 0.3 or time_s > 0.8").inputs.segment)) == 2
    assert len(np.unique(rows_where(slow, "cycle == 1").inputs.segment)) == 1


def test_a_command_takes_it_along(record):
    setup = Setup("chou_hannaford", where="pressure_MPa > 0.4")
    assert len(setup.read(record.source)) == ROWS // 2
    assert setup.command("fit", "r.csv").endswith("--where 'pressure_MPa > 0.4'")
