"""NI TDMS files: each group of channels is a table, or a run of the test."""

import logging
import re
import threading
from itertools import combinations
from pathlib import Path

import numpy as np

from ...core import DataError
from ..heading import with_unit
from ..mapping import Mapping
from ..quantities import quantity_of
from ..table import Table, table_in_memory
from .base import Format, reading

LEAD = 28
"""Bytes of a segment before its own: tag, contents, version, length, length of what is not data."""


class _Heard(logging.Handler):
    """What npTDMS only warns of is an error of the thread that reads: chunks that are not whole, an unknown scale."""

    def __init__(self) -> None:
        super().__init__()
        self.reader = threading.get_ident()

    def emit(self, record: logging.LogRecord) -> None:
        if threading.get_ident() == self.reader and record.name != "nptdms.types":  # which warns of letters alone
            raise ValueError(re.split(r"[.,] will", record.getMessage(), flags=re.IGNORECASE)[0])


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The groups that hold channels; a unit is the channel's property `unit_string`, the time that of the waveform
    where no channel is called so. Samples count from 1. Raises DataError, UsageError without npTDMS.
    """
    with reading(path, "npTDMS", "TDMS file", "copy it again from the rig"):
        import nptdms
        from nptdms.log import log_manager

        log_manager.set_level(logging.WARNING)
        log_manager.console_handler.setLevel(logging.CRITICAL)
        log, heard = logging.getLogger("nptdms"), _Heard()
        log.addHandler(heard)
        try:
            file = nptdms.TdmsFile.read(path)
            groups = {group.name: {channel: channel[:] for channel in group.channels()} for group in file.groups()}
        finally:
            log.removeHandler(heard)
    if not _ends_with_a_segment(path):
        raise DataError(f"{path}: the file breaks off, or goes on, within its last segment; copy it again from the rig")
    wanted = mapping.layout.get("part") if mapping else None
    tables = [
        _table(f"{path}, group {name!r}", channels)
        for name, channels in groups.items()
        if channels and wanted in (None, name)
    ]
    if not tables:
        what = "no channels" if wanted is None else f"no group {wanted!r} among {', '.join(groups)}"
        raise DataError(f"{path}: {what}; expected channels such as force and pressure in a group")
    _refuse_parted_runs(tables)
    return tables


def _refuse_parted_runs(tables: list[Table]) -> None:
    """Two groups of as many samples that have no quantity in common are one run, which only a single group can be."""
    held = [{quantity_of(header) for header in table.headers} - {None} for table in tables]
    lengths = [sum(map(len, table.read(()))) for table in tables]
    for i, j in combinations(range(len(tables)), 2):
        if lengths[i] == lengths[j] and held[i] and held[j] and not held[i] & held[j]:
            some, others = (", ".join(sorted(map(str, held[k]))) for k in (i, j))
            raise DataError(
                f"{tables[i].place}: {some}, and as many samples of {others} in {tables[j].place}; "
                "expected all channels of a run in one group"
            )


def _ends_with_a_segment(path: Path) -> bool:
    """Whether the segments fill the file: bytes too many are nobody's samples, and shift all that follow them."""
    at, size = 0, path.stat().st_size
    with path.open("rb") as file:
        while at < size:
            file.seek(at)
            lead = file.read(LEAD)
            at += LEAD + int.from_bytes(lead[12:20], "little")
    return at == size


def _table(place: str, channels: dict) -> Table:
    """Of a group's channels with their samples. Raises DataError."""
    import pandas as pd

    lengths = {channel.name: len(channel) for channel in channels}
    n = max(lengths.values())
    if not n:
        raise DataError(f"{place}: channels but no samples")
    columns = {}
    for channel in channels:
        unit = str(channel.properties.get("unit_string", "")).strip()
        header = with_unit(channel.name, unit, f"{place}, channel {channel.name!r}")
        if len(channel) != n and quantity_of(header) is not None:
            raise DataError(f"{place}, channel {channel.name!r}: {len(channel)} samples, others {n}; expected as many")
        if len(channel) == n:
            columns[header] = channels[channel]
    names = [channel.name for channel in channels if len(channel) == n]
    if not any(quantity_of(header) == "time" for header in columns):
        steps = {float(channel.properties.get("wf_increment", 0.0)) for channel in channels if len(channel) == n}
        if len(steps) == 1 and (step := steps.pop()) > 0.0:
            start = float(next(iter(channels)).properties.get("wf_start_offset", 0.0))
            columns["time [s]"] = start + step * np.arange(n)
            names.append("time")
    return table_in_memory(place, place, pd.DataFrame(columns), 1, names)


FORMAT = Format((".tdms",), read_tables)
