"""Two records beside each other, as one meets them at the prompt."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.digits import three
from ..core.files import check_target, write_whole
from ..diagnosis.against import Against
from ..report.against import parts
from ..schema.against import against_json
from ..tasks.against import against_page
from .answers import ShownAnswer
from .record import axes_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


class AgainstResult(ShownAnswer):
    """Record A against record B. `DiagnosisResult.against` makes it."""

    details: Against

    def __init__(self, details: Against, sources: tuple[str, str]) -> None:
        self.details, self._sources = details, sources

    @property
    def sentence(self) -> str:
        """The answer in a sentence."""
        return self.details.sentence

    @property
    def params(self) -> "pd.DataFrame":
        """A row a parameter: in A, in B, and the difference with its 95 % interval."""
        import pandas as pd

        frame = pd.DataFrame([vars(one) | {"differs": one.differs} for one in self.details.parameters])
        return frame.set_index("name") if len(frame) else frame

    @property
    def effects(self) -> "pd.DataFrame":
        """A row an effect that is missing in either: its probability in each, and where it is named."""
        import pandas as pd

        rows = [vars(one) for one in self.details.effects]
        return pd.DataFrame(rows, columns=["effect", "a", "b", "where"]).set_index("effect")

    @property
    def follows(self) -> "pd.DataFrame":
        """What the law's error follows in each, in shares of its square."""
        import pandas as pd

        shares = [pd.Series({x.what: x.share for x in one.follows}) for one in (self.details.a, self.details.b)]
        return pd.DataFrame({"a": shares[0], "b": shares[1]}).fillna(0.0)

    def summary(self) -> str:
        """The sentence, the parameters, the effects and what the errors follow, as text."""
        frames = (self.params.drop(columns=["p"], errors="ignore"), self.effects, self.follows)
        shown = [frame.to_string(float_format=three) for frame in frames if len(frame)]
        return "\n\n".join([repr(self), *shown])

    def plot(self) -> "Axes":
        """What B's error follows beside A's is on the page; this is B's bar."""
        from ..plot import follows

        return axes_of(follows.draw, self.details.b.follows)

    def report(self, path: str | Path = "against.html") -> Path:
        """Write the page about both."""
        a, b = self.details.a.base.record, self.details.b.base.record
        page = against_page(self.details, dict(zip(self._sources, (a, b), strict=True)), "")
        write_whole(check_target(path, (".html",)), page)
        return Path(path)

    def _content(self) -> dict[str, Any]:
        return against_json(*self._sources, self.details, self.warnings)

    def _repr_html_(self) -> str:
        from markupsafe import Markup

        from ..notebook.live import samples
        from ..notebook.pages import picture, table

        made = [Markup("<p>{}</p>").format(self.sentence)]
        for part in parts(self.details, samples()):
            made += [picture(one.figure, one.label, live=one.live) for one in part.pictures] + [
                table(one) for one in part.tables
            ]
        return str(Markup("").join(made))
