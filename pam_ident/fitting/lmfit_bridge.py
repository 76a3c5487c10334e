"""A Fit for lmfit's reports and confidence intervals, and lmfit's answers back. `Model.to_lmfit` leads there."""

from typing import TYPE_CHECKING

from ..core.lmfit_names import from_lmfit_names, to_lmfit_name
from .fit import Fit

if TYPE_CHECKING:
    from lmfit.minimizer import MinimizerResult
    from lmfit.model import ModelResult


def from_lmfit(result: "ModelResult | MinimizerResult") -> dict[str, float]:
    """Parameter values of an lmfit result by our names."""
    return from_lmfit_names(result.params.valuesdict())  # pyright: ignore[reportAttributeAccessIssue]


def lmfit_result(fit: Fit) -> "ModelResult":
    """A Fit as lmfit's ModelResult, for `fit_report()` and `conf_interval()`.

    lmfit fits the same rows again, with their weights, from the Fit's own values, so its errors and correlations are
    its own work; it takes the noise as white. What is held, stands at a bound, or is not identified, stays fixed: lmfit
    could give no error of the others beside it.
    """
    model, parameters = fit.model.to_lmfit(fit.record.inputs, fit.rows)
    for one in fit.estimates:
        parameters[to_lmfit_name(one.name)].set(value=one.value, vary=one.name in fit.free and one.identified)
    weights = None if fit.weights is None else fit.weights[fit.rows]
    return model.fit(fit.record.force[fit.rows], parameters, weights=weights, inputs=fit.record.inputs)
