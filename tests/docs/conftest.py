"""The makers of the documentation's pages, and the pages that they make."""

import sys
from importlib import import_module

import pytest


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
