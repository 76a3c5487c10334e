"""Options that several commands share, and what they become."""

from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from ..core import PamError
    from ..records.doubt import Doubt
    from ..tasks.law_choice import LawChoice
    from ..tasks.setup import Setup


def law_names(incomplete: str) -> list[str]:
    """For the shell: names of laws that begin so."""
    from ..laws import listed

    return [law.name for law in listed() if law.name.startswith(incomplete)]


def effect_names(incomplete: str) -> list[str]:
    """For the shell: names of effects that begin so, and of their forms after a colon."""
    from ..effects import listed

    names = [effect.name for effect in listed()]
    forms = [f"{effect.name}:{form.name}" for effect in listed() for form in effect.forms]
    return [name for name in (forms if ":" in incomplete else names) if name.startswith(incomplete)]


def option(flag: str, metavar: str, help: str, **more: Any) -> Any:
    """An option without a default worth telling; one that names what to write has a letter, too."""
    flags = (flag, "-o") if flag == "--out" else (flag,)
    return typer.Option(*flags, metavar=metavar, help=help, show_default=False, **more)


Record = Annotated[
    str,
    typer.Argument(
        metavar="RECORD",
        help="Record of a test rig: a file, a folder, a quoted glob, or the name of a bundled data set.",
        show_default=False,
    ),
]
Law = Annotated[
    str,
    option(
        "--law",
        "LAW",
        "Force law by name (`pam-ident laws`), or a Python file of your own that defines LAW; auto, the default, takes "
        "the one that predicts held-out data best.",
        autocompletion=law_names,
    ),
]
Effects = Annotated[
    list[str] | None,
    option("--effect", "NAME", "Effect in the model, NAME or NAME:FORM; repeatable.", autocompletion=effect_names),
]
EffectFiles = Annotated[
    list[str] | None, option("--effect-file", "FILE.py", "Python file with an effect of yours; repeatable.")
]
FreeGeometry = Annotated[
    bool, typer.Option("--free-geometry", help="Fit radius (± 15 %) and braid angle (20° to 35°) too.")
]
Branch = Annotated[
    str, typer.Option("--branch", metavar="BRANCH", help="together, separate, contraction or extension.")
]
SpecimenFile = Annotated[
    str | None, option("--specimen", "FILE", "Specimen file; default: specimen.toml beside the record.")
]
Where = Annotated[
    str | None, option("--where", "CONDITION", "Only rows for which this holds, such as 'pressure_MPa > 0.1'.")
]
Assume = Annotated[
    list[str] | None,
    option(
        "--assume",
        "CODE",
        "The record is meant so although a grave warning of that code, or all, stands: it does not stop the naming of "
        "effects then; repeatable.",
    ),
]
Heldout = Annotated[
    str | None,
    option(
        "--heldout",
        "WHAT",
        "Hold out each length, pressure, run, cycle or muscle whole, and choose everything anew without it; or refit: "
        "only fit the parameters anew.",
    ),
]
Without = Annotated[
    list[str] | None,
    option(
        "--without",
        "NAME",
        "Effect that is not tried, because the rig cannot have it; repeatable.",
        autocompletion=effect_names,
    ),
]
Only = Annotated[
    list[str] | None,
    option("--only", "NAME", "The only effect that is tried; repeatable.", autocompletion=effect_names),
]
Also = Annotated[
    list[str] | None,
    option(
        "--also",
        "NAME",
        "Effect that is tried though it is no candidate by itself, such as moving_mass; repeatable.",
        autocompletion=effect_names,
    ),
]
JsonFile = Annotated[str | None, option("--json", "FILE", "Write the answer as JSON; - for stdout, alone there.")]
Workers = Annotated[
    int | None, option("--workers", "N", "Processes at a time; the answer stays the same. Default: one a core.")
]
Scheduler = Annotated[
    str | None, option("--scheduler", "ADDRESS", "The workers of a Dask scheduler instead, tcp://HOST:PORT.")
]


@dataclass(frozen=True)
class Asked:
    """The options of all commands that fit a model; `verb` puts them where a command has an argument of this type."""

    effect: Effects = None
    effect_file: EffectFiles = None
    free_geometry: FreeGeometry = False
    specimen: SpecimenFile = None
    assume: Assume = None
    json: JsonFile = None
    where: Where = None

    def setup(self, law: str) -> "Setup":
        """What is asked for, with the names looked up."""
        from ..tasks.gate import check_codes
        from ..tasks.setup import Setup

        effects, files = tuple(self.effect or ()), tuple(self.effect_file or ())
        assume = tuple(self.assume or ())
        check_codes(assume)
        found = Setup(law, effects, files, self.free_geometry, self.specimen, where=self.where, assume=assume)
        found.check()
        return found


NOTHING = Asked()
answered: ContextVar[bool] = ContextVar("answered", default=False)
"""Whether the command has written its JSON."""


def held_out(word: str | None) -> str:
    """What to hold out, empty where nobody says. Raises UsageError for an unknown word."""
    if word is not None:
        from ..tasks.setup import check_heldout

        check_heldout(word)
    return word or ""


def tried(without: list[str] | None, only: list[str] | None, also: list[str] | None) -> dict[str, Any]:
    """What a diagnosis tries, as a Setup has it."""
    return {"without": tuple(without or ()), "only": tuple(only or ()), "also": tuple(also or ())}


def check_json(path: str | None) -> None:
    """Refuse a file that cannot be written before anything is computed."""
    if path is not None and path != "-":
        from ..core.files import check_target

        check_target(path)


def stop_if_invalid(record: str, problems: "Sequence[str]") -> None:
    """End with a message and exit code 3 where a fit has problems."""
    if problems:
        text.warn(f"{record}: the fit is not valid. {'; '.join(problems)}")
        raise typer.Exit(3)


def give_json(path: str | None, answer: "Callable[[], Mapping[str, Any]]") -> None:
    """Write an answer where one was asked for."""
    if path is not None:
        from ..core.files import write_json

        answered.set(True)
        found = dict(answer())
        write_json(path, found | {"warnings": found.get("warnings", [])})


def reasons(error: "PamError") -> "tuple[Doubt, ...]":
    """Why a command was refused, as its warnings."""
    from ..records.doubt import Doubt

    code = {3: "no_fit", 4: "bad_data"}.get(error.exit_code, "failed")
    return getattr(error, "doubts", None) or (Doubt(code, " ".join(str(error).split()), None, True),)


def give_refused(path: str | None, error: Exception, asked: "Mapping[str, Any]") -> None:
    """Write, where an answer was asked for and none is written, why there is none; `asked` are the command's words."""
    from ..core import PamError

    if isinstance(error, PamError) and error.exit_code in (3, 4) and not answered.get():
        from ..schema.diagnosis import refusal_json

        record = asked.get("record") or asked.get("at")
        record = record if isinstance(record, str | None) else " ".join(record)
        give_json(path, lambda: refusal_json(record, asked.get("law"), error.exit_code, reasons(error)))


def give_stopped(path: str | None, record: str, law: str, stop: "PamError", choice: "LawChoice | None" = None) -> None:
    """Write, where an answer was asked for, that nothing is named, and why."""
    if stop.exit_code in (3, 4):
        from ..schema.diagnosis import stopped_json
        from ..schema.prediction import law_choice_json

        n = getattr(stop, "n", 0)
        give_json(path, lambda: stopped_json(record, law, n, reasons(stop)) | law_choice_json(choice))


def held(pairs: list[str] | None) -> dict[str, float]:
    """Parameters to hold, from NAME=VALUE. Raises UsageError for anything else."""
    from ..core import UsageError

    found = {}
    for pair in pairs or ():
        name, _, value = pair.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise UsageError(f"--hold {pair!r}: expected NAME=VALUE, such as mu=45") from None
    return found
