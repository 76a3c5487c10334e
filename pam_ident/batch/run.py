"""Many records fitted alike: resumed where it stopped, one table and one page at the end."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from ..core import UsageError
from ..core.files import write_whole
from ..core.progress import tell
from ..parallel.crew import check_crew, cluster
from ..tasks.setup import Setup
from .cluster import work_on_cluster
from .question import Item, Plan, Question, plan
from .store import Store
from .table import require_arrow, table
from .work import Done, FitAndKeep, work_here

TABLE, PAGE, KEPT = "results.parquet", "index.html", "records"


@dataclass(frozen=True)
class Batch:
    """What a batch came to: its records, how many answers were kept from an earlier run, and what went wrong by
    record."""

    folder: Path
    records: int
    kept: int
    errors: dict[str, str]

    @property
    def table(self) -> Path:
        """The Parquet table."""
        return self.folder / TABLE

    @property
    def page(self) -> Path:
        """The page that compares the muscles."""
        return self.folder / PAGE


def run_batch(
    folder: str | Path,
    setup: Setup,
    out: str | Path,
    *,
    branch: str = "together",
    diagnose: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    note: Callable[[str], None] = lambda line: None,
) -> Batch:
    """Answer every record under a folder, and write a table and a page.

    Each answer is a file of its own as soon as it is found, so that the same call goes on where an earlier one was
    killed. The table is the same, byte for byte, whoever did the work and however often it was interrupted. A bad
    record is an error in its rows.

    Args:
        folder: the tree of records; each takes the `specimen.toml` beside or above it.
        setup: the law and its effects.
        out: the folder of the results.
        branch: `together`, `separate`, `contraction` or `extension`.
        diagnose: whether to name what the model lacks, too.
        workers: a Dask cluster of so many on this machine; by default a process for each core.
        scheduler: address of a Dask cluster that does the work.
        note: is told what the user should hear.

    Raises:
        UsageError: for what cannot be asked, and where the results cannot be written.

    Example:
        >>> from pam_ident.batch.run import run_batch
        >>> from pam_ident.records.datasets import dataset_path
        >>> from pam_ident.tasks.setup import Setup
        >>> done = run_batch(dataset_path("dmsp20_300"), Setup("polynomial"), "results")
        >>> print(done.records, "record,", len(done.errors), "errors,", done.table.name)
        1 record, 0 errors, results.parquet
    """
    require_arrow()
    check_crew(workers, scheduler)
    question = Question(setup, branch, diagnose)
    _ = setup.model
    folder, out = Path(folder), Path(out)
    asked = plan(folder, question, out)
    store = Store(_make(out.resolve() / KEPT))
    waiting = [item for item in asked.items if store.get(item.key) is None]
    kept = len(asked.items) - len(waiting)
    work = FitAndKeep(question.bare(), store)
    doing = _doing(work, waiting, workers, scheduler, note)
    done = len(asked) - len(waiting)
    tell("records", done, len(asked))
    lost = {}
    for item, outcome in _until_stopped(doing, out, kept):
        done += 1
        if outcome.error is not None and store.get(item.key) is None:
            lost[item.name] = outcome.error
        tell("records", done, len(asked))
    words = ["--branch", branch, *(["--diagnose"] if diagnose else []), "--out", str(out)]
    _conclude(asked, question, store, lost, out, setup.command("batch", str(folder), *words))
    return Batch(out, len(asked), kept, _errors(asked, store, lost))


def _doing(
    work: FitAndKeep, items: list[Item], workers: int | None, scheduler: str | None, note: Callable[[str], None]
) -> Iterator[tuple[Item, Done]]:
    if scheduler is None and (workers is None or min(workers, len(items)) < 2 or find_spec("distributed") is None):
        yield from work_here(work, items, min(workers or os.cpu_count() or 1, max(len(items), 1)))
        return
    with cluster(min(workers or 1, len(items)), scheduler) as address:
        yield from work_on_cluster(work, items, address, note)


def _make(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / "probe", "").unlink()
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written to ({error.strerror}); name another folder by --out") from None
    return folder


def _until_stopped(doing: Iterator[tuple[Item, Done]], out: Path, kept: int) -> Iterator[tuple[Item, Done]]:
    for count, (item, outcome) in enumerate(doing):
        if outcome.stop is not None:
            raise _Stopped(outcome.stop, kept + count)
        yield item, outcome


class _Stopped(UsageError):
    def __init__(self, why: str, done: int) -> None:
        super().__init__(
            f"{why}. The {done} records that are finished are kept: mend that, then give the same command again"
        )


def _conclude(asked: Plan, question: Question, store: Store, lost: dict[str, str], out: Path, command: str) -> None:
    from .page import batch_page

    try:
        store.sweep()
        write_whole(out / TABLE, table(asked, question, store, lost))
        write_whole(out / PAGE, batch_page(out / TABLE, command))
    except OSError as error:
        raise _Stopped(f"{error.filename or out}: {error.strerror or error}", len(asked.items) - len(lost)) from None


def _errors(asked: Plan, store: Store, lost: dict[str, str]) -> dict[str, str]:
    """The first error of each record that has one, by name."""
    found = asked.faults | lost
    for item in asked.items:
        kept = store.get(item.key) or {"rows": []}
        message = next((row["error"] for row in kept["rows"] if row["error"]), None)
        if message is not None:
            found[item.name] = message
    return dict(sorted(found.items()))
