"""Interactive figures as parts of a page or of a notebook: packed data, Bokeh's script, and what puts them up."""

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
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
    """Figures by the ids of the elements that they stand in, for a page that is one file."""
    bokeh, packed = _bokeh()
    script = _script("page.js", NAMES=json.dumps(list(figures)))
    data = _document(list(figures.values()))
    return Inline(script, {"live-bokeh": packed, "live-figures": data}, (_hash(script), _hash(bokeh)))


def cell(figure: LayoutDOM, name: str, with_bokeh: bool) -> tuple[str, str]:
    """Style and JavaScript of a figure in the element `name` of a notebook; one of its cells must come `with_bokeh`."""
    bokeh = _bokeh()[1] if with_bokeh else None
    words = {"BOKEH": bokeh, "DATA": _document([figure]), "NAME": name}
    script = _script("cell.js", **{word: json.dumps(value) for word, value in words.items()})
    return (files("pam_ident.live") / "cell.css").read_text(encoding="utf-8"), script


def _document(figures: Sequence[LayoutDOM]) -> str:
    document = Document()
    for one in figures:
        document.add_root(one)
    drawn = {**document.to_json(deferred=False), "defs": []}  # of what else is loaded, as the workbench's Panel
    known: dict[str, int] = {}  # Bokeh goes on counting from figures drawn before; a page is to be the same again
    text = json.dumps(drawn, separators=(",", ":"))
    return _packed(re.sub(r'"id":"([^"]+)"', lambda found: f'"id":"p{known.setdefault(found[1], len(known))}"', text))


@cache
def _bokeh() -> tuple[str, str]:
    """Bokeh's script without widgets and tables, as it is and packed."""
    script = Resources(mode="inline", components=["bokeh"]).js_raw[0]
    return script, _packed(script)


def _script(name: str, **words: str) -> str:
    """A script of this folder, what it shares put in, and `words` where __WORD__ stands, which no base64 holds."""
    moves = ", ".join(f"{json.dumps(name)}: (r, top, bottom) => {{ {code} }}" for name, code in ZOOM.items())
    text = (files("pam_ident.live") / name).read_text(encoding="utf-8")
    shared = (files("pam_ident.live") / "figures.js").read_text(encoding="utf-8")
    for word, put in {"FIGURES": shared, "MOVES": f"{{ {moves} }}", "THEME": THEME, **words}.items():
        text = text.replace(f"__{word}__", put)
    return text


def _packed(text: str) -> str:
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()


def _hash(script: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"
