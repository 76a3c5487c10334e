"""The table of rungs in docs/leg.md is what the leg does now."""

import re
import runpy

import pytest

from pam_ident.tasks.track import TrackOptions, track_leg

pytestmark = pytest.mark.long


def rows_of(text):
    """The numbers of each row of a table in Markdown, by its first cell."""
    lines = re.findall(r"^\| ([^|]+) \|(.*\d\.\d.*)$", text, re.M)
    return {name: [float(x) for x in re.findall(r"\d+\.\d+", rest)] for name, rest in lines}


def test_the_rungs_at_one_stride_a_second_are_those_of_the_page(root):
    pytest.importorskip("mujoco")
    bench = runpy.run_path(str(root / "benchmarks" / "leg_tables.py"))
    page = (root / "docs" / "leg.md").read_text(encoding="utf-8")
    told = rows_of(page.partition("<!-- rungs -->")[2].partition("<!-- /rungs -->")[0])
    now = rows_of(bench["rungs"](*(track_leg(TrackOptions(cadence_Hz=1.0, prototype=leg)) for leg in (False, True))))
    assert len(told) == 11 and told.keys() == now.keys()
    for name, numbers in told.items():
        assert now[name] == pytest.approx(numbers, rel=0.05, abs=0.01), name
