"""A clean record that moves everything a test rig can move."""

import pytest

from pam_ident.records import Record
from pam_ident.validation.check_effects import clean_record


@pytest.fixture(scope="session")
def record() -> Record:
    """The clean record, force still zero."""
    return clean_record()
