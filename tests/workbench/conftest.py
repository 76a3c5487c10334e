"""The made-up record with friction in it of the command line's tests, and what the bench makes of it."""

import runpy
from pathlib import Path

import pytest

_cli = runpy.run_path(str(Path(__file__).parents[1] / "cli" / "conftest.py"))
write_record, rubbing = _cli["write_record"], _cli["rubbing"]


@pytest.fixture(scope="session")
def folder(rubbing) -> Path:
    """record.csv with 12 N of dry friction, specimen.toml beside it."""
    return rubbing.parent


@pytest.fixture(scope="session")
def begun(rubbing):
    """The record on the bench with the exponential law, diagnosed."""
    from pam_ident.tasks.setup import Setup
    from pam_ident.workbench.bench import Bench

    setup = Setup("exponential_law")
    return Bench.begin(setup.read(rubbing), str(rubbing), setup).diagnosed()
