"""Our parameters as lmfit's, and back: lmfit's names must be identifiers, ours hold a dot after an effect's name."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from .errors import UsageError
from .param import Param

if TYPE_CHECKING:
    import lmfit


def to_lmfit_name(name: str) -> str:
    """`effect.parameter` as `effect__parameter`. Raises UsageError where two underscores are there already."""
    if "__" in name:
        raise UsageError(f"parameter {name}: lmfit is given a dot as two underscores; name it with single ones")
    return name.replace(".", "__")


def to_parameters(values: "Iterable[tuple[Param, float]]") -> "lmfit.Parameters":
    """lmfit's Parameters with our bounds, each at its value. Raises UsageError as `to_lmfit_name` does."""
    import lmfit

    found = lmfit.Parameters()
    for p, value in values:
        found.add(to_lmfit_name(p.name), value=value, min=p.lower, max=p.upper)
    return found


def from_lmfit_names(values: Mapping[str, float]) -> dict[str, float]:
    """Values by our names; takes lmfit's `Parameters.valuesdict()` too."""
    return {name.replace("__", "."): float(value) for name, value in values.items()}
