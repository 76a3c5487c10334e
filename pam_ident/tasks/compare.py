"""Where a model fails on a record."""

from ..diagnosis.compare import compare
from ..diagnosis.nouns import Comparison
from ..fitting import fit
from ..records import Record
from .gate import admit, computing, require_rows
from .setup import Setup


def compare_record(record: Record, setup: Setup) -> Comparison:
    """Fit `setup.model` to both branches together and split the error by place. Raises FitError or DataError."""
    admit(record)
    require_rows(record)
    with computing(record):
        return compare(fit(setup.model, record))


def failure_picture(comparison: Comparison, suffix: str) -> str | bytes:
    """The failure map as the text of an SVG file, or the bytes of a PNG file for `.png`."""
    from ..plot import failure_map, to_png, to_svg

    figure = failure_map.draw(comparison)
    return to_png(figure) if suffix.lower() == ".png" else to_svg(figure)
