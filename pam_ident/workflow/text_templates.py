"""The templates of texts that are written, pages and scaffolds."""

from jinja2 import Environment, PackageLoader, StrictUndefined


def templates() -> Environment:
    """Where they are found by name; a value that is missing is an error."""
    return Environment(
        loader=PackageLoader("pam_ident.workflow", "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
