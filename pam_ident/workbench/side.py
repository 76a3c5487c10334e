"""The column at the side of the page: what is asked, the model, and what can be kept."""

import panel as pn

from ..core import PamError, Specimen
from ..laws import listed as listed_laws
from ..records.datasets import dataset_names, dataset_record
from ..tasks.setup import Setup
from . import words
from .bench import Bench
from .parts import html

SIDE = 340
"""Width in pixels."""


class Side:
    """The widgets, and `column` that holds them; what they do is the page's."""

    def __init__(self, setup: Setup) -> None:
        wide = {"sizing_mode": "stretch_width"}
        self.drop = pn.widgets.FileInput(multiple=True, label="Record (and its specimen.toml)", **wide)
        self.example = pn.widgets.Select(label="or an example", options={"choose …": "", **_examples()}, **wide)
        self.law = pn.widgets.Select(label="Force law", options={law.title: law.name for law in listed_laws()}, **wide)
        self.law.value = setup.law
        known = {"as the specimen says": False, "radius and braid angle fitted": True}
        self.geometry = pn.widgets.Select(label="Geometry", options=known, value=setup.free_geometry, **wide)
        self.fields = {
            key: pn.widgets.TextInput(label=name, **wide)
            for key, name in (
                ("initial_length_mm", "Initial length (mm)"),
                ("initial_radius_mm", "Initial radius (mm)"),
                ("braid_angle_deg", "Braid angle (°)"),
                ("wall_thickness_mm", "Wall thickness (mm), if known"),
            )
        }
        self.use_specimen = pn.widgets.Button(label="Use this specimen", **wide)
        self.save_specimen = pn.widgets.FileDownload(filename="specimen.toml", label="Save specimen.toml", **wide)
        self.specimen = pn.Card(
            *self.fields.values(),
            self.use_specimen,
            self.save_specimen,
            title="Specimen",
            collapsed=True,
            margin=(8, 10),
            **wide,
        )
        self.model = pn.Column(**wide)
        self.other = pn.widgets.Select(label="Another effect", options=[], **wide)
        self.add_other = pn.widgets.Button(label="Add this effect", **wide)
        self.save = pn.widgets.FileDownload(filename="report.html", label="Save the report", color="primary", **wide)
        self.command = html()
        self.column = pn.Column(
            html("<h2>Record</h2>"), self.drop, self.example, self.specimen,
            html("<h2>Law</h2>"), self.law, self.geometry,
            html("<h2>Model</h2>"), self.model, self.other, self.add_other,
            html("<h2>Keep it</h2>"), self.save, self.command,
            width=SIDE,
        )  # fmt: skip

    def given_specimen(self, name: str) -> Specimen | None:
        """The muscle that is typed in, under that name; None where too little is. Raises DataError for no length."""
        values = {key: words.length(field.label, field.value) for key, field in self.fields.items() if field.value}
        if len(values.keys() - {"wall_thickness_mm"}) < 3:
            return None
        return Specimen(name, **values)  # pyright: ignore[reportArgumentType] - lengths and an angle

    def show(self, bench: Bench | None, setup: Setup) -> None:
        """What is asked for now; the model's own lines are the page's."""
        self.command.object = str(words.command(bench))
        self.law.value, self.geometry.value = setup.law, setup.free_geometry
        self.other.options = list(bench.to_add) if bench else []
        self.add_other.disabled = bench is None
        if bench is not None:
            for key, field in self.fields.items():
                value = getattr(bench.record.specimen, key)
                field.value = "" if value is None else f"{value:.10g}"
            self.save.filename = f"{bench.record.name}.html"


def _examples() -> dict[str, str]:
    """Data sets that hold a force record."""
    found = {}
    for name in dataset_names():
        try:
            dataset_record(name)
        except PamError:
            continue
        found[name.replace("_", " ")] = name
    return found
