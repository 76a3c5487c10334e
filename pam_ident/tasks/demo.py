"""The main job on the bundled data."""

import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..core.files import write_whole
from ..core.progress import part
from ..diagnosis.nouns import Ladder
from ..parallel.executor import Executor
from ..records import Record
from ..records.datasets import dataset_record
from ..report import Section, Story, render
from ..report.story import provenance
from .section import build_section
from .setup import Setup

STAGES = (
    ("hidden_effect", Setup("exponential_law"), "a simulated record with a hidden effect"),
    ("nothing_hidden", Setup("exponential_law"), "its twin with nothing hidden"),
    (
        "dmsp20_300",
        Setup("chou_hannaford", free_geometry=True),
        "a measured static map, from the ideal law up, its radius and angle fitted too (--free-geometry)",
    ),
)
"""Data set, what is asked of it, and what it is."""


@dataclass(frozen=True)
class DemoPart:
    """One data set of the demonstration: what it is, and all that was found."""

    data_set: str
    about: str
    section: Section

    @property
    def ladder(self) -> Ladder:
        """Its falling error."""
        assert self.section.ladder is not None
        return self.section.ladder


@dataclass(frozen=True)
class Demo:
    """The stages, and the report that was written."""

    stages: tuple[DemoPart, ...]
    path: Path


def demo(out: str = "pam-ident-demo", done: Callable[[DemoPart], None] | None = None) -> Demo:
    """Run the stages and write one HTML report into the folder `out`, which is made; `done` is told each stage.

    Raises UsageError where the data sets were not installed.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    stages: list[DemoPart] = []
    records: dict[str, Record] = {}
    for name, setup, about in STAGES:
        path = dataset_record(name)
        record = setup.read(path)
        records[f"{name}/{path.name}"] = record
        with part(name):
            stage = DemoPart(name, about, build_section(record, setup, Executor.of_cores()))
        stages.append(stage)
        if done is not None:
            done(stage)
    source = provenance(records, shlex.join(["pam-ident", "demo", "--out", out]))
    story = Story("pam-ident on the bundled data", tuple(stage.section for stage in stages), source)
    return Demo(tuple(stages), write_whole(folder / "report.html", render(story)))
