"""A record of one's own protocol from the virtual rig, with chosen effects hidden in it."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..core import UsageError
from ..core.files import write_whole
from ..rig import Plan, Secret, make_record, write_case
from ..rig.hidden import UNKNOWNS
from ..rig.protocol_file import read_protocol


def run_protocol(
    folder: str | Path,
    protocol: str | Path,
    law: str,
    effects: Sequence[str] = (),
    seed: int = 1,
    size: float = 3.0,
    times: int = 1,
) -> dict[str, Any]:
    """Run a protocol file; write record.csv, specimen.toml and truth.json into `folder` and return what is hidden.

    `effects` are rig effects, NAME or NAME:FORM; `size` is what each leaves in the standard protocol, in multiples of
    the noise; the run is written `times` over, with fresh noise. The same seed is the same muscle under any protocol.
    Raises UsageError for what the rig cannot do.
    """
    if times < 1:
        raise UsageError(f"--repeat {times}: expected 1 or more")
    secrets, unknown = [], []
    for word in effects:
        name, _, form = word.partition(":")
        (unknown if name in UNKNOWNS else secrets).append(Secret(name, form or "textbook", size))
    if len(unknown) > 1:
        raise UsageError(f"--effect {' and '.join(u.name for u in unknown)}: the rig hides one unknown fault at a time")
    read = read_protocol(protocol)
    try:
        plan = Plan(seed, law, tuple(secrets), next(iter(unknown), None), read)
        truth = write_case(folder, make_record(plan), times)
    except ValueError as error:
        raise UsageError(f"{protocol}: {error}") from None
    write_whole(Path(folder) / "truth.json", json.dumps([truth], indent=1) + "\n")
    return truth
