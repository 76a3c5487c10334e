"""A model, or a fit with its numbers, as equations in text and in LaTeX."""

import math
import re

from ..core import Param
from ..core.digits import known_to, number
from ..core.formula import to_latex
from ..fitting import Fit
from ..fitting.fit import Estimate
from ..model import Model


def equation(of: Model | Fit) -> str:
    """The law's formula and a line an effect; of a fit also a line a parameter, with standard error and unit."""
    if isinstance(of, Model):
        return str(of)
    return "\n".join(
        [
            str(of.model),
            *(f"  {e.name} = {known_to(e.value, e.stderr)}{_error(e)} {_unit(e.unit)}".rstrip() for e in of.estimates),
        ]
    )


def latex(of: Model | Fit) -> str:
    r"""A model, or a fit with its numbers, as one formula of LaTeX: an `aligned` without delimiters.

    Args:
        of: a Model, whose parameters are listed with their units, or a Fit, with values and standard errors, too.

    Example:
        >>> from pam_ident.export.equation import latex
        >>> from pam_ident.model import Model
        >>> print(latex(Model.build("chou_hannaford", ("coulomb_friction",))))
        \begin{aligned}
        & F = \pi r_{0}^{2} p [a(1-\varepsilon )^{2} - b],\quad a = 3/\tan ^{2}\theta_{0},\quad ... \\
        & \text{coulomb\_friction: }-F_{c} \operatorname{sgn}(\dot{\varepsilon}) \\
        & F_{c}\ \text{N}
        \end{aligned}
    """
    return "\\begin{aligned}\n" + " \\\\\n".join(f"& {line}" for line in latex_lines(of)) + "\n\\end{aligned}"


def latex_lines(of: Model | Fit) -> list[str]:
    """The lines of `latex`, each a formula that stands alone."""
    model = of if isinstance(of, Model) else of.model
    lines = [to_latex(model.law.formula)]
    lines += [rf"\text{{{_plain(term.label)}: }}{to_latex(term.form.formula)}" for term in model.terms]
    estimates = {} if isinstance(of, Model) else {e.name: e for e in of.estimates}
    return lines + [_parameter(p, estimates.get(p.name)) for p in model.params]


def symbol(p: Param) -> str:
    """A parameter's symbol in LaTeX; of an effect without the effect's name."""
    return to_latex(p.symbol or p.name.rpartition(".")[2])


def _parameter(p: Param, found: Estimate | None) -> str:
    unit = rf"\ \text{{{_plain(_unit(p.unit))}}}" if _unit(p.unit) else ""
    if found is None:
        return f"{symbol(p)}{unit}"
    error = rf" \pm {_power(number(found.stderr, 2))}" if math.isfinite(found.stderr) else ""
    return f"{symbol(p)} = {_power(known_to(found.value, found.stderr))}{error}{unit}"


def _error(e: Estimate) -> str:
    return f" ± {number(e.stderr, 2)}" if math.isfinite(e.stderr) else ""


def _power(number: str) -> str:
    """1e-05 as a power of ten."""
    return re.sub(r"e([+-])0*(\d+)", lambda m: rf" \cdot 10^{{{m[1].strip('+')}{m[2]}}}", number)


def _unit(unit: str) -> str:
    return "" if unit == "1" else re.sub(r"\^(\d)", lambda m: "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(m[1])], unit)


def _plain(text: str) -> str:
    """Text for inside of LaTeX's text, where few signs stand for themselves."""
    return re.sub(r"[\\{}$%#&~^]", " ", text).replace("_", r"\_")
