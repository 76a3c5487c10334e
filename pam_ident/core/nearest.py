"""What is said of a name that nobody knows: the names that look like it, and where all of them are listed."""

import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches

from .prose import capital

SHORT = 12
"""Most names that are told in full where none is like the one given."""


def nearest(name: str, known: Iterable[str]) -> list[str]:
    """At most three of the `known` names that look like `name`, the likest first."""
    by_lower = {one.lower(): one for one in known}
    plain = str(name).lower().replace("-", "_").replace(" ", "_")
    found = get_close_matches(plain, by_lower, n=3, cutoff=0.6)
    begin = [one for one in by_lower if len(plain) > 2 and (one.startswith(plain) or plain in one.split("_"))]
    return [by_lower[one] for one in dict.fromkeys([*found, *begin])][:3]


def unknown(what: str, name: object, known: Iterable[str], where: str = "") -> str:
    """The message of an unknown name: what it may have meant, else what there is; `where` lists all, else this does."""
    names = sorted(known)
    near = nearest(str(name), names)
    head = f"unknown {what} {str(name)!r}"
    there, listed = f"there is {', '.join(names)}", f"{where} lists all {len(names)}"
    if near:
        return f"{head}; did you mean {' or '.join(near)}? {listed if where else capital(there)}"
    return f"{head}; {listed if where and len(names) > SHORT else there}"


def no_attribute(what: str, name: str, known: Mapping[str, str], meant: Iterable[str] = ()) -> str:
    """The message of an attribute that `what` lacks: what is surely `meant`, else the `known` ones, by name with what
    is said of each, that may be, else all of them."""
    near = list(meant) or nearest(name, known)
    if not near and len(name) < 3:
        near = [one for one in known if one.startswith(name)]
    if not near:
        near = [one for one, said in known.items() if re.search(rf"\b{re.escape(name)}", said)]
    hint = f"did you mean {' or '.join(near[:3])}?" if near else f"it offers {', '.join(known)}"
    return f"{what} has no attribute {name!r}; {hint}"
