"""Units at the border: what a file may be written in, and the factor to the internal unit."""

import re

from .errors import DataError

_FACTORS = {
    "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0, "day": 86400.0},
    "pressure": {
        "MPa": 1.0,
        "kPa": 1e-3,
        "Pa": 1e-6,
        "bar": 0.1,
        "mbar": 1e-4,
        "hPa": 1e-4,
        "psi": 6.894757293168361e-3,
    },
    "length": {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 1e-3, "in": 25.4},
    "force": {"N": 1.0, "kN": 1000.0, "mN": 1e-3, "daN": 10.0, "lbf": 4.4482216152605, "kgf": 9.80665, "kg": 9.80665},
    "temperature": {"C": 1.0, "degC": 1.0, "K": 1.0, "degF": 5.0 / 9.0},
    "ratio": {"1": 1.0, "-": 1.0, "pct": 0.01, "%": 0.01},
}
_OFFSETS = {"K": -273.15, "degF": -160.0 / 9.0}
TO_INTERNAL = {
    dimension: {unit: (factor, _OFFSETS.get(unit, 0.0)) for unit, factor in units.items()}
    for dimension, units in _FACTORS.items()
}
"""Dimension → unit → (factor, offset): internal = factor · value + offset."""

ATMOSPHERE_MPA = 0.101325
"""What is taken off an absolute pressure."""
_STRANGE = frozenset(
    ["lb", "lbs", "ozf", "g", "gf", "kp", "ft", "inch", "ksi", "atm", "torr", "mmhg", "inhg", "mv", "hr", "us", "d"]
)
"""Units of other programs, as a suffix: in brackets, whatever is not known is one."""
_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\[\]()]*(?:\([^\[\]()]*\))?[^\[\]()]*)\s*[\])]\s*$")
_AGAINST = re.compile(r"^(?P<unit>.+?)[ _]*\(?(?:(?P<air>a|abs|absolute)|g|gauge|rel|relative)\)?\.?$", re.IGNORECASE)
"""A unit of pressure with what it counts from: `bara`, `bar abs`, `bar(g)`, `kPa_gauge`."""
_AGAINST_SUFFIX = re.compile(
    r"^(?P<name>.+)[_ ](?P<unit>[A-Za-z]+[_ ](?:abs|absolute|gauge|rel|relative))$", re.IGNORECASE
)
_MICRO = str.maketrans("µμ", "uu")
"""The sign for micro, and the Greek letter that looks like it."""
_ABSOLUTE = re.compile(r"[\W_]*(?<![^\W_])abs(?:olut(?:e[nr]?)?)?(?=druck|[\W\d_]|$)[\W_]*", re.IGNORECASE)
"""The word before a unit of pressure that makes it absolute: `p_abs`, `Absolutdruck`, `absolute pressure`."""


def split_header(header: str, loose: bool = False) -> tuple[str, str | None]:
    """Name (lower case, words joined by _) and unit of a column header: `Pressure [bar]`, `force_N`, `Time, s`,
    `Weg / mm`, `Load in N`; where `loose`, because a word says what it is, also `Kraft N` and `F/N`.

    A pressure whose name says that it is absolute has its unit so: `p_abs [bar]` is p in `bar abs`.
    """
    name, unit = _parted(header.strip().translate(_MICRO), loose)
    spaced = re.sub(r"([a-zäöü])([A-ZÄÖÜ])", r"\1 \2", name)
    if unit and _ABSOLUTE.search(spaced) and _against(f"{unit} abs"):
        return _snake(_ABSOLUTE.sub(" ", spaced)), f"{unit} abs"
    return _snake(name), unit


def _parted(text: str, loose: bool) -> tuple[str, str | None]:
    found = _BRACKETS.match(text)
    if found:
        return found["name"], found["unit"].replace("°F", "degF").replace("°", "") or None
    found = _AGAINST_SUFFIX.match(text)
    if found and is_unit(found["unit"]):
        return found["name"].removesuffix(" /").removesuffix(" in"), found["unit"]
    for mark in (" / ", " in ", "_", ",", *("/", " ") * loose):
        name, _, last = (part.strip() for part in text.rpartition(mark))
        other = is_unit(name.split(" ")[-1]) if mark == "/" else mark == " " and last in ("1", "-")  # `mm/s`, `Run 1`
        if name and is_unit(last) and not other:
            return name, last
    return text, None


def strange_unit(header: str) -> str | None:
    """What a header has for a unit, in brackets, `P (V)`, or at its end, `mass_lb`, that is none of those known."""
    found = _BRACKETS.match(header.strip())
    unit = found["unit"].strip().replace("°", "") if found else header.strip().rpartition("_")[2]
    strange = not is_unit(unit) if found else "_" in header and unit.lower() in _STRANGE
    return unit if unit and strange else None


def is_unit(text: str) -> bool:
    """Whether a text is a unit, in whatever case."""
    known = {unit.lower() for units in TO_INTERNAL.values() for unit in units}
    return text.translate(_MICRO).lower() in known or _against(text) is not None


def conversion(dimension: str, unit: str | None, where: str) -> tuple[float, float]:
    """Factor and offset from `unit` to the internal unit of `dimension`; `where` names the column in errors.

    Raises DataError for a unit that is missing or not of that dimension.
    """
    table = TO_INTERNAL[dimension]
    if unit is None and dimension == "ratio":
        return (1.0, 0.0)
    if unit in table:
        return table[unit]
    folded = {key.lower(): value for key, value in table.items() if key not in ("mN", "MPa", "mbar")}
    folded |= {"mpa": table["MPa"]} if dimension == "pressure" else {}
    if unit is not None and unit.lower() in folded:
        return folded[unit.lower()]
    if unit is not None and dimension == "pressure" and (found := _against(unit)):
        return found
    given = "no unit given" if unit is None else f"unknown unit {unit!r}"
    raise DataError(
        f"{where}: {given}; expected one of {', '.join(table)} for a {dimension} (as suffix or in brackets)"
    )


def known_scale(dimension: str, unit: str | None) -> tuple[float, float] | None:
    """Factor and offset of a unit, None for none and for one that is not of that dimension."""
    try:
        return None if unit is None or dimension not in TO_INTERNAL else conversion(dimension, unit, "")
    except DataError:
        return None


def is_absolute(unit: str | None) -> bool:
    """Whether a unit of pressure counts from vacuum."""
    return unit is not None and (found := _against(unit)) is not None and found[1] != 0.0


def _against(unit: str) -> tuple[float, float] | None:
    """Factor and offset of a unit of pressure that says what it counts from; None for any other."""
    table = TO_INTERNAL["pressure"]
    found = None if unit in table or unit.lower() in map(str.lower, table) else _AGAINST.match(unit)
    if found is None:
        return None
    folded = (one for name, one in table.items() if name.lower() == found["unit"].lower())
    known = table.get(found["unit"]) or next(folded, None)
    return known and (known[0], -ATMOSPHERE_MPA if found["air"] else 0.0)


def _snake(text: str) -> str:
    return re.sub(r"[\s_]+", "_", text.strip().lower())
