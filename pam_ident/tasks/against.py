"""Two records beside each other: the same law, each diagnosed, and what differs."""

from collections.abc import Mapping
from dataclasses import replace

from ..diagnosis.against import Against
from ..diagnosis.against import against as against_each_other
from ..records import Record
from ..report.against import render_against
from ..report.story import provenance
from .diagnose import diagnose_record
from .gate import computing
from .law_choice import LawChoice, choose_for_all
from .setup import AUTO, Setup


def against_records(a: Record, b: Record, setup: Setup) -> tuple[Against, LawChoice | None]:
    """What differs between two records, and how the law was chosen where none was named.

    Args:
        a, b: the records, such as of a muscle as new and aged, of two muscles, or from two rigs.
        setup: the law, and effects that are known of both.

    Raises:
        FitError, DataError: where one of them cannot be fitted, or looks too wrong to name anything by.
    """
    choice = None
    if setup.law == AUTO:
        with computing(a):
            choice = choose_for_all((a, b), setup)
        setup = replace(setup, law=choice.law)
    first, second = diagnose_record(a, setup), diagnose_record(b, setup)
    with computing(a):
        return against_each_other(first, second), choice


def against_page(found: Against, given: Mapping[str, Record], command: str) -> str:
    """One HTML file about two records; `given` are the records by their paths."""
    return render_against(found, provenance(given, command))
