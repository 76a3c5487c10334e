"""A sealed set, its answers, and the envelope that is opened only when all of them are there."""

import json
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..core import DataError, PamError, UsageError
from ..core.files import write_json_lines
from ..effects import catalogue
from ..parallel.executor import Executor, WorkerLost
from ..rig import make_challenge
from ..schema.diagnosis import diagnosis_json, stopped_json
from ..tasks.diagnose import diagnose_records
from ..tasks.gate import NothingNamed
from ..tasks.setup import Setup
from .calibration import Reliability, reliability
from .holdout import left_out
from .score import Score, Tally, confusion, score, tally

Json = dict[str, Any]
VERDICTS = ("adequate", "missing_effect", "unknown_effect")


@dataclass(frozen=True)
class Challenge:
    """A set with the scores of its answers; `seconds` that the program took to answer, None for another's answers."""

    folder: Path
    scores: tuple[Score, ...]
    seconds: float | None

    @property
    def tallies(self) -> tuple[Tally, ...]:
        """A line for each kind, and one for all."""
        return tally(self.scores)

    @property
    def confusion(self) -> dict[tuple[str, str], int]:
        """How often a hidden family was answered with a named one."""
        return confusion(self.scores)

    @property
    def reliability(self) -> Reliability:
        """Probabilities stated in all answers against the truth."""
        pairs = [pair for s in self.scores for pair in s.statements]
        return reliability([p for p, _ in pairs], [true for _, true in pairs])


def write_challenge(
    folder: str,
    n: int = 60,
    seed: int = 1,
    only: str | None = None,
    holdout: str | None = None,
    protocols: str = "plain",
) -> int:
    """Write `n` cases and their answers (truth.json) into `folder`; how many were written.

    `only` asks for cases of one kind; `holdout` leaves the hidden "effects", or their "forms", out of the catalogue;
    `protocols` are plain, all, or of one kind of test that drives the pressure. Raises UsageError for an unknown kind,
    holdout or set of protocols, or a count below 1.
    """
    leaves = None if holdout is None else left_out(holdout)
    try:
        return len(make_challenge(folder, n, seed, only, leaves, protocols))
    except ValueError as error:
        raise UsageError(str(error)) from None


def sit_challenge(
    folder: str | Path,
    n: int = 60,
    seed: int = 1,
    only: str | None = None,
    executor: Executor | None = None,
    holdout: str | None = None,
    protocols: str = "plain",
) -> Challenge:
    """Write a set into `folder`, let the program answer (answers.jsonl), then open the envelope and score.

    Raises UsageError for a folder that holds a set already, an unknown kind, or a count below 1.
    """
    folder = Path(folder)
    if (folder / "truth.json").exists():
        raise UsageError(
            f"{folder}: holds a set already; name another folder, or score your answers to it by --answers"
        )
    write_challenge(str(folder), n, seed, only, holdout, protocols)
    start = time.perf_counter()
    answers = answer_all(folder, executor)
    seconds = time.perf_counter() - start
    write_json_lines(folder / "answers.jsonl", answers.values())
    return open_envelope(folder, answers, seconds)


def score_answers(folder: str | Path, answers: str | Path) -> Challenge:
    """Score answers (JSON lines, as `diagnose --json` writes them) to a set that was written earlier.

    Raises DataError for a folder that holds no set, a line that is no answer, or a case that is not answered.
    """
    folder = Path(folder)
    return open_envelope(folder, read_answers(answers, questions(folder)), None)


def questions(folder: Path) -> dict[str, Setup]:
    """What is asked by case, from questions.json. Raises DataError where there is none."""
    asked = _read(folder, "questions.json")
    return {one["case"]: Setup(one["law"], without=tuple(one.get("without", ()))) for one in asked}


def answer_all(folder: Path, executor: Executor | None = None) -> dict[str, Json]:
    """The program's answers by case, in the order of the cases, several at a time; truth.json is not read.

    By a process for each core, or by `executor`; a Dask cluster's workers must see the folder.
    """
    asked = list(questions(folder).items())
    executor = executor or Executor.of_cores()
    seen = folder if executor.scheduler is None else folder.resolve()
    found = executor.in_order(partial(_answer, seen), asked, "cases")
    return {
        case: _none(str(seen / case / "record.csv"), setup.law, one) if isinstance(one, WorkerLost) else one
        for (case, setup), one in zip(asked, found, strict=True)
    }


def _answer(folder: Path, question: tuple[str, Setup]) -> Json:
    return answer_case(folder, *question)


def _none(path: str, law: str, error: PamError) -> Json:
    """What is said where no answer is found, which is wrong."""
    return {"record": path, "law": law, "verdict": "none", "error": str(error)}


def answer_case(folder: Path, case: str, setup: Setup) -> Json:
    """One case; a diagnosis that breaks down is an answer too, and a wrong one."""
    path = str(folder / case / "record.csv")
    ((_, found, _),) = diagnose_records([path], setup)
    if isinstance(found, NothingNamed):
        return stopped_json(path, setup.law, found.n, found.doubts)
    if isinstance(found, PamError):
        return _none(path, setup.law, found)
    return diagnosis_json(path, found)


def read_answers(path: str | Path, asked: Collection[str]) -> dict[str, Json]:
    """Answers by case; each line names its case by "case", or by the folder of its "record".

    Raises DataError naming the line that is no answer, and the cases without one.
    """
    answers: dict[str, Json] = {}
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: cannot be read ({error}); expected a file of JSON lines, an answer a line") from None
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        case, answer = _parse(f"{path}, line {number}", line)
        if case not in asked:
            raise DataError(
                f"{path}, line {number}: case {case!r}; expected one of the set, such as {next(iter(asked))}"
            )
        if case in answers:
            raise DataError(f"{path}, line {number}: {case} is answered twice; keep one answer")
        answers[case] = answer
    lacking = [case for case in asked if case not in answers]
    if lacking:
        raise DataError(f"{path}: no answer to {_some(lacking)}; the envelope stays closed until each case has one")
    return {case: answers[case] for case in asked}


def _parse(where: str, line: str) -> tuple[str, Json]:
    try:
        answer = json.loads(line)
    except ValueError as error:
        raise DataError(f"{where}: no JSON ({error}); expected an object a line, as diagnose --json writes") from None
    if not isinstance(answer, dict):
        raise DataError(f'{where}: expected an object, such as {{"case": "c000", "verdict": "adequate"}}')
    if answer.get("verdict") not in VERDICTS:
        raise DataError(f"{where}: verdict {answer.get('verdict')!r}; expected {', '.join(VERDICTS)}")
    named = answer.get("selected") or []
    strange = [name for name in named if name not in catalogue()] if isinstance(named, list) else [named]
    if strange:
        raise DataError(f"{where}: selected {strange[0]!r}; expected a list of known effects (`pam-ident effects`)")
    return str(answer.get("case") or Path(str(answer.get("record", ""))).parent.name), answer


def open_envelope(folder: Path, answers: Mapping[str, Json], seconds: float | None) -> Challenge:
    """Read truth.json and score. Raises DataError where it is gone."""
    truth = _read(folder, "truth.json")
    return Challenge(folder, tuple(score(one, answers[one["case"]]) for one in truth), seconds)


def _read(folder: Path, name: str) -> list[Json]:
    try:
        return json.loads((folder / name).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise DataError(f"{folder / name}: {why}; expected a set as `pam-ident rig {folder}` writes it") from None


def _some(names: Sequence[str], most: int = 5) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
