"""The data sets that come with the program, found in a checkout and in an installed package alike."""

from pathlib import Path

from ..core import UsageError
from ..core.nearest import unknown

PACKAGE = Path(__file__).parents[1]
NAMES = ("record.csv", "reconstructed.csv", "catalogue.csv")
"""What the force record of a data set is called: measured or simulated, reconstructed, a manufacturer's curves."""


def dataset_names() -> list[str]:
    """Names of the data sets, in order; empty where they were not installed."""
    home = _home()
    return sorted(folder.parent.name for folder in home.glob("*/README.md")) if home else []


def dataset_path(name: str) -> Path:
    """Folder of the data set called `name`. Raises UsageError listing the known ones."""
    known = dataset_names()
    home = _home()
    if home is None or name not in known:
        raise UsageError(unknown("data set", name, known, "the folder datasets"))
    return home / name


def dataset_record(name: str) -> Path:
    """The CSV record of a bundled data set.

    Args:
        name: of the data set, one of `dataset_names()`.

    Raises:
        UsageError: where it is unknown or holds no force record.

    Example:
        >>> from pam_ident.records.datasets import dataset_names, dataset_record
        >>> print(dataset_names()[:3], dataset_record("dmsp20_300").name)
        ['dmsp20_300', 'festo_dmsp20_catalogue', 'gait'] record.csv
    """
    folder = dataset_path(name)
    found = _record_in(folder)
    if found is None:
        raise UsageError(f"data set {name!r} holds no force record; see {folder / 'README.md'}")
    return found


def bundled(name: str) -> Path | None:
    """The record of the data set called `name`, None where there is no such set or it holds no force record."""
    return dataset_record(name) if name in dataset_names() and _record_in(dataset_path(name)) else None


def _record_in(folder: Path) -> Path | None:
    return next((folder / file for file in NAMES if (folder / file).is_file()), None)


def _home() -> Path | None:
    """The folder of data sets: inside the installed package, else beside it in the checkout."""
    return next((folder for folder in (PACKAGE / "_datasets", PACKAGE.parent / "datasets") if folder.is_dir()), None)
