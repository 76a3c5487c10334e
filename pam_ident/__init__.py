"""Find out how a pneumatic artificial muscle really behaves.

Compare a force model with an isobaric test-rig record, see where it fails, learn which physical
effect is missing, add it and watch the error fall.

    import pam_ident as pam

    record = pam.read("run.csv")
    pam.diagnose(record, "exponential_law")
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api.catalogue import effects, laws
    from .api.model import ShownModel as Model
    from .api.record import ShownRecord as Record
    from .api.record import read
    from .api.runs import batch, track
    from .api.saved import load
    from .api.verbs import compare, diagnose, fit, ladder, report
    from .core.errors import DataError, FitError, PamError, UsageError

__version__ = "0.1.0"

_HOME = {
    "read": "pam_ident.api.record.read",
    "fit": "pam_ident.api.verbs.fit",
    "compare": "pam_ident.api.verbs.compare",
    "diagnose": "pam_ident.api.verbs.diagnose",
    "ladder": "pam_ident.api.verbs.ladder",
    "report": "pam_ident.api.verbs.report",
    "batch": "pam_ident.api.runs.batch",
    "track": "pam_ident.api.runs.track",
    "load": "pam_ident.api.saved.load",
    "Record": "pam_ident.api.record.ShownRecord",
    "Model": "pam_ident.api.model.ShownModel",
    "laws": "pam_ident.api.catalogue.laws",
    "effects": "pam_ident.api.catalogue.effects",
    **{name: f"pam_ident.core.errors.{name}" for name in ("DataError", "FitError", "PamError", "UsageError")},
}
_OLD = {
    "Specimen": ("pam_ident.core.Specimen", "a dictionary as specimen="),
    "read_record": ("pam_ident.records.read_record", "pam.read"),
    "record_from_frame": ("pam_ident.records.record_from_frame", "pam.read"),
    "climb": ("pam_ident.diagnosis.climb", "pam.ladder"),
    "to_frame": ("pam_ident.export.frames.to_frame", "a result's params, residuals or to_frame()"),
    "latex": ("pam_ident.export.equation.latex", "pam_ident.export.equation.latex"),
}
"""Names that go in the next version: where each is, and what stands in its place."""
_INSTEAD = {
    "add": "pam.fit(record, law, effects=[...])",
    "against": "pam.diagnose(a).against(b)",
    "inspect": "pam.read(record).summary()",
    "predict": 'pam.fit(...).predict(pressure, contraction), or pam.load("fit.json").predict(...)',
    "validate": 'pam.fit(...).validate(record), or pam.load("fit.json").validate(record)',
}
"""Commands that are something else here."""

__all__ = [
    "DataError",
    "FitError",
    "Model",
    "PamError",
    "Record",
    "UsageError",
    "batch",
    "compare",
    "diagnose",
    "effects",
    "fit",
    "ladder",
    "laws",
    "load",
    "read",
    "report",
    "track",
]


def __getattr__(name: str) -> Any:
    """Import on first use: `pam-ident --help` must not pay for numpy."""
    if name in _HOME:
        home, _, found = _HOME[name].rpartition(".")
        return getattr(import_module(home), found)
    if name in _OLD:
        import warnings

        path, instead = _OLD[name]
        message = (
            f"pam_ident.{name} goes in the next version; take {instead}, or import it from {path.rpartition('.')[0]}"
        )
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        home, _, found = path.rpartition(".")
        return getattr(import_module(home), found)
    if name in _INSTEAD:
        raise AttributeError(f"module 'pam_ident' has no attribute {name!r}; use {_INSTEAD[name]}")
    if name.startswith("_"):
        raise AttributeError(f"module 'pam_ident' has no attribute {name!r}")
    from .core.nearest import no_attribute

    raise AttributeError(no_attribute("module 'pam_ident'", name, dict.fromkeys(__all__, "")))


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__") and name.endswith("__"))]


class _Root(ModuleType):
    """Keeps `report`, `batch`, `laws` and `effects` what they are where the subpackages of these names are imported."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Root


def load_ipython_extension(shell: Any) -> None:
    """Show results at the end of a cell; `%load_ext pam_ident` does, where it was imported before IPython."""
    import_module("pam_ident.notebook").register(shell.display_formatter)


if "IPython" in sys.modules and (_shell := sys.modules["IPython"].get_ipython()) is not None:
    load_ipython_extension(_shell)
