"""Run fitted models in the closed loop of the leg."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core import DataError, UsageError
from ..core.files import write_whole
from ..effects import Effect, load_effect_files
from ..leg.control import Gains
from ..leg.course import Course
from ..leg.gait import Gait, Window, read_gait
from ..leg.leg_file import DEFAULT, Tables, default_file, read_leg
from ..leg.loop import Loop
from ..leg.mismatch import Mismatch
from ..leg.muscle import Muscle
from ..leg.pair import Pair, pair_of
from ..leg.track import Track, track
from ..leg.treadmill import Treadmill
from ..records import read_specimen
from ..records.datasets import dataset_path

GAITS = {"winter": "winter_stride.csv", "children": "knee_mean_sd.csv"}
PAPER = Window(0.6, 0.2)
"""The paper's 0.2 s; it does not say which. Here the knee bends for the swing."""
MOST_LESSONS = 1000


@dataclass(frozen=True)
class TrackOptions:
    """What `track` is asked; files by path, cadence in Hz, gains in MPa and rad, supply in MPa gauge, load in kg.

    `leg` is a file of numbers over the leg's own; what is said here goes before it. Without `plant` and `controller`
    both are those of the data set `leg_muscle`; with one of them, both are that one. `off` is what flexor and extensor
    are off the fit in per cent of their force, `ageing` what they lose with each stride, `unknown` an effect that the
    plant has besides; `ground` puts the prototype on its feet, `learn` is how many strides the rungs learn from.
    Raises UsageError for one or two of the three gains, and for what cannot be.
    """

    plant: str | None = None
    controller: str | None = None
    gait: str = "winter"
    cadence_Hz: float | None = None
    paper: bool = False
    prototype: bool = False
    gains: tuple[float | None, float | None, float | None] = (None, None, None)
    supply_MPa: float | None = None
    load_kg: float | None = None
    effect_files: tuple[str, ...] = ()
    specimen: str | None = None
    leg: str | None = None
    off: tuple[float, float] | None = None
    ageing: float | None = None
    unknown: str | None = None
    ground: bool = False
    learn: int = 0

    def __post_init__(self) -> None:
        if 0 < sum(g is not None for g in self.gains) < 3:
            raise UsageError("--kp, --ki and --kd go together; give all three, or none to have them tuned")
        if self.supply_MPa is not None and not self.supply_MPa > 0.1:
            raise UsageError(f"--supply {self.supply_MPa}: expected a gauge pressure above 0.1 MPa")
        if self.load_kg is not None and not self.load_kg >= 0.0:
            raise UsageError(f"--load {self.load_kg}: expected a mass of 0 kg or more")
        if self.off is not None and not all(abs(share) <= 80.0 for share in self.off):
            raise UsageError(f"--off {self.off[0]:g} {self.off[1]:g}: expected per cent of force, -80 to 80")
        if self.ageing is not None and not 0.0 <= self.ageing <= 50.0:
            raise UsageError(f"--ageing {self.ageing:g}: expected 0 to 50 per cent of the force in each stride")
        if self.ground and not self.prototype:
            raise UsageError("--ground is that of the prototype; give --prototype, too")
        if not 0 <= self.learn <= MOST_LESSONS:
            raise UsageError(f"--learn {self.learn}: expected 0 to {MOST_LESSONS} strides")

    def tables(self) -> dict[str, dict[str, Any]]:
        """The leg's numbers, from its file and what was said besides. Raises DataError."""
        found = {name: dict(table) for name, table in (read_leg(self.leg) if self.leg else DEFAULT).items()}
        force = None if self.off is None else [1.0 + 0.01 * share for share in self.off]
        ageing = None if self.ageing is None else 0.01 * self.ageing
        given = {
            ("supply", "pressure_MPa"): self.supply_MPa,
            ("load", "mass_kg"): self.load_kg,
            ("muscles", "plant"): self.plant,
            ("muscles", "controller"): self.controller,
            ("off", "force"): force,
            ("off", "ageing"): ageing,
            ("off", "unknown"): self.unknown,
        }
        for (table, key), value in given.items():
            if value is not None:
                found[table][key] = value
        return found


def track_leg(wishes: TrackOptions) -> Track:
    """The tracking error of plain PID and of every rung. Raises DataError, UsageError for files that will not do."""
    extra = load_effect_files(wishes.effect_files)
    tables = wishes.tables()
    plant, controllers = _muscles(tables["muscles"], wishes.specimen, extra)
    known = Loop(_pair(plant, tables, wishes.leg))
    gains = None if None in wishes.gains else Gains(*(g for g in wishes.gains if g is not None))
    course = Course(_gait(wishes), PAPER if wishes.paper else None, wishes.learn)
    off = Mismatch.of(tables["off"], extra)
    ground = Treadmill(**tables["ground"]) if wishes.ground else None
    return track(known, controllers, course, gains, wishes.prototype, off=off, ground=ground)


def write_leg(path: str) -> None:
    """Write the leg's own file, to begin from. Raises DataError where it cannot be written."""
    write_whole(path, default_file().read_text(encoding="utf-8"))


def _pair(plant: Muscle, tables: Tables, path: str | None) -> Pair:
    try:
        return pair_of(plant, tables)
    except UsageError as error:
        raise DataError(f"{path}: [knee] {error}") from None


def _muscles(table: Mapping[str, Any], specimen: str | None, extra: tuple[Effect, ...]) -> tuple[Muscle, list[Muscle]]:
    given = read_specimen(specimen) if specimen is not None else None
    plant, controller = (table.get(key) for key in ("plant", "controller"))
    plant, controller = plant or controller, controller or plant
    if plant is None or controller is None:
        folder = dataset_path("leg_muscle")
        plant, controller = str(folder / "plant.json"), str(folder / "ladder.json")
    return Muscle.read(plant, given, extra)[-1], Muscle.read(controller, given, extra)


def _gait(wishes: TrackOptions) -> Gait:
    path = dataset_path("gait") / GAITS[wishes.gait] if wishes.gait in GAITS else Path(wishes.gait)
    if not path.is_file():
        raise UsageError(f"--gait {wishes.gait}: expected {', '.join(GAITS)} or a CSV file with a column knee_deg")
    return read_gait(path, wishes.cadence_Hz)
