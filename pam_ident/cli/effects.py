"""pam-ident effects."""

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from . import options, text
from .door import Command
from .verbs import verb


class EffectGroup(TyperGroup):
    """Takes a name that is no command for that of an effect: `effects creep` is `effects show creep`."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the first word names, with the words that are left for it."""
        return super().resolve_command(ctx, args if args[0] in self.commands else ["show", *args])


app = typer.Typer(
    cls=EffectGroup,
    rich_markup_mode=None,
    help="List the known effects; `effects NAME` tells all about one.",
)
EffectFile = Annotated[str, typer.Argument(metavar="FILE.py", help="Python file of an effect.", show_default=False)]


@app.callback(invoke_without_command=True)
@verb
def list_all(context: typer.Context, effect_file: options.EffectFiles = None, json: options.JsonFile = None) -> None:
    """List the effects that are known; `effects NAME` tells all about one."""
    context.obj = tuple(effect_file or ())
    if context.invoked_subcommand is not None:
        return
    from ..effects import listed, load_effect_files
    from ..schema.catalogue import effects_json

    found = listed(load_effect_files(context.obj))
    options.give_json(json, lambda: effects_json(found))
    for effect in found:
        needs = f"{text.INDENT}needs in the record: {', '.join(effect.needs)}"
        text.say(
            f"{effect.name}: {effect.title}", f"{text.INDENT}{effect.forms[0].formula}", *[needs] * bool(effect.needs)
        )


@app.command(cls=Command)
@verb
def show(
    context: typer.Context,
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Name of an effect.", autocompletion=options.effect_names)
    ],
    json: options.JsonFile = None,
) -> None:
    """Tell all about one effect: its forms, parameters, source, and the test that shows it."""
    from ..effects import get_effect, load_effect_files
    from ..schema.catalogue import effects_json

    effect, _ = get_effect(name, load_effect_files(context.obj or ()))
    options.give_json(json, lambda: effects_json([effect]))
    text.say(f"{effect.name}: {effect.title}", f"source: {effect.source}", f"test: {effect.test}")
    text.say(f"needs in the record: {', '.join(effect.needs) or 'nothing beyond pressure, contraction and force'}")
    if effect.levers:
        text.say(f"vary on the rig: {', '.join(effect.levers)}")
    if not effect.candidate:
        text.say(f"no candidate of the diagnosis by itself; tried with --also {effect.name}")
    if effect.warning:
        text.say(f"Warning: {effect.warning}")
    for form in effect.forms:
        text.say("", f"form {form.name}: {form.formula}")
        text.say(*text.meanings(form.params))


@app.command(cls=Command)
@verb
def new(
    file: EffectFile,
    name: Annotated[
        str | None, typer.Option("--name", metavar="NAME", help="Name of the effect; default: the file's.")
    ] = None,
    adds_force: Annotated[bool, typer.Option("--adds-force", help="It adds a force (default).")] = False,
    scales_force: Annotated[bool, typer.Option("--scales-force", help="It scales the law's force.")] = False,
    transforms_pressure: Annotated[
        bool, typer.Option("--transforms-pressure", help="It changes the pressure that the law is given.")
    ] = False,
    transforms_contraction: Annotated[
        bool, typer.Option("--transforms-contraction", help="It changes the contraction that the law is given.")
    ] = False,
    json: options.JsonFile = None,
) -> None:
    """Write a commented scaffold of an effect of your own, which works as it is."""
    from ..core import UsageError
    from ..effects import load_effect_file
    from ..schema.catalogue import effects_json
    from ..tasks.new_effect import new_effect

    asked = {
        "adds_force": adds_force,
        "scales_force": scales_force,
        "transforms_pressure": transforms_pressure,
        "transforms_contraction": transforms_contraction,
    }
    roles = [role for role, wanted in asked.items() if wanted]
    if len(roles) > 1:
        flags = " and ".join("--" + role.replace("_", "-") for role in roles)
        raise UsageError(f"{flags}: a scaffold has one form; name one of them, and add the other form in the file")
    made = new_effect(file, name, *roles)
    options.give_json(json, lambda: effects_json(load_effect_file(file)))
    text.say(f"{file}: effect {made}; put your formula in, then ask `pam-ident effects check {file}`")


@app.command(cls=Command)
@verb
def check(file: EffectFile, json: options.JsonFile = None) -> None:
    """Hold an effect of your own to what every known effect promises."""
    from ..core import UsageError
    from ..schema.catalogue import effects_json
    from ..validation.check_effects import check_effects

    found, problems = check_effects(file)
    options.give_json(json, lambda: effects_json(found, problems))
    for one in problems:
        text.say(f"{one.effect}{':' if one.form else ''}{one.form}: {one.text}")
    if problems:
        raise UsageError(f"{file}: {len(problems)} {'promise is' if len(problems) == 1 else 'promises are'} not kept")
    for effect in found:
        text.say(f"{effect.name}: {', '.join(form.name for form in effect.forms)} keep what an effect promises")
