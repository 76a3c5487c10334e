"""Find out how a pneumatic artificial muscle really behaves.

Compare a force model with an isobaric test-rig record, see where it fails, learn which physical
effect is missing, add it and watch the error fall.
"""

import sys
from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Specimen": "pam_ident.core",
    "Record": "pam_ident.records",
    "read_record": "pam_ident.records",
    "record_from_frame": "pam_ident.records",
    "laws": "pam_ident.laws",
    "effects": "pam_ident.effects",
    "Model": "pam_ident.model",
    "fit": "pam_ident.fitting",
    "compare": "pam_ident.diagnosis",
    "diagnose": "pam_ident.diagnosis",
    "climb": "pam_ident.diagnosis",
    "to_frame": "pam_ident.export.frames",
    "latex": "pam_ident.export.equation",
}

_COMPUTE = ("fit", "compare", "diagnose", "climb")

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    """Import on first use: `pam-ident --help` must not pay for numpy."""
    if name not in _HOME:
        raise AttributeError(f"module 'pam_ident' has no attribute {name!r}")
    home = import_module(_HOME[name])
    found = home if home.__name__ == f"pam_ident.{name}" else getattr(home, name)
    if name in _COMPUTE:
        found = globals()[name] = import_module("pam_ident.core.threads").one_blas_thread()(found)
    return found


def load_ipython_extension(shell: Any) -> None:
    """Show results at the end of a cell; `%load_ext pam_ident` does, where it was imported before IPython."""
    import_module("pam_ident.notebook").register(shell.display_formatter)


if "IPython" in sys.modules and (_shell := sys.modules["IPython"].get_ipython()) is not None:
    load_ipython_extension(_shell)
