"""What every task is asked: a law, effects, a specimen."""

import os
import shlex
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from ..core import Specimen, UsageError
from ..effects import Effect, get_effect, load_effect_files
from ..model import Model
from ..records import Record, read_record
from ..records.files import share_of_memory
from ..records.kind import BLOCKS
from ..records.where import rows_where

AUTO = "auto"
"""In place of a law: take the one that predicts best what it has not seen."""
REFIT = "refit"
"""In place of what is held out: fit only the parameters anew."""
MOST_OF_MEMORY = 0.5
"""Share of the free memory from which a record's text will not fit into it as numbers."""


def check_heldout(word: str) -> None:
    """Raises UsageError for what nobody holds out."""
    if word not in (*BLOCKS, REFIT):
        raise UsageError(f"--heldout {word}: expected one of {', '.join((*BLOCKS, REFIT))}")


def load(record: str | Path, specimen: str | Path | Specimen | None = None, where: str | None = None) -> Record:
    """Read a record: a file, a folder or a pattern; of its rows those for which `where` holds. Raises DataError, and
    UsageError for a condition that is none."""
    found = read_record(record, specimen)
    return found if where is None else rows_where(found, where)


@dataclass(frozen=True)
class Setup:
    """What a task is asked: a law by name with effects, the user's own effect files, and the specimen's file.

    Args:
        law: name of a law of the catalogue, a Python file that defines one of the user's own, or `auto` for a task that
            chooses one.
        effects: `name` or `name:form` each.
        effect_files: Python files that define effects of the user's own.
        free_geometry: whether radius and braid angle are fitted, too.
        specimen: file of the muscle; without it each record takes the `specimen.toml` beside it.
        without, only: names of effects that a diagnosis does not try, or the only ones that it tries.
        also: names of effects that it tries beside its candidates, such as `moving_mass`.
        prior: TOML file of prior odds of effects, over those that any other has: `creep = 10`.
        where: condition on the rows of a record that are taken, such as `pressure_MPa > 0.1`.
        assume: codes of grave doubts that are meant so (`all` for every one), which do not stop naming.
        heldout: what is held out whole while everything is chosen anew: length, pressure, run, cycle or muscle;
            `refit` to fit only the parameters anew. By default what suits the record, and `refit` for a diagnosis.
        chosen: whether the law was chosen by the record.

    Example:
        >>> from pam_ident.tasks.setup import Setup
        >>> setup = Setup("chou_hannaford", ("creep",), free_geometry=True)
        >>> print(setup.command("fit", "run.csv"))
        pam-ident fit run.csv --law chou_hannaford --effect creep --free-geometry
    """

    law: str
    effects: tuple[str, ...] = ()
    effect_files: tuple[str, ...] = ()
    free_geometry: bool = False
    specimen: str | None = None
    without: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    prior: str | None = None
    where: str | None = None
    assume: tuple[str, ...] = ()
    heldout: str = ""
    chosen: bool = False

    @cached_property
    def extra(self) -> tuple[Effect, ...]:
        """The effects of the user's own files. Raises UsageError where one cannot be loaded."""
        return load_effect_files(self.effect_files)

    @property
    def own(self) -> bool:
        """Whether a law or an effect is the user's own, which another process could not look up."""
        return bool(self.extra) or self.law.endswith(".py")

    @property
    def held_out(self) -> str:
        """What is held out whole while everything is chosen anew; empty where nobody says."""
        return "" if self.heldout == REFIT else self.heldout

    @property
    def tried(
        self,
    ) -> tuple[tuple[Effect, ...], tuple[str, ...], tuple[str, ...], Mapping[str, float], tuple[str, ...]]:
        """What a diagnosis is asked to try: effects of the user's own, names left out, the only ones, prior odds, and
        names beside the candidates."""
        return self.extra, self.without, self.only, self.odds, self.also

    @cached_property
    def odds(self) -> Mapping[str, float]:
        """Prior odds of effects by name. Raises UsageError for a file that holds none."""
        if self.prior is None:
            return {}
        try:
            found = tomllib.loads(Path(self.prior).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise UsageError(f"{self.prior}: {error}; expected lines such as `creep = 10`") from None
        for name, chance in found.items():
            if isinstance(chance, bool) or not isinstance(chance, int | float):
                raise UsageError(f"{self.prior}: {name} is {chance!r}; expected a number, such as `creep = 10`")
        return found

    @cached_property
    def model(self) -> Model:
        """The law with its effects. Raises UsageError for an unknown name."""
        return Model.build(self.law, self.effects, self.extra, self.free_geometry)

    def check(self) -> None:
        """Raises UsageError for an unknown law or effect, or prior odds that are none, before any record is read."""
        for name in (*self.odds, *self.also):
            get_effect(name, self.extra)
        _ = self.model if self.law != AUTO else Model.build("chou_hannaford", self.effects, self.extra)

    @cached_property
    def law_alone(self) -> Model:
        """The law without effects."""
        return Model.build(self.law, free_geometry=self.free_geometry)

    def read(self, record: str | Path) -> Record:
        """The record with its specimen. Raises DataError, UsageError for one that memory cannot hold."""
        if share_of_memory(record) > MOST_OF_MEMORY:
            raise UsageError(
                f"{record}: its text is more than half of the memory that is free, and only `fit` reads a record in "
                "chunks; take a part of it, or a larger machine"
            )
        return load(record, self.specimen, self.where)

    def bare(self) -> "Setup":
        """The same for another process: files of effects by absolute path, nothing loaded from them."""
        prior = None if self.prior is None else os.path.abspath(self.prior)
        return replace(self, effect_files=tuple(os.path.abspath(path) for path in self.effect_files), prior=prior)

    def command(self, verb: str, record: str | tuple[str, ...], *more: str) -> str:
        """The command line that asks the same again, of one record or of several."""
        records = (record,) if isinstance(record, str) else record
        words = ["pam-ident", verb, *records, "--law", self.law]
        words += [word for name in self.effects for word in ("--effect", name)]
        words += [word for path in self.effect_files for word in ("--effect-file", path)]
        if self.free_geometry:
            words.append("--free-geometry")
        if self.specimen is not None:
            words += ["--specimen", self.specimen]
        if self.where is not None:
            words += ["--where", self.where]
        if self.heldout and verb in ("diagnose", "ladder", "add", "report"):
            words += ["--heldout", self.heldout]
        if verb in ("diagnose", "ladder", "report"):
            words += [word for name in self.also for word in ("--also", name)]
            words += [word for name in self.without for word in ("--without", name)]
            words += [word for name in self.only for word in ("--only", name)]
        if verb == "diagnose" and self.prior is not None:
            words += ["--prior", self.prior]
        words += [word for code in self.assume for word in ("--assume", code)]
        return shlex.join([*words, *more])
