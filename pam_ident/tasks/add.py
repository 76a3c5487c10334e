"""What adding effects to a law does to the error, on held-out data too."""

from dataclasses import dataclass
from functools import cached_property

from ..core import UsageError
from ..diagnosis import heldout_rmse
from ..diagnosis.nested import masks_of
from ..fitting import Fit, fit
from ..fitting.carried import driven, nearer
from ..fitting.prediction import Elsewhere
from ..records import Record
from ..records.doubt import Doubt
from .gate import admit, computing, warnings_of
from .setup import Setup


@dataclass(frozen=True)
class Addition:
    """The law alone and with the effects, and the error of each on held-out data in N."""

    before: Fit
    after: Fit
    heldout_before: float
    heldout_after: float
    warnings: tuple[Doubt, ...] = ()

    @cached_property
    def elsewhere(self) -> Elsewhere:
        """What the record says of the law with the effects on others."""
        return Elsewhere.of(self.after)


def add_effects(record: Record, setup: Setup) -> Addition:
    """Fit the law alone and with the effects of `setup`.

    Raises UsageError without an effect, DataError where the record lacks what an effect needs.
    """
    if not setup.effects:
        raise UsageError("no effect to add; name one with --effect (see pam-ident effects)")
    admit(record)
    model, alone = setup.model, setup.law_alone
    with computing(record):
        record = driven(alone, record)
        after = fit(model, record)
        if (shifted := nearer(model, record, after.values)) is not record:
            record, after = shifted, fit(model, shifted)
        before = fit(alone, record)
        masks = masks_of(record, setup.held_out) if setup.held_out else None
        errors = [heldout_rmse(one, record, masks=masks) for one in (alone, model)]
        return Addition(before, after, errors[0], errors[1], warnings_of(after))
