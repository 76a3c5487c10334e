"""The findings of the audit as a page in Markdown."""

from .audit_paper import Audit
from .text_templates import templates


def audit_page(audit: Audit) -> str:
    """The page docs/paper.md, its figures rounded, so that every machine writes the same."""
    environment = templates()
    environment.filters["n"] = rounded
    return environment.get_template("paper.md.j2").render(audit=audit)


def rounded(value: float, digits: int = 0) -> str:
    """A number with so many decimals and a true minus sign."""
    return f"{value:.{digits}f}".replace("-", "−")
