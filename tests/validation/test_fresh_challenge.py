"""A sealed set that nobody has seen: its seed is the day's date."""

import datetime

import pytest

from pam_ident.validation.challenge import sit_challenge

pytestmark = pytest.mark.long
COUNT = 24


def test_a_set_of_today_is_answered(tmp_path):
    seed = int(datetime.datetime.now(datetime.UTC).strftime("%Y%m%d"))
    print(f"pam-ident challenge --n {COUNT} --seed {seed}")  # pytest shows it where the test fails
    scores = sit_challenge(tmp_path / "set", COUNT, seed).scores
    assert len(scores) == COUNT
    missed = [one for one in scores if not one.right]
    assert len(missed) <= COUNT // 8, missed  # of 120, none to 6 % were missed
