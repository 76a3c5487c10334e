"""pam-ident laws."""

from . import text


def laws() -> None:
    """List the force laws that are known, those with the fewest parameters first."""
    from ..workflow.list_laws import list_laws

    for law in list_laws():
        names = ", ".join(p.name for p in law.params)
        text.say(
            f"{law.name}: {law.title}",
            f"{text.INDENT}{law.formula}",
            f"{text.INDENT}{len(law.params)} parameters{f': {names}' if names else ''}",
            f"{text.INDENT}source: {law.source}",
        )
