"""NI TDMS files: each group of channels is a table, or a run of the test."""

import logging
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


def read_tables(path: Path, mapping: Mapping | None = None) -> list[Table]:
    """The groups that hold channels; a unit is the channel's property `unit_string`, the time that of the waveform
    where no channel is called so. Samples count from 1. Raises DataError, UsageError without npTDMS.
    """
    with reading(path, "npTDMS", "TDMS file", "copy it again from the rig"):
        import nptdms
        from nptdms.log import log_manager

        log_manager.set_level(logging.CRITICAL)  # what it would print of a broken file is an error here
        file = nptdms.TdmsFile.read(path)
        groups = {group.name: group.channels() for group in file.groups()}
    if file.file_status.incomplete_final_segment or not _ends_with_a_segment(path):
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
    return tables


def _ends_with_a_segment(path: Path) -> bool:
    """Whether the segments fill the file: bytes too many are nobody's samples, and shift all that follow them."""
    at, size = 0, path.stat().st_size
    with path.open("rb") as file:
        while at < size:
            file.seek(at)
            lead = file.read(LEAD)
            at += LEAD + int.from_bytes(lead[12:20], "little")
    return at == size


def _table(place: str, channels: list) -> Table:
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
            columns[header] = channel[:]
    names = [channel.name for channel in channels if len(channel) == n]
    if not any(quantity_of(header) == "time" for header in columns):
        steps = {float(channel.properties.get("wf_increment", 0.0)) for channel in channels if len(channel) == n}
        if len(steps) == 1 and (step := steps.pop()) > 0.0:
            start = float(channels[0].properties.get("wf_start_offset", 0.0))
            columns["time [s]"] = start + step * np.arange(n)
            names.append("time")
    return table_in_memory(place, place, pd.DataFrame(columns), 1, names)


FORMAT = Format((".tdms",), read_tables)
