"""The findings of the audit as a page in Markdown."""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from .audit import Audit


def audit_page(audit: Audit) -> str:
    """The page docs/paper.md, its figures rounded, so that every machine writes the same."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["n"] = rounded
    return environment.get_template("paper.md.j2").render(audit=audit)


def rounded(value: float, digits: int = 0) -> str:
    """A number with so many decimals and a true minus sign."""
    return f"{value:.{digits}f}".replace("-", "−")
