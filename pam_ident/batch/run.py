"""Many records fitted alike: resumed where it stopped, one table and one page at the end."""

from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path

from .. import __version__
from ..core import PamError, UsageError
from ..core.files import write_whole
from ..parallel.executor import Executor
from ..tasks.law_choice import LawChoice, choose_for_all
from ..tasks.setup import AUTO, Setup, load
from .record import GRAVE, Changed, Store, answer
from .request import BatchRequest, Item, WorkList, plan
from .table import as_csv, read_results, require_arrow, table

TRIED = 5
"""Records that a law is chosen on, the first that can be read."""
TABLE, TEXT, PAGE, KEPT = "results.parquet", "results.csv", "index.html", "records"


@dataclass(frozen=True)
class Batch:
    """What a batch came to: its records, how many answers were kept from an earlier run, the first error by record of
    those that have one, what looks gravely wrong in others, how the law was chosen where none was named, and how many
    fits have which verdict: that of a diagnosis, or that of a test for a lack of fit."""

    folder: Path
    records: int
    kept: int
    errors: dict[str, str]
    grave: dict[str, str] = field(default_factory=dict)
    law_choice: LawChoice | None = None
    verdicts: Counter[str] = field(default_factory=Counter)

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
    executor: Executor | None = None,
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
        executor: who does the work, by default a process for each core; the workers of a Dask cluster must see both
            folders under the same paths.

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
    setup.check()
    folder, out = Path(folder), Path(out)
    setup, choice = _settled(folder, out, setup)
    question = BatchRequest(setup, branch, diagnose)
    asked = plan(folder, question, out)
    store = Store(_make(out.resolve() / KEPT))
    waiting = [item for item in asked.items if store.get(item.key) is None]
    kept = finished = len(asked.items) - len(waiting)
    lost = {}
    try:
        found = (executor or Executor.of_cores()).map(
            _FitAndKeep(question.bare(), store), waiting, "records", len(asked) - len(waiting)
        )
        for k, why in found:
            finished += 1
            if why is not None:
                lost[waiting[k].name] = f"{waiting[k].name}: {why}"
    except Exception as error:
        why = str(error) if isinstance(error, PamError) else f"a worker failed: {type(error).__name__}: {error}"
        raise _stopped(why, finished) from error
    words = ["--branch", branch, *(["--diagnose"] if diagnose else []), "--out", str(out)]
    _conclude(asked, question, store, lost, out, setup.command("batch", str(folder), *words))
    rows = read_results(out)
    bad = rows.dropna(subset="error").drop_duplicates("record")
    warned = rows.dropna(subset="warnings").drop_duplicates("record")
    grave = {
        record: text.removeprefix(GRAVE)
        for record, texts in zip(warned["record"], warned["warnings"], strict=True)
        for text in texts
        if text.startswith(GRAVE)
    }
    errors, verdicts = dict(zip(bad["record"], bad["error"], strict=True)), Counter(rows["verdict"].dropna())
    return Batch(out, len(asked), kept, errors, grave, choice, verdicts)


def _settled(folder: Path, out: Path, setup: Setup) -> tuple[Setup, LawChoice | None]:
    """The setup with a law, of `auto` that which does best on the first records, and how it was chosen.

    Raises UsageError where none of them can be read.
    """
    if setup.law != AUTO:
        return setup, None
    items = plan(folder, BatchRequest(replace(setup, law="chou_hannaford")), out).items
    records = []
    for item in items:
        try:
            records.append(load(item.path, item.specimen))
        except PamError:
            continue
        if len(records) == TRIED:
            break
    if not records:
        raise UsageError(f"{folder}: no record can be read to choose a law on; name one with --law")
    choice = choose_for_all(records, setup)
    return replace(setup, law=choice.law), choice


@dataclass(frozen=True)
class _FitAndKeep:
    """Answer an item and keep the answer, in whatever process: the worker that finds it does, so that nothing that is
    killed later takes it along. Says why nothing is kept; raises UsageError where no record can be worked at now."""

    question: BatchRequest
    store: Store

    def __call__(self, item: Item) -> str | None:
        if __version__ != self.question.version:
            raise UsageError(f"a worker has pam-ident {__version__}, the batch {self.question.version}; install one")
        if not self.store.folder.is_dir() or not Path(item.path).is_file():
            raise UsageError(f"a worker does not see {self.store.folder} or {item.path}; share the folders with it")
        if self.store.get(item.key) is None:
            try:
                self.store.put(item.key, answer(self.question, item))
            except Changed as error:
                return str(error)
            except OSError as error:
                raise UsageError(f"{self.store.folder}: {error.strerror or error}") from None
        return None


def _make(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / "probe", "").unlink()
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written to ({error.strerror}); name another folder by --out") from None
    return folder


def _stopped(why: str, finished: int) -> UsageError:
    return UsageError(
        f"{why}. The {finished} records that are finished are kept: fix that, then give the same command again"
    )


def _conclude(
    asked: WorkList, question: BatchRequest, store: Store, lost: dict[str, str], out: Path, command: str
) -> None:
    from .page import batch_page

    try:
        store.sweep()
        found = table(asked, question, store, lost)
        write_whole(out / TABLE, found)
        write_whole(out / TEXT, as_csv(found))
        write_whole(out / PAGE, batch_page(out / TABLE, command))
    except OSError as error:
        raise _stopped(f"{error.filename or out}: {error.strerror or error}", len(asked.items) - len(lost)) from None
