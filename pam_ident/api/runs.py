"""Many muscles at once, and muscles in a leg: their verbs and results."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core import UsageError
from ..core.digits import three
from ..core.nearest import unknown
from ..parallel.executor import Executor
from ..schema.track import track_json
from ..schema.trials import batch_json
from ..tasks.law_choice import AUTO
from .answers import RecordAnswer, ShownAnswer
from .asking import setup_of
from .fitted import FitResult
from .record import axes_of
from .working import worked

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from ..batch.run import Batch
    from ..leg.track import Track


class TrackResult(ShownAnswer):
    """A fitted model in the leg's closed loop. `pam.track` makes it: `controllers` is its table."""

    def __init__(self, details: "Track") -> None:
        self.details = details

    def _content(self) -> dict[str, Any]:
        return track_json(self.details)

    @property
    def controllers(self) -> "pd.DataFrame":
        """A row a controller, with its rms and peak error in degrees."""
        from ..export.frames import controllers

        return controllers(self.details)

    def summary(self) -> str:
        """The sentence and the controllers, as text."""
        return "\n\n".join([repr(self), self.controllers.to_string(float_format=three)])

    def plot(self) -> "Axes":
        """Angles wanted and reached, and the error of each controller."""
        from ..plot import tracking

        return axes_of(tracking.draw, self.details)


class BatchResult(ShownAnswer):
    """Many muscles fitted alike. `pam.batch` makes it: `params` is the table, `errors` what went wrong."""

    def __init__(self, details: "Batch") -> None:
        self.details, self.law_choice = details, details.law_choice

    @property
    def sentence(self) -> str:
        """How many records, and where the results are."""
        return f"{self.details.records} records, {len(self.errors)} with an error; {self.page}"

    def _repr_html_(self) -> str:
        return self.params.to_html(max_rows=12)

    def _content(self) -> dict[str, Any]:
        return batch_json(self.details)

    @property
    def params(self) -> "pd.DataFrame":
        """A row a record and branch: parameters with errors, error in N, verdict."""
        from ..batch.table import read_results

        return read_results(self.details.folder)

    @property
    def errors(self) -> dict[str, str]:
        """What went wrong, by record."""
        return self.details.errors

    @property
    def page(self) -> Path:
        """The page that compares the muscles."""
        return self.details.page

    def summary(self) -> str:
        """The sentence and the error of each record, as text."""
        return "\n\n".join([repr(self), self.params[["record", "branch", "rmse_N"]].to_string(index=False)])


@worked
def batch(
    folder: str | Path,
    law: str = AUTO,
    effects: Any = (),
    *,
    out: str | Path,
    branch: str = "together",
    diagnose: bool = False,
    assume: Any = (),
    workers: int | None = None,
    free_geometry: bool = False,
) -> BatchResult:
    """Fit many muscles alike: a table and a page, resumed where it stopped.

    Args:
        folder: the tree of records, a `specimen.toml` beside or above each.
        law, effects: by name, for other processes look them up; without a law one is chosen on the first records.
        out: folder of the results.
        branch, diagnose, free_geometry: what is fitted, and whether to name what each model lacks, too.
        assume: as `pam.diagnose` takes it.
        workers: processes at a time; by default the cores.

    Raises:
        UsageError: for what cannot be asked, and where the results cannot be written.

    Example:
        >>> import pam_ident as pam
        >>> from pam_ident.records.datasets import dataset_path
        >>> print(len(pam.batch(dataset_path("dmsp20_300"), "polynomial", out="results", workers=1).params), "row")
        1 row
    """
    from ..batch.run import run_batch
    from ..tasks.setup import Setup

    asked = setup_of(law, effects, free_geometry=free_geometry, assume=assume)
    if asked.objects:
        raise UsageError("a batch takes effects by name, for other processes look them up")
    plain = Setup(asked.law, asked.effects, free_geometry=free_geometry, assume=asked.assume)
    executor = Executor.of_cores(workers, None)
    return BatchResult(run_batch(folder, plain, out, branch=branch, diagnose=diagnose, executor=executor))


@worked
def track(plant: Any = None, controller: Any = None, **options: Any) -> TrackResult:
    """A fitted model in the closed loop of a leg: how far the knee is off its gait, and why.

    Args:
        plant: file of the muscle in the leg, or a fit or ladder; without both, the bundled ones.
        controller: the same of what the feed-forward knows.
        options: gait, cadence_Hz, paper, prototype, gains, supply_MPa, load_kg; leg, off, ageing, unknown, ground,
            learn.

    Raises:
        UsageError, DataError: for what cannot be run.

    Example:
        >>> import pam_ident as pam
        >>> pam.track(gait="winther")
        Traceback (most recent call last):
        pam_ident.core.errors.UsageError: gait='winther': expected winter, children or a CSV file with a column knee_deg
    """
    from dataclasses import fields
    from tempfile import TemporaryDirectory

    from ..tasks.track import TrackOptions, track_leg

    known = [f.name for f in fields(TrackOptions) if f.name not in ("plant", "controller")]
    for name in options:
        if name not in known:
            raise UsageError(f"pam.track: {unknown('argument', name, ['plant', 'controller', *known])}")
    with TemporaryDirectory() as folder:
        files = []
        for name, given in (("plant", plant), ("controller", controller)):
            if isinstance(given, FitResult | RecordAnswer):
                path = str(Path(folder, f"{name}.json"))
                given.to_json(path)
                given = path
            elif given is not None and not (isinstance(given, str | Path) and Path(given).is_file()):
                raise UsageError(
                    f"{name}={given!r}: expected what pam.fit or pam.ladder gave, or a file that its to_json wrote"
                )
            files.append(None if given is None else str(given))
        return TrackResult(track_leg(TrackOptions(*files, **options)))
