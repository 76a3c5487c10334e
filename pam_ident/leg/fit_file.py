"""A fitted model, read back from what `pam-ident fit --json`, `ladder --json` or `add --json` wrote."""

import json
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..core import DataError, Param, Specimen, UsageError
from ..effects import Effect
from ..model import Model, Values
from ..schema.versions import VERSIONS, schema

T = TypeVar("T")
Array = np.ndarray
FITTED = ("fit", "ladder", "add")
"""The answers that hold a fitted model."""
GEOMETRY = tuple(f.name for f in fields(Specimen) if f.name != "sensors")
ADDED = {"presliding_hysteresis.z_0": 0.0, "nonlocal_hysteresis.z_0": 0.0}
"""Parameters that files of earlier versions lack, with the values that these took for granted."""


@dataclass(frozen=True, eq=False)
class ParameterSpread:
    """Covariance of some parameters, `matrix` (k, k) in the order of `names`; the others are taken as known."""

    names: tuple[str, ...]
    matrix: Array

    def given(self, held: Sequence[str]) -> "ParameterSpread":
        """What is left where some of the parameters are known: a conditional normal distribution."""
        known = np.array([name in held for name in self.names])
        free, cross = self.matrix[np.ix_(~known, ~known)], self.matrix[np.ix_(~known, known)]
        left = free - cross @ np.linalg.pinv(self.matrix[np.ix_(known, known)]) @ cross.T
        return ParameterSpread(tuple(name for name in self.names if name not in held), left)

    def draws(self, values: Values, params: Sequence[Param], normal: Array) -> dict[str, Array]:
        """Parameter sets by name, (draws,) each, kept within the bounds; `normal` (draws, k) are standard normal."""
        size, axes = np.linalg.eigh(self.matrix)
        moved = normal @ (axes * np.sqrt(np.maximum(size, 0.0))).T
        found = {p.name: np.full(len(normal), float(values[p.name])) for p in params}
        bounds = {p.name: (p.lower, p.upper) for p in params}
        for k, name in enumerate(self.names):
            found[name] = np.clip(found[name] + moved[:, k], *bounds[name])
        return found


Fitted = tuple[dict[str, float], ParameterSpread | None]
"""Values of the parameters by name, and their covariance."""


@dataclass(frozen=True)
class Answer:
    """What a file holds, as far as it is needed here; `path` is told where something is wrong."""

    path: Path
    content: Mapping[str, Any]

    def get(self, key: str, kind: type[T], where: Mapping[str, Any] | None = None) -> T:
        """A field of the file, or of the object `where`. Raises DataError where it is missing or of another kind."""
        holder = self.content if where is None else where
        value = holder.get(key) if isinstance(holder, Mapping) else None
        if not isinstance(value, kind):
            raise DataError(f"{self.path}: {key!r} is missing or no {kind.__name__}; write the file again with --json")
        return value

    @property
    def stages(self) -> list[tuple[tuple[str, ...], dict[str, Mapping[str, Any]]]]:
        """Labels of the effects, and by branch what holds parameters: of a ladder a rung each, of others the
        one. Raises DataError where there is none."""
        if "rungs" in self.content:
            given: list[Any] = [(one, {"together": one}) for one in self.get("rungs", list)]
        elif "after" in self.content:
            given = [(self.content, {"together": {**self.content, **self.get("after", dict)}})]
        else:
            given = [(self.content, self.get("branches", dict))]
        if not given or not given[-1][1]:
            raise DataError(f"{self.path}: holds no branch and no rung; write the file again with --json")
        return [(tuple(self.get("effects", list, one)), holders) for one, holders in given]

    @property
    def seen(self) -> dict[str, list[float]]:
        """Ranges that the record covered; none in files of earlier versions. Raises DataError for what is no range."""
        given = self.content.get("range") or {}
        for key, ends in given.items() if isinstance(given, dict) else [("range", given)]:
            if not (isinstance(ends, list) and len(ends) == 2 and all(isinstance(x, int | float) for x in ends)):
                raise DataError(f"{self.path}: range of {key} is {ends!r}; write the file again with --json")
        return given

    def values(self, holder: Mapping[str, Any]) -> dict[str, float]:
        """Parameter values by name of a branch or a rung. Raises DataError for what is no number."""
        found = {}
        for name, one in self.get("parameters", dict, holder).items():
            value = one.get("value") if isinstance(one, dict) else None
            if not isinstance(value, (int, float)):
                raise DataError(f"{self.path}: parameter {name} has the value {value}; expected a number")
            found[name] = float(value)
        effects = {name.partition(".")[0] for name in found}
        return {name: value for name, value in ADDED.items() if name.partition(".")[0] in effects} | found

    def spread(self, holder: Mapping[str, Any]) -> ParameterSpread | None:
        """Covariance of a branch or a rung; None where the file holds none. Raises DataError for one of wrong shape."""
        if holder.get("covariance") is None:
            return None
        table = self.get("covariance", dict, holder)
        names = tuple(self.get("names", list, table))
        try:
            matrix = np.array(self.get("matrix", list, table), float).reshape(len(names), len(names))
        except (TypeError, ValueError):
            raise DataError(f"{self.path}: the covariance of {len(names)} parameters is no square of numbers") from None
        return ParameterSpread(names, matrix)

    def fitted(self, holder: Mapping[str, Any]) -> Fitted:
        """Parameter values and their covariance of a branch or a rung."""
        return self.values(holder), self.spread(holder)

    def model(self, effects: tuple[str, ...], extra: tuple[Effect, ...]) -> Model:
        """The law with effects. Raises UsageError for what is not known."""
        try:
            return Model.build(self.get("law", str), effects, extra, bool(self.content.get("free_geometry")))
        except UsageError as error:
            own = "; one of your own comes by --effect-file FILE.py" if "unknown effect" in str(error) else ""
            raise UsageError(f"{self.path}: {error}{own}") from None


def read_answer(path: str | Path) -> Answer:
    """A file that holds a fitted model. Raises DataError for any other; for a diagnosis, which holds no parameters, it
    says how the model that it names is fitted."""
    path = Path(path)
    commands = [f"`pam-ident {kind} RECORD --law LAW{' --effect NAME' * (kind == 'add')} --json F`" for kind in FITTED]
    hint = f"expected a file of {' or '.join(commands)}"
    content, found = what_is_written(path, hint)
    if found.startswith("pam-ident/diagnosis/"):
        raise DataError(
            f"{path}: has the schema {found}, which holds no parameters; to fit what it names: {_fit_of(content)}"
        )
    for kind in FITTED:
        version = re.fullmatch(rf"pam-ident/{kind}/(\d+)", found)
        if version and int(version[1]) > VERSIONS[kind]:
            raise DataError(f"{path}: has the schema {found}, of a newer pam-ident; update pam-ident, or fit again")
    if found not in [schema(kind) for kind in FITTED]:
        raise DataError(f"{path}: has {f'the schema {found}' if found else 'no schema'}; {hint}")
    return Answer(path, content)


def what_is_written(path: Path, expected: str) -> tuple[Any, str]:
    """What a file of JSON holds, and the schema that it names, empty where it names none.

    Raises DataError, with what was `expected`, for a file that cannot be read or is none.
    """
    try:
        content = content_of(path, path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise DataError(f"{path}: no such file; {expected}") from None
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); {expected}") from None
    except ValueError:
        raise DataError(f"{path}: is no JSON; {expected}") from None
    return content, str(content.get("schema", "")) if isinstance(content, dict) else ""


def content_of(path: Path, text: str) -> Any:
    """What a file holds: an object, or the one that lines of a fit to several records of one muscle come to, which has
    seen what all of them have.

    Raises DataError for lines that differ in more, and ValueError for what is no JSON.
    """
    try:
        return json.loads(text)
    except ValueError:
        lines = [json.loads(line) for line in text.splitlines()]
    if not lines or not all(isinstance(one, dict) and "shared" in one for one in lines):
        raise ValueError
    first, answers = lines[0], [Answer(path, one) for one in lines]
    values = [{name: one.values(holder) for name, holder in one.stages[0][1].items()} for one in answers]
    muscles = [replace(read_specimen_of(one), name="") for one in answers]
    if any(one != values[0] for one in values) or any(one != muscles[0] for one in muscles):
        raise DataError(
            f"{path}: holds the fits of {len(lines)} records, a line each, with parameters of their own; give the line "
            "that is meant as a file of its own"
        )
    for name, table in ((name, holder["reading"]) for name, holder in first["branches"].items()):
        each = [one["branches"][name]["reading"] for one in lines]
        table["pressures_MPa"] = sorted({p for one in each for p in one["pressures_MPa"]})
        table["contraction"] = _ends([one["contraction"] for one in each])
    first["range"] = {key: _ends([one["range"][key] for one in lines]) for key in first["range"]}
    return first


def _ends(each: list[list[float]]) -> list[float]:
    return [min(low for low, _ in each), max(high for _, high in each)]


def _fit_of(diagnosis: Mapping[str, Any]) -> str:
    """The command that fits the model of a diagnosis; files of earlier versions do not hold it."""
    words = ["pam-ident", "fit", str(diagnosis.get("record") or "RECORD"), "--law", str(diagnosis.get("law") or "LAW")]
    words += [word for name in diagnosis.get("selected") or () for word in ("--effect", str(name))]
    return diagnosis.get("fit_command") or shlex.join([*words, "--json", "fit.json"])


def read_specimen_of(answer: Answer) -> Specimen:
    """The specimen a file was made with. Raises DataError for files of earlier versions, which do not hold it."""
    table = answer.content.get("specimen")
    if not isinstance(table, dict) or not set(GEOMETRY) <= set(table):
        raise DataError(f"{answer.path}: does not hold its specimen; give a specimen, or fit again with --json")
    try:
        return Specimen(**{name: table[name] for name in GEOMETRY})
    except (DataError, TypeError) as error:
        raise DataError(f"{answer.path}: {error}") from None


def fitted_branches(found: Mapping[str, T], where: str) -> tuple[T, T]:
    """What belongs to contraction and to extension; twice the same where both were fitted together.

    Raises UsageError where a branch is missing.
    """
    if set(found) == {"together"}:
        return found["together"], found["together"]
    if set(found) == {"contraction", "extension"}:
        return found["contraction"], found["extension"]
    given = ", ".join(found) or "no branch"
    raise UsageError(f"{where}: holds {given}; expected both branches: fit with --branch together or separate")
