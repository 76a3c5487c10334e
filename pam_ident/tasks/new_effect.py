"""A commented scaffold of a user's own effect."""

import keyword
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from ..core import UsageError
from ..core.files import check_target, write_whole
from ..effects import catalogue

ROLES = {
    "adds_force": {
        "size": 'SIZE = Param("A", "N", "force at full length", -1000.0, 1000.0, scale=10.0)',
        "columns": 'xp.exp(-inputs.displacement_mm / values["length"])[:, None]',
        "form": 'AddsForce("textbook", "+A exp(−x/length)", (SIZE,), _columns, (LENGTH,))',
    },
    "scales_force": {
        "size": 'SIZE = Param("k", "1", "loss of force per contraction", -3.0, 3.0, scale=0.05)',
        "columns": "-inputs.contraction[:, None]",
        "form": 'ScalesForce("textbook", "F → F (1 − k ε)", (SIZE,), _columns)',
    },
    "transforms_pressure": {
        "size": 'SIZE = Param("g", "1", "error of the gauge, as a share", -0.5, 0.5, scale=0.02)',
        "columns": "inputs.pressure[:, None]",
        "form": 'TransformsPressure("textbook", "p → p (1 + g)", (SIZE,), _columns)',
    },
    "transforms_contraction": {
        "size": 'SIZE = Param("s", "1", "slack of the clamps, as a share of the stroke", -0.5, 0.5, scale=0.02)',
        "columns": "-inputs.contraction[:, None]",
        "form": 'TransformsContraction("textbook", "ε → ε (1 − s)", (SIZE,), _columns)',
    },
}
"""Examples of what an effect may do to a law, as source text; a form begins with its class."""


def new_effect(file: str | Path, name: str | None = None, role: str = "adds_force") -> str:
    """Write the scaffold of an effect that loads and keeps the contract as it is; the effect's name.

    `name` defaults to the file's. Raises UsageError for a file that is there already or cannot be written, and for a
    name that is no Python name or is taken by a known effect.
    """
    path = check_target(file, (".py",))
    if path.exists():
        raise UsageError(f"{path}: is there already and stays as it is; name another file, or take it away first")
    given = name if name is not None else path.stem
    if not given.isidentifier() or keyword.iskeyword(given) or "__" in given:
        hint = "" if name is not None else "; give one by --name"
        raise UsageError(
            f"effect {given!r}: expected letters, digits and single underscores, as in spindle_ripple{hint}"
        )
    if given in catalogue():
        raise UsageError(f"effect {given!r} is known already; take another name, or `pam-ident effects show {given}`")
    template = Environment(
        loader=PackageLoader("pam_ident.tasks", ""), undefined=StrictUndefined, keep_trailing_newline=True
    )
    text = template.get_template("effect.py.j2").render(
        file=path.name,
        name=given,
        title=given.replace("_", " "),
        role=role,
        classes=sorted([ROLES[role]["form"].partition("(")[0], "Effect"]),
        **ROLES[role],
    )
    write_whole(path, text)
    return given
