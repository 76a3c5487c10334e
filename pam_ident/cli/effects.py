"""pam-ident effects."""

from typing import Annotated

import typer

from . import options, text

app = typer.Typer(rich_markup_mode=None, help="List the known effects, or show one.")


@app.callback(invoke_without_command=True)
def list_all(context: typer.Context, effect_file: options.EffectFiles = None) -> None:
    """List the effects that are known; `effects show NAME` tells all about one."""
    context.obj = tuple(effect_file or ())
    if context.invoked_subcommand is not None:
        return
    from ..workflow.list_effects import list_effects

    rows = [
        (effect.name, effect.title, ", ".join(effect.needs) or "-", effect.forms[0].formula)
        for effect in list_effects(context.obj)
    ]
    text.say(*text.table(("effect", "what it is", "needs", "simplest form"), rows, left=(0, 1, 2, 3)))


@app.command()
def show(
    context: typer.Context, name: Annotated[str, typer.Argument(metavar="NAME", help="Name of an effect.")]
) -> None:
    """Tell all about one effect: its forms, parameters, source, and the test that shows it."""
    from ..workflow.list_effects import find_effect

    effect = find_effect(name, context.obj or ())
    text.say(f"{effect.name}: {effect.title}", f"source: {effect.source}", f"test: {effect.test}")
    text.say(f"needs in the record: {', '.join(effect.needs) or 'nothing beyond pressure, contraction and force'}")
    if effect.levers:
        text.say(f"vary on the rig: {', '.join(effect.levers)}")
    if effect.warning:
        text.say(f"Warning: {effect.warning}")
    for form in effect.forms:
        text.say("", f"form {form.name}: {form.formula}")
        rows = [(p.symbol or p.name, p.unit, f"{p.lower:g} to {p.upper:g}", p.doc) for p in form.params]
        text.say(*text.table(("parameter", "unit", "bounds", "meaning"), rows, left=(0, 1, 2, 3)))
