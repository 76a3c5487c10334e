"""Test-rig records: what was measured, cut into branches, cycles and holds."""

from ..core import Specimen
from .load import file_sha256, read_record, read_specimen, record_from_frame
from .record import Record, build_record
from .thin import thinned

__all__ = [
    "Record",
    "Specimen",
    "build_record",
    "file_sha256",
    "read_record",
    "read_specimen",
    "record_from_frame",
    "thinned",
]
