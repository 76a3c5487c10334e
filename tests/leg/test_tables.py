"""The table of rungs in docs/leg.md is what the leg does now."""

import re
import runpy

import pytest

from pam_ident.tasks.track import Wishes, track_leg

pytestmark = pytest.mark.long
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def test_the_rungs_at_one_stride_a_second_are_those_of_the_page(root):
    pytest.importorskip("mujoco")
    bench = runpy.run_path(str(root / "benchmarks" / "leg_tables.py"))
    now = bench["rungs"](*(track_leg(Wishes(cadence_Hz=1.0, prototype=leg)) for leg in (False, True)))
    page = (root / "docs" / "leg.md").read_text(encoding="utf-8")
    told = page.partition("<!-- rungs -->\n")[2].partition("\n<!-- /rungs -->")[0]
    assert NUMBER.split(told) == NUMBER.split(now), "run `python benchmarks/leg_tables.py --markdown docs/leg.md`"
    found, shown = ([float(x) for x in NUMBER.findall(text)] for text in (now, told))
    assert found == pytest.approx(shown, rel=0.05, abs=0.02)
