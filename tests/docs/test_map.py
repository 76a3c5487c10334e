"""The map of the package in docs/object-model.md is the package."""

import re
import subprocess
import sys
import tomllib

import pytest

MOST_HOPS = 12


def rooms_on_the_map(root):
    page = (root / "docs" / "object-model.md").read_text(encoding="utf-8")
    block = re.search(r"## The map.*?```\n(.*?)```", page, re.S)
    return [line.split()[0] for line in block[1].splitlines()]


def test_every_room_is_on_the_map_and_nothing_else(root):
    package = root / "pam_ident"
    there = {path.parent.name for path in package.glob("*/__init__.py")} | {
        path.stem for path in package.glob("*.py") if not path.stem.startswith("__")
    }
    shown = rooms_on_the_map(root)
    assert set(shown) == there and len(shown) == len(set(shown))


def test_the_map_is_in_the_order_that_the_import_contract_holds(root):
    contracts = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(c for c in contracts if c["type"] == "layers")["layers"]
    line = {room.strip(): k for k, layer in enumerate(layers) for room in layer.split("|")}
    shown = [line[room] for room in rooms_on_the_map(root) if room != "rig"]
    assert shown == sorted(shown) and len(shown) == len(line)


@pytest.mark.long
def test_a_diagnosis_takes_few_hops_and_the_page_shows_them(root):
    script = [sys.executable, str(root / "docs" / "make_map.py")]
    made = subprocess.run(script, capture_output=True, text=True, check=True)
    lines = made.stdout.strip("\n")
    assert 5 < len(lines.splitlines()) <= MOST_HOPS
    assert lines in (root / "docs" / "object-model.md").read_text(encoding="utf-8")
