"""Run fitted models in the closed loop of the leg."""

from dataclasses import dataclass, replace
from pathlib import Path

from ..core import UsageError
from ..effects import load_effect_files
from ..leg.anatomy import LEG
from ..leg.control import Gains
from ..leg.course import Course
from ..leg.gait import Gait, Window, read_gait
from ..leg.loop import Loop
from ..leg.muscle import Muscle
from ..leg.pair import SUPPLY, Pair
from ..leg.pneumatics import ATMOSPHERE
from ..leg.track import Track, track
from ..records import read_specimen
from ..records.datasets import dataset_path

GAITS = {"winter": "winter_stride.csv", "children": "knee_mean_sd.csv"}
PAPER = Window(0.6, 0.2)
"""The paper's 0.2 s; it does not say which. Here the knee bends for the swing."""


@dataclass(frozen=True)
class TrackOptions:
    """What `track` is asked; files by path, cadence in Hz, gains in MPa and rad, supply in MPa gauge, load in kg.

    Without `plant` and `controller` both are those of the data set `leg_muscle`; with one of them, both are that one.
    Raises UsageError for one or two of the three gains, and for a supply or a load that cannot be.
    """

    plant: str | None = None
    controller: str | None = None
    gait: str = "winter"
    cadence_Hz: float | None = None
    paper: bool = False
    prototype: bool = False
    gains: tuple[float | None, float | None, float | None] = (None, None, None)
    supply_MPa: float = 0.7
    load_kg: float = 0.0
    effect_files: tuple[str, ...] = ()
    specimen: str | None = None

    def __post_init__(self) -> None:
        if 0 < sum(g is not None for g in self.gains) < 3:
            raise UsageError("--kp, --ki and --kd go together; give all three, or none to have them tuned")
        if not self.supply_MPa > 0.1:
            raise UsageError(f"--supply {self.supply_MPa}: expected a gauge pressure above 0.1 MPa")
        if not self.load_kg >= 0.0:
            raise UsageError(f"--load {self.load_kg}: expected a mass of 0 kg or more")


def track_leg(wishes: TrackOptions) -> Track:
    """The tracking error of plain PID and of every rung. Raises DataError, UsageError for files that will not do."""
    plant, controllers = _muscles(wishes)
    leg = replace(LEG, load_mass_kg=wishes.load_kg)
    supply = replace(SUPPLY, pressure_Pa=wishes.supply_MPa * 1e6 + ATMOSPHERE)
    loop = Loop(Pair(plant, leg, supply))
    gains = None if None in wishes.gains else Gains(*(g for g in wishes.gains if g is not None))
    course = Course(_gait(wishes), PAPER if wishes.paper else None)
    return track(loop, controllers, course, gains, prototype=wishes.prototype)


def _muscles(wishes: TrackOptions) -> tuple[Muscle, list[Muscle]]:
    extra = load_effect_files(wishes.effect_files)
    specimen = read_specimen(wishes.specimen) if wishes.specimen is not None else None
    plant, controller = wishes.plant or wishes.controller, wishes.controller or wishes.plant
    if plant is None or controller is None:
        folder = dataset_path("leg_muscle")
        plant, controller = str(folder / "plant.json"), str(folder / "ladder.json")
    return Muscle.read(plant, specimen, extra)[-1], Muscle.read(controller, specimen, extra)


def _gait(wishes: TrackOptions) -> Gait:
    path = dataset_path("gait") / GAITS[wishes.gait] if wishes.gait in GAITS else Path(wishes.gait)
    if not path.is_file():
        raise UsageError(f"--gait {wishes.gait}: expected {', '.join(GAITS)} or a CSV file with a column knee_deg")
    return read_gait(path, wishes.cadence_Hz)
