"""Several records fitted together, as one meets them at the prompt."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.digits import newtons
from ..core.files import check_target, write_json_lines
from ..schema.fit import shared_json
from ..tasks.fit import FitAnswer
from .asking import ObjectSetup
from .fitted import FitResult, told
from .hints import Hinting

if TYPE_CHECKING:
    import pandas as pd


class SharedFitResult(Hinting):
    """A fit to several records at once. `pam.fit(records, law, shared=[...])` makes it.

    `muscles` are the fits of each record, in order; `shared` names the parameters that have one value for all.
    """

    def __init__(self, answers: Sequence[FitAnswer], setup: ObjectSetup) -> None:
        self.muscles = tuple(FitResult(answer, setup) for answer in answers)
        self.shared = next(iter(answers[0].fits.values())).shared

    @property
    def rmse(self) -> float:
        """Root mean square of the residual over all records in N."""
        return (sum(one.n * one.rmse**2 for one in self.muscles) / sum(one.n for one in self.muscles)) ** 0.5

    @property
    def valid(self) -> bool:
        """Converged, and every parameter identified."""
        return not self.problems

    @property
    def problems(self) -> list[str]:
        """Why the fit is not valid, record by record; empty when it is."""
        return [f"{one.record.name}: {problem}" for one in self.muscles for problem in one.problems]

    @property
    def params(self) -> "pd.DataFrame":
        """A row a parameter of a record, as `FitResult.params` has it, and once, as `all`, of what is shared."""
        import pandas as pd

        def level(frame: "pd.DataFrame") -> Any:
            return frame.index.get_level_values("parameter").isin(self.shared)

        frames = [one.params for one in self.muscles]
        own = [frame.loc[~level(frame), :] for frame in frames]
        names = ["all", *(one.record.name for one in self.muscles)]
        return pd.concat([frames[0].loc[level(frames[0]), :], *own], keys=_told_apart(names), names=["record"])

    def summary(self) -> str:
        """How well each record is fitted, and the parameters, as text."""
        return "\n".join([str(self.muscles[0].model), repr(self), told(self.params)])

    def __repr__(self) -> str:
        said = ", ".join(self.shared) or "nothing"
        head = f"{len(self.muscles)} records share {said}: {newtons(self.rmse)} rms"
        return "\n".join([head, *map(repr, self.muscles)])

    def _repr_html_(self) -> str:
        return "".join(one._repr_html_() for one in self.muscles)

    def to_json(self, path: str | Path | None = None) -> list[dict[str, Any]]:
        """The answers of `pam-ident fit --json`, one a record, saved line by line to `path` where one is given."""
        names = [one.record.source or one.record.name for one in self.muscles]
        found = [one.to_json() | shared_json(names, one.details) for one in self.muscles]
        if path is not None:
            write_json_lines(check_target(path), found)
        return found


def _told_apart(names: list[str]) -> list[str]:
    """Names, with a number behind those that occur twice."""
    return [f"{name} ({names[:k].count(name) + 1})" if names.count(name) > 1 else name for k, name in enumerate(names)]
