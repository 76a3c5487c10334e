"""A sealed set of simulated records to examine a diagnosis with."""

from ..core import UsageError
from ..rig import make_challenge


def write_challenge(folder: str, n: int = 60, seed: int = 1, only: str | None = None) -> int:
    """Write `n` cases and their answers (truth.json) into `folder`; how many were written.

    `only` asks for cases of one kind. Raises UsageError for an unknown kind or a count below 1.
    """
    try:
        return len(make_challenge(folder, n, seed, only))
    except ValueError as error:
        raise UsageError(str(error)) from None
