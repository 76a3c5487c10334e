"""A tenth of all that is thrown at the program, made anew each day: its seed is the day's date."""

import datetime
import runpy

import pytest

pytestmark = pytest.mark.long
pytest.importorskip("panel")
MOST_ALARMS = 2
"""Of some hundred nulls; of a thousand at most one in a hundred is allowed."""


@pytest.fixture(scope="module")
def bench(root):
    return runpy.run_path(str(root / "benchmarks" / "faults.py"))


@pytest.mark.parametrize("kind", ["files", "degenerate", "spikes", "hostile", "nulls"])
def test_a_tenth_of_today(bench, kind):
    seed = int(datetime.datetime.now(datetime.UTC).strftime("%Y%m%d"))
    rows = list(bench["rows"](0.1, seed, (kind,)))
    print(*rows, sep="\n")  # pytest shows it where the test fails
    wrong = [failure for row in rows for failure in row.failures]
    assert len(wrong) <= (MOST_ALARMS if kind == "nulls" else 0), wrong


def test_the_table_of_the_page_counts_what_the_command_tries(bench, root):
    page = (root / "docs" / "validation.md").read_text(encoding="utf-8")
    lines = [line for line in page.split(bench["OPEN"])[1].split(bench["CLOSE"])[0].splitlines() if line]
    assert tuple(lines[:2]) == bench["HEAD"]
    tried = {line.split("|")[1].strip(): int(line.split("|")[4]) for line in lines[2:]}
    asked = {word: bench[word.upper()] for word in ("degenerate", "hostile")} | {"spikes": bench["SPIKED"]}
    asked |= {"files": bench["TEXTS"] + 6 * bench["BINARIES"]}
    for word, least in asked.items():
        assert sum(n for name, n in tried.items() if word in name) >= least, word
