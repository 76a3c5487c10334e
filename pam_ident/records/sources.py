"""Which column of a table holds which quantity: by its name, else by word and unit where that leaves no choice."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from ..core import DataError
from ..core.units import TO_INTERNAL, is_absolute, known_scale, split_header
from .guess import by_name, guess_table, numbers_of, told_by
from .joint_lever import joint_of, lever_of
from .quantities import QUANTITIES, SHAPES, Source, quantity_of, scale_of
from .run_constants import GRAVITY, MASSES
from .table import Clock, Table, numbers_in, without_unit

_CLOCK = re.compile(r"[hms:.,0fdyYMDHTZ \-]*:[hms:.,0fzTZ ]*", re.IGNORECASE)
"""What stands for a unit above clock times: `hh:mm:ss.000`, `YYYY-MM-DD hh:mm:ss`."""
Finder = Callable[[Table], dict[str, Source]]
"""Finds the columns of a table without a columns.toml. Raises DataError."""
BACKWARDS = 0.1
"""Share of the steps of a clock, guessed by its name, that may run backwards: more are no clock's, unless its rows were
shuffled."""
EVEN = 3.0
"""Mean over median of the steps between sorted values, all different, up to which they are the ticks of a clock."""
NAMES = {"pressure": "pressure_MPa", "force": "force_N", "displacement": "displacement_mm"}


def find_sources(table: Table, constants: Mapping[str, Source] | None = None) -> dict[str, Source]:
    """The columns of a table by name and unit, and the `constants` of its run. Raises DataError where one is missing,
    doubled, or of unknown unit; of units it names all that are wrong."""
    found: dict[str, int] = {}
    for position, header in enumerate(table.headers):
        name = quantity_of(header)
        if name is None:
            continue
        if name in found:
            first = table.headers[found[name]]
            if first == header:
                raise DataError(f"{table.head}: two columns are called {header!r}; keep one")
            raise DataError(f"{table.place}: columns {first!r} and {header!r} are both {name}; keep one")
        found[name] = position
    _refuse_unknown_units(table, found)
    constants = constants or {}
    guessed = _guessed(table, {*found, *constants})
    held = [*found, *guessed, *constants]
    check_complete(held, table.head, table.headers, _ready(table, constants) if _lacking(held) else "")
    sources: dict[str, Source] = {}
    wrong: list[str] = []
    for name, position in (found | guessed).items():
        header, guess = table.headers[position], name in guessed
        unit = split_header(header, loose=guess)[1]
        if name == "time" and (unit is None or _CLOCK.fullmatch(unit)):
            sources[name] = Source(header, position, unit_missing=True, guessed=guess)
            continue
        mass = guess and _is_mass(header)
        try:
            scale = (GRAVITY, 0.0) if mass else scale_of(name, unit, f"column {header!r}")
        except DataError as error:
            wrong.append(str(error))
            continue
        sources[name] = Source(header, position, *scale, absolute=is_absolute(unit), guessed=guess)
    if wrong:
        raise DataError(f"{table.place}, {'; '.join([*_clock_without_unit(table, sources), *wrong])}")
    for name, source in constants.items():
        if name in sources:
            raise DataError(f"{table.head}: {name} is a column, and {source.header}; keep one")
    return check_shape(sources | dict(constants), table.head)


def _clock_without_unit(table: Table, sources: Mapping[str, Source]) -> list[str]:
    """What is wrong with a time that states no unit, if it is not of clock times, by its first rows."""
    time = sources.get("time")
    if time is None or time.position is None or not time.unit_missing:
        return []
    numbers = numbers_of(table, [time.position])[0]
    if not np.isfinite(numbers).any():
        return []
    return [without_unit(time.header, numbers)]


def find_states(table: Table) -> dict[str, Source]:
    """The same of a table of states, which need no force, or no shape where a force is what is carried. What is not
    there is 0, by a source without a header; of loads the motion is not known, and no time is taken."""
    given, lacking = {by_name(header) for header in table.headers}, Source("", None)
    if "force" not in given:
        return find_sources(table, {"force": lacking})
    if given & {*SHAPES}:
        return find_sources(table)
    found = find_sources(table, {"contraction": lacking})
    return {name: one for name, one in found.items() if name not in ("time", "cycle", "pressure_set")}


def _guessed(table: Table, found: set[str]) -> dict[str, int]:
    """The columns of what is needed, of the time and the temperature, as far as none is `found`, of which word and unit
    leave no choice: a unit of pressure, force or time decides where one column has it, others need their word."""
    names = [by_name(header) if _states(header) else "" for header in table.headers]
    guessed: dict[str, int] = {}
    doubtful = {"time": _runs_on, "temperature": _filled}
    for needed in (("time",), ("pressure",), ("force",), SHAPES, ("temperature",)):
        at = [k for k, name in enumerate(names) if name in needed]
        is_it = doubtful.get(needed[0])
        if len(at) == 1 and not found & set(needed) and (is_it is None or is_it(table, at[0])):
            guessed[names[at[0]]] = at[0]
    masses = [k for k, header in enumerate(table.headers) if _is_mass(header)]
    if len(masses) == 1 and "force" not in found and "force" not in names:
        guessed["force"] = masses[0]
    return guessed


def _states(header: str) -> bool:
    """Whether a header states a unit that its quantity can have. A ratio needs none, nor does a clock by a whole word:
    its cells may be clock times, or are refused."""
    quantity, (name, unit) = by_name(header), split_header(header, loose=True)
    if quantity == "time" and (unit is None or _CLOCK.fullmatch(unit)):
        return len(name) > 1
    dimension = QUANTITIES.get(quantity, "text")
    return known_scale(dimension, unit) is not None or (dimension == "ratio" and unit is None)


def _is_mass(header: str) -> bool:
    return header.strip().lower() in MASSES


def _filled(table: Table, position: int) -> bool:
    """Whether a column that may be left out has a number in each of its first rows: its empty cells would cost rows."""
    return bool(np.isfinite(numbers_of(table, [position])[0]).all())


def _runs_on(table: Table, position: int) -> bool:
    """Whether a column called a time is the rows' clock, not a duration: it goes on, or would if sorted, by its first
    rows."""
    block = next(iter(table.read([position])), None)
    if block is None or not len(block):
        return False
    seconds = numbers_in(block.cells[position], "time", table.decimal, Clock()).values
    seconds = seconds[np.isfinite(seconds)]
    steps, apart = np.diff(seconds), np.diff(np.unique(seconds))
    if not np.any(steps > 0.0):
        return False
    shuffled = len(apart) == len(steps) and np.mean(apart) < EVEN * np.median(apart)
    return bool(shuffled or np.mean(steps < 0.0) < BACKWARDS)


def passed_over(table: Table, sources: Mapping[str, Source]) -> tuple[int, ...]:
    """Positions of the columns that are not read; those without a header left out."""
    read = {source.position for source in sources.values()}
    return tuple(k for k, header in enumerate(table.headers) if header and k not in read)


def _ready(table: Table, given: Iterable[str]) -> str:
    """What a columns.toml would say of what is not `given` if guesses were right, by numbers too; empty where no column
    is left to guess. Letters that none has tell that the file's encoding must be said first."""
    if all(map(quantity_of, table.headers)):
        return ""
    if any("\x80" <= letter < "\xa0" or letter == "\xad" for letter in "".join(table.headers)):
        return (
            "\nThe header is written in another encoding. Say which in a columns.toml: [file] encoding = 'shift_jis' "
            "(Japanese), 'gb18030' (Chinese), 'euc_kr', 'cp1251' (Cyrillic) or its name"
        )
    try:
        guesses = guess_table(table)
    except DataError:  # of a row: what is wrong with the header is told first
        return ""
    shape = next((k for k, header in enumerate(table.headers) if by_name(header) in SHAPES), None)
    joint = joint_of(table.headers)
    held = [k for k, g in enumerate(guesses) if g.quantity and (g.quantity not in SHAPES or shape in (None, k))]
    held = [k for k in held if k not in joint.values()]
    lines = [told_by(table.names, table.headers, k, guesses[k]) for k in held]
    known = [*given, *(guesses[k].quantity for k in held), *("force", "displacement") * bool(joint)]
    lines += [f'{NAMES[what]} = "?"' for what in _lacking(known)]
    named = {guesses[k].quantity for k in held}
    others = [(header, by_name(header, lengths=True)) for k, header in enumerate(table.headers) if k not in held]
    passed = ", ".join(f"{header!r} ({quantity})" for header, quantity in others if quantity in named)
    also = f", which passes over {passed[:200]}" if passed else ""
    text = f"columns = {{{', '.join(lines)}}}"
    if joint:
        text += f" and, on a line of its own, {lever_of(table.names, joint)}"
    fill = ", once each ? is filled in," * ('"?"' in text)
    return f"\nIf the guess is right{also}, the columns.toml{fill} is: {text}"


def check_shape(sources: dict[str, Source], head: str) -> dict[str, Source]:
    """The sources. Raises DataError where pressure, force or shape is missing, or the shape is there twice."""
    check_complete([*sources], head, [source.header for source in sources.values()])
    shapes = [sources[key].header for key in SHAPES if key in sources]
    if len(shapes) > 1:
        raise DataError(f"{head}: columns {' and '.join(shapes)} say the same thing; keep one")
    return sources


def _refuse_unknown_units(table: Table, found: dict[str, int]) -> None:
    """A name with a suffix that is no unit is a slip where nothing else gives the quantity."""
    for header in table.headers:
        name, _, unit = split_header(header)[0].rpartition("_")
        said = known_scale(QUANTITIES.get(name, ""), split_header(header, loose=True)[1])
        if name in QUANTITIES and name not in found and quantity_of(header) is None and said is None:
            raise DataError(
                f"{table.head}, column {header!r}: unknown unit {unit!r} for {name}; expected one of "
                f"{', '.join(TO_INTERNAL.get(QUANTITIES[name], ()))}, or another name if it is something else"
            )


def _lacking(found: Sequence[str]) -> list[str]:
    """What of pressure, force and shape is not among the quantities found."""
    return [what for what in NAMES if what not in found and (what in ("pressure", "force") or not {*found} & {*SHAPES})]


def check_complete(found: Sequence[str], head: str, headers: Sequence[str], ready: str = "") -> None:
    """Raise DataError where pressure, force or the muscle's shape is missing, all of them at once; `ready` is a further
    line that helps."""
    lacking = _lacking(found)
    if not lacking:
        return
    there = f"among {', '.join(map(repr, headers))[:300]}"
    for what in lacking:
        those = [h for h in headers if by_name(h) in (SHAPES if what == "displacement" else (what,))]
        there += f" ({' and '.join(map(repr, those))} may each be the {what})" if len(those) > 1 else ""
    cure = "or say in a columns.toml beside the file which it is"
    if "force" in lacking:
        cure += " (of a weight that hangs in FILE: [runs.'FILE'] load_kg = 5)"
    if lacking == ["displacement"]:
        what = "displacement_mm, contraction, contraction_pct or length_mm column"
        raise DataError(f"{head}: no {what} {there}; name one of them so, {cure}.{ready}")
    what, name = " and no ".join(lacking), " and ".join(NAMES[what] for what in lacking)
    raise DataError(f"{head}: no {what} column {there}; name it {name} (or with another unit), {cure}.{ready}")
