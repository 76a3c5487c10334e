"""Results as IPython shows them at the end of a cell. Nothing heavy is imported before there is something to show."""

from typing import Any

NOUNS = {
    "Specimen": "pam_ident.core.inputs",
    "Record": "pam_ident.records.record",
    "Model": "pam_ident.model",
    "Fit": "pam_ident.fitting.fit",
    "Comparison": "pam_ident.diagnosis.nouns",
    "Diagnosis": "pam_ident.diagnosis.nouns",
    "Ladder": "pam_ident.diagnosis.nouns",
    "Track": "pam_ident.leg.track",
}
"""What is shown, and the module of its class, which is not imported for it."""


def register(display: Any) -> None:
    """Tell a display formatter of IPython how to show the results: as HTML, a model as LaTeX, all as short text."""
    for name, module in NOUNS.items():
        display.formatters["text/plain"].for_type_by_name(module, name, _plain)
        if name == "Model":
            display.formatters["text/latex"].for_type_by_name(module, name, _latex)
        else:
            display.formatters["text/html"].for_type_by_name(module, name, _html)


def _html(result: Any) -> str:
    from .pages import page

    return page(result)


def _latex(model: Any) -> str:
    from ..export.equation import latex

    return f"$$\n{latex(model)}\n$$"


def _plain(result: Any, printer: Any, cycle: bool) -> None:
    from .lines import line

    printer.text(line(result))
