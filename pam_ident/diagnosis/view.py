"""A fitted model with its slopes, around which signatures of effects are taken and compressed."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import groupby

import numpy as np

from ..effects import Effect, Form
from ..fitting.solve import jacobian
from ..model import Model
from ..records import Record
from .dictionary import Regressor, Slopes, grid, regressors_at, same_around_any, slopes
from .noise import Noise
from .search import Compressed, FormBlock, Frame

Array = np.ndarray


class View:
    """A fitted model with its slopes: the place around which signatures are taken.

    Views of one record share what is `kept`: regressors that are the same around any model.
    """

    def __init__(
        self, record: Record, model: Model, values: Mapping[str, float], kept: dict[str, list[Regressor]] | None = None
    ) -> None:
        self.record, self.model, self.values = record, model, values
        self.around: Slopes = slopes(model, record.inputs, values)
        self.residual = record.force - self.around.force
        self.kept = {} if kept is None else kept

    @cached_property
    def law(self) -> Array:
        """Slopes of the force over the model's parameters, shape (n, k)."""
        return jacobian(self.model, self.record.inputs, self.values, self.record.force)

    def regressors(self, effect: Effect) -> list[Regressor]:
        """Signatures of all forms of an effect."""
        return [a for form in effect.forms for a in self._regressors_in(effect, form)]

    def _regressors_in(self, effect: Effect, form: Form) -> list[Regressor]:
        key, inputs = f"{effect.name}:{form.name}", self.record.inputs
        found = self.kept.get(key) or regressors_at(effect, form, grid(form, inputs), inputs, self.around)
        if same_around_any(form):
            self.kept[key] = found
        return found

    def frame(self, noise: Noise) -> Frame:
        """What the model can follow and what it leaves, whitened."""
        return Frame(noise.whiten(self.law), noise.whiten(self.residual))

    def compress(self, regressors: Sequence[Regressor], noise: Noise) -> Compressed:
        """Whitened Gram matrix of some regressors, free of what the model itself can follow."""
        matrix = np.hstack([np.empty((len(self.residual), 0)), *[a.columns for a in regressors]])
        return Compressed.together(regressors, noise.whiten(matrix), self.frame(noise))

    def singly(
        self, regressors: Sequence[Regressor], noise: Noise, kept: dict[str, FormBlock] | None = None
    ) -> Compressed:
        """The same for regressors, those of a form in a row, that are looked at one by one.

        Blocks that are the same around any model are taken from those `kept`, or added to them.
        """
        kept = {} if kept is None else kept
        blocks = []
        for label, run in groupby(regressors, key=lambda a: a.term.label):
            block = kept.get(label) or FormBlock(list(run), noise)
            if same_around_any(block.regressors[0].term.form):
                kept[label] = block
            blocks.append(block)
        return Compressed.singly(blocks, self.frame(noise))
