"""The muscle, typed in."""

import panel as pn

from ..core import Specimen
from . import words
from .parts import LOOK

FIELDS = {
    "initial_length_mm": "Initial length (mm)",
    "initial_radius_mm": "Initial radius (mm)",
    "braid_angle_deg": "Braid angle (°)",
    "wall_thickness_mm": "Wall thickness (mm), if known",
}


class SpecimenForm:
    """Fields for a muscle at rest; `fields` by the names of a specimen.toml."""

    def __init__(self) -> None:
        self.fields = {key: pn.widgets.TextInput(label=label, width=200, **LOOK) for key, label in FIELDS.items()}
        self.row = pn.FlexBox(*self.fields.values(), sizing_mode="stretch_width")

    def given(self, name: str) -> Specimen | None:
        """The muscle that is typed in, under that name; None where too little is. Raises UsageError for what is no
        number, DataError for no muscle."""
        values = {key: words.length(field.label, field.value) for key, field in self.fields.items() if field.value}
        if len(values.keys() - {"wall_thickness_mm"}) < 3:
            return None
        return Specimen(name, **values)  # pyright: ignore[reportArgumentType] - lengths and an angle

    def show(self, specimen: Specimen) -> None:
        """Fill in a muscle."""
        for key, field in self.fields.items():
            value = getattr(specimen, key)
            field.value = "" if value is None else f"{value:.10g}"
