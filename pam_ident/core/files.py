"""Files are written whole or not at all, and TOML is read."""

import json
import math
import os
import sys
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from tempfile import mkstemp
from typing import Any

from .errors import DataError, PamError, UsageError

_measured: set[Path] = set()


def spare(path: str | Path) -> None:
    """Note a file that holds measurements: nothing is written in its place in this process."""
    _measured.add(Path(path).resolve())


def check_target(path: str | Path, suffixes: tuple[str, ...] = ()) -> Path:
    """`path` as a Path, refused before any work is done where it cannot become a file with one of `suffixes`.

    Raises UsageError.
    """
    if str(path).endswith(("/", os.sep)):
        raise UsageError(f"{path}: is the name of a folder; expected the name of a file to write")
    path = Path(path)
    if suffixes and path.suffix.lower() not in suffixes:
        raise UsageError(f"{path}: expected a file name ending in {' or '.join(suffixes)}")
    if path.is_dir():
        raise UsageError(f"{path}: is a folder; expected the name of a file to write")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: there is no folder {path.parent}; make it, or name another file")
    if not os.access(path.parent, os.W_OK):
        raise UsageError(f"{path}: the folder {path.parent} cannot be written to; name another file")
    return path


def read_toml(path: str | Path, absent: str = "", wrong: type[PamError] = DataError) -> dict[str, Any]:
    """The content of a TOML file. Raises `wrong`, DataError by default, where it cannot be read, saying `absent` where
    it is not there."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        if absent and isinstance(error, FileNotFoundError):
            raise wrong(f"{path}: {absent}") from None
        if isinstance(error, IsADirectoryError):
            raise wrong(f"{path}: is a folder; expected a TOML file") from None
        raise wrong(f"{path}: not a readable TOML file ({error})") from None


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write `content` beside `path` and move it there, so that no reader ever sees half a file.

    Raises UsageError where measurements were read from `path`.
    """
    path = Path(path)
    if path.resolve() in _measured:
        raise UsageError(f"{path}: holds what was measured, and is not written over; name another file")
    data = content.encode("utf-8") if isinstance(content, str) else content
    handle, temporary = mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
    return path


def write_json(path: str | Path, answer: Mapping[str, Any]) -> None:
    """One answer as indented JSON; what is no number is null. The path `-` is stdout."""
    _write(path, [answer], 2)


def write_json_lines(path: str | Path, answers: Iterable[Mapping[str, Any]]) -> None:
    """Several answers, one object a line. The path `-` is stdout."""
    _write(path, answers, None)


def _write(path: str | Path, answers: Iterable[Mapping[str, Any]], indent: int | None) -> None:
    plain = (blank_nan(dict(answer)) for answer in answers)
    content = "".join(json.dumps(one, indent=indent, ensure_ascii=False, allow_nan=False) + "\n" for one in plain)
    if str(path) == "-":
        sys.stdout.write(content)
    else:
        write_whole(path, content)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def blank_nan(value: Any) -> Any:
    """`value` with every NaN and infinity replaced by None and numpy scalars by Python's, all the way down."""
    if isinstance(value, dict):
        return {str(key): blank_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [blank_nan(item) for item in value]
    if hasattr(value, "tolist"):
        return blank_nan(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
