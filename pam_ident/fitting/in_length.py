"""A fit to a record in which the length answered, for what asks where a residual lies and not in which unit it is."""

from dataclasses import fields
from functools import cached_property

from ..core import Array
from .fit import Fit
from .readings import Errors


class InLength(Fit):
    """A fit whose `residual`, `errors` and what is made of them are of the length, in mm; positive where the muscle is
    shorter than predicted."""

    @classmethod
    def of(cls, one: Fit) -> "InLength":
        """Of a fit that has `lengths`."""
        return cls(**{field.name: getattr(one, field.name) for field in fields(one)})

    @cached_property
    def residual(self) -> Array:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Measured minus predicted length of the stroke in mm at every sample, shape (n,)."""
        assert self.lengths is not None
        return self.lengths.residual

    @cached_property
    def errors(self) -> Errors:  # pyright: ignore[reportIncompatibleVariableOverride]
        """What the fitted rows leave, in mm."""
        assert self.length_errors is not None
        return self.length_errors
