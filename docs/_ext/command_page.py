"""The reference of the command line, from the program's own help."""

from typing import Any

from effect_pages import table
from typer.main import get_command

from pam_ident.cli import app


def command_page() -> str:
    """A section for each command, with arguments and options, in the order of `pam-ident --help`."""
    group = get_command(app)
    parts = ["# Commands", str(group.help), "Each command tells the same with `--help`.", str(group.epilog)]
    for name, command in group.commands.items():  # type: ignore[attr-defined]
        parts += _section(f"pam-ident {name}", command, 2)
    return "\n\n".join(parts) + "\n"


def _section(path: str, command: Any, level: int) -> list[str]:
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    options = [p for p in command.params if p.param_type_name == "option"]
    words = [*map(_place, arguments), *(["[OPTIONS]"] if options else [])]
    parts = ["#" * level + f" {path}", f"```text\n{' '.join([path, *words])}\n```", str(command.help or "")]
    if arguments or options:
        rows = [(f"`{p.metavar or p.name.upper()}`", _about(p)) for p in arguments]
        rows += [(f"`{_option(p)}`", _about(p)) for p in options]
        parts.append(table(("argument or option", "meaning"), rows))
    for name, sub in getattr(command, "commands", {}).items():
        parts += _section(f"{path} {name}", sub, level + 1)
    return parts


def _place(argument: Any) -> str:
    name = (argument.metavar or argument.name.upper()) + "..." * (argument.nargs != 1)
    return name if argument.required else f"[{name}]"


def _option(option: Any) -> str:
    names = ", ".join([*option.opts, *option.secondary_opts])
    return names if option.is_flag or not option.metavar else f"{names} {option.metavar}"


def _about(param: Any) -> str:
    text = (param.help or "").replace("|", "\\|").replace("*", "\\*").replace("<", "\\<")
    shown = param.show_default and isinstance(param.default, str | int | float) and param.default not in (False, "")
    notes = [f"default {param.default}"] if shown else []
    notes += ["required"] if param.required else []
    return f"{text} ({', '.join(notes)})" if notes else text
