"""A model as one meets it at the prompt: it is fitted where it stands."""

from typing import TYPE_CHECKING, Any

from ..model import Model
from .hints import Hinting
from .working import check_call

if TYPE_CHECKING:
    from .fitted import FitResult


class ShownModel(Hinting, Model):
    """One law and effects, as `pam.Model` gives it: a `pam_ident.model.Model` that has a `fit`.

    Example:
        >>> import pam_ident as pam
        >>> print(pam.Model("martens_boblan").fit("dmsp20_300"))
        Rubber law of Martens and Boblan fitted to DMSP-20-300: 3.21 N rms, 7.70 N at most, R² 0.999924, 60 samples
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        check_call(Model, *args, **kwargs)
        super().__init__(*args, **kwargs)

    def fit(self, record: Any, **more: Any) -> "FitResult":
        """`pam.fit(record, model)`, with its options; what it gives has `predict`, and the model stays as it is.

        Raises UsageError, DataError, FitError as `pam.fit` does.
        """
        from .verbs import fit

        return fit(record, self, **more)
