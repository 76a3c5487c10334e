"""What may be wrong with a record: the one place that says it, for `inspect` and for the gate before every answer."""

from collections.abc import Iterable
from dataclasses import dataclass

GRAVE = {
    "specimen": "the size of the muscle is in another unit",
    "pressure_sign": "the pressure is negative where a muscle works",
    "pressure_absolute": "the pressure counts from vacuum, not from the air's",
    "scale": "force, pressure or radius is in another unit",
    "displacement_scale": "the displacement or the initial length is in another unit",
    "displacement_sign": "the displacement is counted the other way",
    "branch_sign": "the branches are named the other way about",
    "force_sign": "pull is counted as negative",
    "force_constant": "the force does not answer what is driven",
    "force_clipped": "the load cell or its amplifier is at its limit",
    "impossible_value": "single values that no muscle reaches",
    "outlier": "single values that decide the fit",
    "clock_scale": "the time is in another unit",
    "no_clock": "the rows are a log, and its time was not read",
    "temperature_scale": "the temperature is in another unit",
    "explains_nothing": "the law leaves as much as no law would",
}
"""Code of a grave doubt → what it suspects. It stops naming until `--assume CODE` says that the record is meant so."""


@dataclass(frozen=True)
class Doubt:
    """Something that looks wrong: a `code`, a `text` in plain words, and the column it is about, None where it is about
    none. A grave one stops naming."""

    code: str
    text: str
    column: str | None = None
    grave: bool = False

    def __str__(self) -> str:
        return f"WARNING ({self.code}): {self.text}" if self.grave else f"Warning: {self.text}"


def grave(doubts: Iterable[Doubt], assume: Iterable[str] = ()) -> tuple[Doubt, ...]:
    """The grave ones that `assume`, codes or `all`, does not say are meant so."""
    meant = set(assume)
    return tuple(doubt for doubt in doubts if doubt.grave and not meant & {doubt.code, "all"})
