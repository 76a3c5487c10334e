"""Print the way of one `pam-ident diagnose FILE` through the rooms of the package: the first call into each.

python docs/make_map.py           print it
python docs/make_map.py --write   write it into docs/object-model.md
"""

import contextlib
import io
import re
import sys
from collections.abc import Iterator
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import FrameType
from typing import Any

ROOT = Path(__file__).parents[1]


def room(frame: FrameType | None) -> str | None:
    """The room of the package that a frame is in, None outside of it."""
    parts = str(frame.f_globals.get("__name__", "")).split(".") if frame else [""]
    return parts[1] if parts[0] == "pam_ident" and len(parts) > 1 else None


def callers(frame: FrameType) -> Iterator[FrameType]:
    """The frames that called a frame, the nearest first."""
    one = frame.f_back
    while one is not None:
        yield one
        one = one.f_back


def hops(arguments: list[str]) -> list[str]:
    """A line for each first call into a room: what was called, and from where."""
    from pam_ident.cli import main

    entered: dict[str, str] = {}

    def follow(frame: FrameType, event: str, _: Any) -> None:
        here = room(frame) if event == "call" else None
        name = frame.f_code.co_qualname
        if here is None or here in entered or "<" in name or not frame.f_code.co_flags & CO_OPTIMIZED:
            return
        above = list(callers(frame))
        if any(one.f_code.co_name == "<module>" and room(one) for one in above):
            return  # what a module declares as it is imported is no step of the way
        caller = next((one for one in above if room(one)), None)
        module = str(frame.f_globals["__name__"]).removeprefix("pam_ident.")
        entered[here] = f"{room(caller) or 'shell'} → {module}.{name}"

    before, sys.argv = sys.argv, ["pam-ident", *arguments]
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
            sys.setprofile(follow)
            main()
    finally:
        sys.setprofile(None)
        sys.argv = before
    return [f"{k:2d}  {line}" for k, line in enumerate(entered.values(), 1)]


def with_hops(page: str, lines: list[str]) -> str:
    """The page with these lines between its marks."""
    block = "<!-- hops -->\n```\n" + "\n".join(lines) + "\n```\n<!-- /hops -->"
    return re.sub(r"<!-- hops -->.*<!-- /hops -->", lambda _: block, page, flags=re.S)


if __name__ == "__main__":
    record = ROOT / "datasets" / "hidden_effect" / "record.csv"
    found = hops(["diagnose", str(record), "--law", "exponential_law"])
    print("\n".join(found))
    if "--write" in sys.argv:
        page = ROOT / "docs" / "object-model.md"
        page.write_text(with_hops(page.read_text(encoding="utf-8"), found), encoding="utf-8")
