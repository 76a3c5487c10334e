"""The workbench: compare a model with a record, see the candidates, add one, watch the error fall, take it out again.

A page for the browser (`serve`), which shows itself in a Jupyter notebook, too (`Workbench`). Needs the extra
`workbench`.
"""

from importlib import import_module
from typing import Any

_HOME = {"Bench": ".bench", "Workbench": ".page", "serve": ".server"}

__all__ = ["Bench", "Workbench", "serve"]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    """Import on first use: what is tried on the bench needs no web server."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name], __name__), name)
