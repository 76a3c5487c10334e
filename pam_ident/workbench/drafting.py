"""The dropped file as a table to correct: a row a column of it, with menus for what it is and its unit."""

from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn

from ..core import UsageError
from ..records.guess import units_of
from ..records.quantities import QUANTITIES
from . import words
from .draft import Draft
from .parts import LOOK, SpecimenForm, html, on_press

WORDS = {"": "not used", "pressure_set": "pressure, set point", "displacement": "displacement (shortening > 0)",
         "contraction": "contraction ratio", "length": "length of the muscle"}  # fmt: skip
UNITS = {"1": "ratio", "pct": "%", "C": "°C", "um": "µm", "bar_abs": "bar absolute", "kPa_abs": "kPa absolute",
         "MPa_abs": "MPa absolute"}  # fmt: skip


class Drafting:
    """`panel` shows a draft; `opened` is called when a person says that it is right."""

    def __init__(self, opened: Callable[[], None], closed: Callable[[], None]) -> None:
        self.draft: Draft | None = None
        self.form = SpecimenForm()
        self.table, self.head = pn.Column(sizing_mode="stretch_width"), html()
        self.open = pn.widgets.Button(label="Open with these columns", color="primary", **LOOK)
        self.close = pn.widgets.Button(label="Leave it", **LOOK)
        on_press(self.open, opened)
        on_press(self.close, closed)
        self.muscle = pn.Column(html("<h3>The muscle at rest</h3>"), self.form.row, sizing_mode="stretch_width")
        self.panel = pn.Column(self.head, self.table, self.muscle, pn.Row(self.open, self.close), visible=False,
                               sizing_mode="stretch_width", css_classes=["draft"], **LOOK)  # fmt: skip

    def show(self, draft: Draft | None, ask: bool) -> None:
        """Show a draft where it is to be looked at."""
        self.panel.visible = ask and draft is not None
        if draft is None or draft is self.draft:
            return
        fresh = self.draft is None or draft.files is not self.draft.files
        self.draft = draft
        self.muscle.visible = not draft.has_specimen
        self.head.object = str(words.draft(draft))
        if fresh:
            self.table.objects = [self._row(k) for k in range(len(draft.columns))] if draft.ours else []

    def _row(self, k: int) -> pn.FlexBox:
        assert self.draft is not None
        one = self.draft.columns[k]
        known = {WORDS.get(name, name.replace("_", " ")): name for name in ("", *QUANTITIES)}
        what = pn.widgets.Select(label=f"{one.name} is", options=known, value=one.guess.quantity, width=205, **LOOK)
        unit = pn.widgets.Select(label=f"Unit of {one.name}", options=_units(one.guess.quantity), width=90, **LOOK)
        unit.value = one.guess.unit if one.guess.unit in unit.options.values() else next(iter(unit.options.values()))
        factor = pn.widgets.TextInput(label=f"Factor of {one.name}", value=f"{one.factor:g}", width=80, **LOOK)
        offset = pn.widgets.TextInput(label=f"Offset of {one.name}", value=f"{one.offset:g}", width=80, **LOOK)
        change = partial(self._changed, k, what, unit, factor, offset)
        what.param.watch(
            lambda _: unit.param.update(options=_units(what.value), value=next(iter(_units(what.value).values()))),
            "value",
        )
        for field in (what, unit, factor, offset):
            field.param.watch(change, "value")
        return pn.FlexBox(html(str(words.column(one)), width=190, sizing_mode=None), what, unit, factor, offset,
                          sizing_mode="stretch_width", align_items="end")  # fmt: skip

    def _changed(self, k: int, what: Any, unit: Any, factor: Any, offset: Any, _: Any) -> None:
        assert self.draft is not None
        try:
            size = words.length(factor.label, factor.value), words.length(offset.label, offset.value)
        except UsageError as error:
            self.head.object = str(words.draft(self.draft, str(error)))
            return
        self.draft = self.draft.told(k, what.value, unit.value, *size)
        self.head.object = str(words.draft(self.draft))


def _units(quantity: str) -> dict[str, str]:
    return {UNITS.get(unit, unit): unit for unit in units_of(quantity)} or {"–": ""}
