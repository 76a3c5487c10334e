"""Interactive figures as parts of a page that is one file: packed data, Bokeh's script, and what puts them up."""

import base64
import gzip
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from bokeh.document import Document
from bokeh.models import LayoutDOM
from bokeh.resources import Resources

from .panels import THEME, ZOOM


@dataclass(frozen=True)
class Inline:
    """What goes into a page: `script` as JavaScript, and `packed` texts, gzip in base64, by the ids they are looked
    for; `hashes` are of all that may run, for the page's policy."""

    script: str
    packed: Mapping[str, str]
    hashes: tuple[str, ...]


def inline(figures: Mapping[str, LayoutDOM]) -> Inline:
    """Figures by the ids of the elements that they stand in."""
    document = Document()
    for one in figures.values():
        document.add_root(one)
    roots = {one.id: name for name, one in figures.items()}
    data = json.dumps({"document": document.to_json(deferred=False), "roots": roots}, separators=(",", ":"))
    bokeh, packed = _bokeh()
    script = _script()
    return Inline(script, {"live-bokeh": packed, "live-figures": _packed(data)}, (_hash(script), _hash(bokeh)))


@cache
def _bokeh() -> tuple[str, str]:
    """Bokeh's script without widgets and tables, as it is and packed."""
    script = Resources(mode="inline", components=["bokeh"]).js_raw[0]
    return script, _packed(script)


@cache
def _script() -> str:
    moves = ", ".join(f"{json.dumps(name)}: (r, top, bottom) => {{ {code} }}" for name, code in ZOOM.items())
    text = (files("pam_ident.live") / "page.js").read_text(encoding="utf-8")
    return text.replace("MOVES", f"{{ {moves} }}").replace("THEME", THEME)


def _packed(text: str) -> str:
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()


def _hash(script: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"
