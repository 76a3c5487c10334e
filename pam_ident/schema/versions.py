"""The versions of all that is written as JSON: a new one when a field changes its meaning or goes."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..records.doubt import Doubt

VERSIONS = {
    "add": 1,
    "against": 1,
    "batch": 1,
    "batch-record": 1,
    "batch-summary": 1,
    "challenge": 1,
    "comparison": 1,
    "demo": 1,
    "diagnosis": 1,
    "effects": 1,
    "export": 1,
    "fit": 1,
    "inspection": 1,
    "ladder": 1,
    "laws": 1,
    "package": 1,
    "prediction": 1,
    "refusal": 1,
    "rig": 1,
    "selftest": 1,
    "track": 1,
    "validation": 1,
    "workbench": 1,
}


def picked(one: object, *names: str) -> dict[str, Any]:
    """Some fields of an answer by their own names."""
    return {name: getattr(one, name) for name in names}


def warnings_json(doubts: "Sequence[Doubt]") -> list[dict[str, Any]]:
    """What stands under "warnings" in every answer."""
    return [asdict(doubt) for doubt in doubts]


def schema(kind: str) -> str:
    """What stands under "schema" in an answer of a kind, such as pam-ident/fit/1. Raises KeyError for another kind."""
    return f"pam-ident/{kind}/{VERSIONS[kind]}"
