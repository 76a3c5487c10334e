"""pam-ident laws."""

from . import options, text


def laws(json: options.JsonFile = None) -> None:
    """List the force laws that are known, those with the fewest parameters first."""
    from ..laws import listed
    from ..schema.catalogue import laws_json

    found = listed()
    options.give_json(json, lambda: laws_json(found))
    for law in found:
        names = ", ".join(p.name for p in law.params)
        text.say(
            f"{law.name}: {law.title}",
            f"{text.INDENT}{law.formula}",
            f"{text.INDENT}{len(law.params)} parameters{f': {names}' if names else ''}",
            f"{text.INDENT}source: {law.source}",
        )
