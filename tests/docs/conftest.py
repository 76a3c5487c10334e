"""The makers of the documentation's pages, and the pages that they make."""

import re
import sys
from importlib import import_module

import pytest

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


@pytest.fixture(scope="session")
def maker(root):
    """Import a module of docs/_ext by name."""
    sys.path.insert(0, str(root / "docs" / "_ext"))
    yield import_module
    sys.path.remove(str(root / "docs" / "_ext"))


@pytest.fixture(scope="session")
def paper_audit(root):
    """Import a module of docs/paper_audit by name."""
    sys.path.insert(0, str(root / "docs"))
    yield lambda name: import_module(f"paper_audit.{name}")
    sys.path.remove(str(root / "docs"))


@pytest.fixture(scope="session")
def generated(maker, tmp_path_factory):
    """The folder of all pages that are made at a build."""
    folder = tmp_path_factory.mktemp("pages") / "generated"
    maker("pages").write_pages(folder)
    return folder


def _agree(shown, now):
    """Words equal, numbers within one unit of the last digit that is shown, the ninth at most: machines differ."""
    if NUMBER.split(shown) != NUMBER.split(now):
        return False
    for a, b in zip(NUMBER.findall(shown), NUMBER.findall(now), strict=True):
        digits = a.partition("e")[0].partition(".")[2]
        unit = 10.0 ** -len(digits) if "e" not in a else 0.1 * abs(float(a))
        if abs(float(a) - float(b)) > max(1.01 * unit, 1e-9 * abs(float(a))):
            return False
    return True


@pytest.fixture(scope="session")
def agree():
    """Whether two texts say the same: words equal, numbers within one unit of the last digit that is shown."""
    return _agree
