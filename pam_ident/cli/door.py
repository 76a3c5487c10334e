"""How every command ends: its exit code, and on an error one or two lines on stderr without a traceback."""

import os
import sys
from typing import Any

from typer.core import TyperArgument, TyperCommand, TyperGroup

from . import text


class Door(TyperGroup):
    """The program's outermost group of commands."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run a command; errors that are the user's to put right become a message and an exit code."""
        if not kwargs.pop("standalone_mode", True):
            return super().main(*args, standalone_mode=False, **kwargs)
        try:
            code = super().main(*args, standalone_mode=False, **kwargs)
            sys.stdout.flush()
        except BrokenPipeError:
            sys.stdout = open(os.devnull, "w")  # noqa: SIM115
            code = 1
        except KeyboardInterrupt:
            code = 130
        except Exception as error:
            message, code = explain(error)
            text.warn(message)
        sys.exit(code if isinstance(code, int) else 0)


class Command(TyperCommand):
    """A command whose help names its arguments without their types in Python."""

    def get_params(self, ctx: Any) -> Any:
        """The parameters, as its help shows them and as they are parsed."""
        params = super().get_params(ctx)
        for one in params:
            if isinstance(one, TyperArgument):
                vars(one)["display_type_rich"] = lambda ctx: None
        return params


def explain(error: Exception) -> tuple[str, int]:
    """Message of at most two lines, and exit code, of an error that ended a command."""
    name = type(error).__name__
    if hasattr(error, "format_message"):
        return _usage(error), getattr(error, "exit_code", 2)
    if name == "Abort":
        return "stopped", 130
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        return f"{where}{error.strerror or error}; name another file or folder, or change its permissions", 2

    from ..core import PamError

    if isinstance(error, PamError):
        return _short(str(error)), error.exit_code
    if isinstance(error, MemoryError):
        return "the memory ran out; take a part of the record, or a larger machine", 2
    if name == "LinAlgError":
        return f"the fit broke down ({_short(str(error))}); check the record for constant columns", 3
    if os.environ.get("PAM_IDENT_DEBUG"):
        raise error
    return (
        f"pam-ident failed where it should not ({name}: {_short(str(error))[:300]})\n"
        "please report it with the command; PAM_IDENT_DEBUG=1 shows where it happened",
        1,
    )


def _usage(error: Any) -> str:
    """A message about the command line, and where its help is; the whole help where nothing was asked."""
    said = error.format_message()
    context = getattr(error, "ctx", None)
    if context is None:
        return _short(said)
    if type(error).__name__ == "NoArgsIsHelpError":
        return said
    return f"{_short(said)}\nTry '{context.command_path} --help'."


def _short(said: str) -> str:
    return " ".join(said.split())
