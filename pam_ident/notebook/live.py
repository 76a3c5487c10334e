"""Pictures of a cell as figures to zoom and to point at, where a kernel of Jupyter asks and Bokeh is there.

The first such cell of a kernel brings Bokeh for all. Where scripts do not run, the pictures stand.
"""

import sys
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from ..live import available

if TYPE_CHECKING:
    from bokeh.models import Column

SAMPLES = 1500
"""Of a record, in figures to zoom into."""
CELL = """<figure class="pam-figure"><div class="switches"><span></span></div><div class="drawing">{}</div>
<div class="panels" id="{}" aria-hidden="true"></div></figure><style>{}</style><script>{}</script>"""
_brought: tuple[str | None, int] | None = None


def samples() -> int:
    """How many samples a record's figures have here; 0 where nothing would bring them to life."""
    return SAMPLES if _kernel() is not None and available() else 0


def standing(picture: Markup, name: str, figure: "Column") -> Markup:
    """A picture with the figure that takes its place, in the element `name`."""
    from ..live.page import cell

    style, script = cell(figure, name, _brings_bokeh())
    return Markup(CELL).format(picture, name, Markup(style), Markup(script))


def _kernel() -> Any:
    """IPython's shell, if a notebook is at its other end."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return shell if hasattr(shell, "kernel") else None


def _brings_bokeh() -> bool:
    """Whether this cell must: the first of a kernel, and that one each time it is run again."""
    global _brought
    shell = _kernel()
    here, run = shell.get_parent().get("metadata", {}).get("cellId"), shell.execution_count
    if _brought is None or (here is not None and here == _brought[0] and run != _brought[1]):
        _brought = here, run
        return True
    return False
