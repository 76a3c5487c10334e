"""What differs from run to run of one record, as [runs] of a columns.toml says: `[runs."run3.csv"] length_mm = 252`."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..core import DataError, Specimen
from ..core.units import split_header
from .quantities import QUANTITIES, Source, quantity_of, scale_of
from .ranges import Values
from .specimen_file import read_specimen

Constant = float | str
GRAVITY = 9.80665
LOADS = {"load_N": 1.0, "load_kg": GRAVITY}
MASSES = ("load_kg", "mass_kg")
"""Names of a mass that hangs on the muscle: what is accelerated with it."""
NEEDED = {"pressure", "force", "load", "displacement", "contraction", "length"}
"""What each run must have, as a constant or in a column of its own."""
LENGTH, SPECIMEN = "initial_length_mm", "specimen"


@dataclass(frozen=True)
class Runs:
    """Constants by the name of the run's file, of the columns.toml at `path`."""

    path: str
    constants: Mapping[str, Mapping[str, Constant]]

    def check(self, folder: Path, names: list[str], elsewhere: set[str]) -> None:
        """Raises DataError for a run that is no file, and for one that lacks what others have, but for what it may have
        in a column; quantities given `elsewhere` for all runs may be left out."""
        for name in self.constants:
            if not (folder / name).is_file():
                raise DataError(f"{self.path}: [runs.{name!r}], but {folder} has no such file; fix the name")
        given = {name: {_what(key): key for key in self.constants.get(name, ())} for name in names}
        needed = {what: key for keys in given.values() for what, key in keys.items() if what not in elsewhere | NEEDED}
        for name, keys in given.items():
            if lacking := sorted(set(needed) - set(keys)):
                raise DataError(f"{self.path}: {needed[lacking[0]]} is given for other runs, not for {name!r}; add it")

    def sources(self, name: str, has_force: bool) -> dict[str, Source]:
        """The quantities that are constant in a run; its load is the force where no column is."""
        found = {}
        for key, value in self.constants.get(name, {}).items():
            if isinstance(value, str) or key == LENGTH:
                continue
            told = f"{key} = {value:g} by {self.path}"
            if key in LOADS:
                if not has_force:
                    found["force"] = Source(told, None, value=value * LOADS[key])
                continue
            quantity, unit = split_header(key)
            factor, offset = scale_of(quantity, unit, f"{self.path}, {key}")
            found[quantity] = Source(told, None, value=value * factor + offset)
        return found

    def initial_length_mm(self, name: str, folder: Path, specimen: Specimen) -> float:
        """The initial length of a run's muscle. Raises DataError where that is another muscle than the record's."""
        given = self.constants.get(name, {})
        if isinstance(file := given.get(SPECIMEN), str):
            own = read_specimen(folder / file)
            for what in ("initial_radius_mm", "braid_angle_deg", "wall_thickness_mm"):
                if getattr(own, what) != getattr(specimen, what):
                    raise DataError(
                        f"{self.path}: {name!r} is of another muscle ({what} {getattr(own, what)}, the record's "
                        f"{getattr(specimen, what)}); give it a record of its own"
                    )
            return own.initial_length_mm
        return float(given.get(LENGTH, specimen.initial_length_mm))


def _what(key: str) -> str:
    """What a key says, whatever its unit."""
    return "initial length" if key in (LENGTH, SPECIMEN) else "load" if key in LOADS else split_header(key)[0]


def read_runs(path: str | Path, table: object) -> Runs:
    """[runs] of a columns.toml. Raises DataError for what it cannot mean."""
    known = f"{LENGTH}, {SPECIMEN}, {', '.join(LOADS)}, or a quantity with its unit such as length_mm"
    if not isinstance(table, dict) or not all(isinstance(one, dict) for one in table.values()):
        raise DataError(f"{path}: [runs] needs a table for each file, such as [runs.'run3.csv'] with {known}")
    for name, constants in table.items():
        for key, value in constants.items():
            number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e12
            names = key in (LENGTH, *LOADS) or (quantity_of(key) and QUANTITIES[split_header(key)[0]] != "text")
            if not (isinstance(value, str) if key == SPECIMEN else number and names):
                raise DataError(f"{path}: [runs.{name!r}] {key} = {value!r}; expected a number for {known}")
            if key == LENGTH and value <= 0:
                raise DataError(f"{path}: [runs.{name!r}] {key} = {value!r}; expected above 0")
        if LENGTH in constants and SPECIMEN in constants:
            raise DataError(f"{path}: [runs.{name!r}] has {LENGTH} and a specimen; keep one")
        if len(set(LOADS) & set(constants)) > 1:
            raise DataError(f"{path}: [runs.{name!r}] gives the load twice; keep one")
    return Runs(str(path), table)


def on_length(values: Values, own_mm: float, length_mm: float) -> Values:
    """The values of a run with ways and lengths as if its muscle were `length_mm` long: the same contraction."""
    if own_mm == length_mm:
        return values
    ways = ("displacement", "length")
    return {key: column * (length_mm / own_mm) if key in ways else column for key, column in values.items()}
