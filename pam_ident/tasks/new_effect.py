"""A commented scaffold of a user's own effect."""

import keyword
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from ..core import UsageError
from ..core.files import check_target, write_whole
from ..effects import catalogue


@dataclass(frozen=True)
class Role:
    """What an effect does to a law, with an example of it as source text."""

    type: str
    size: str
    columns: str
    form: str


ROLES = {
    "adds_force": Role(
        "AddsForce",
        'SIZE = Param("A", "N", "force at full length", -1000.0, 1000.0, scale=10.0)',
        'xp.exp(-inputs.displacement_mm / values["length"])[:, None]',
        'AddsForce("textbook", "+A exp(−x/length)", (SIZE,), _columns, (LENGTH,))',
    ),
    "scales_force": Role(
        "ScalesForce",
        'SIZE = Param("k", "1", "loss of force per contraction", -3.0, 3.0, scale=0.05)',
        "-inputs.contraction[:, None]",
        'ScalesForce("textbook", "F → F (1 − k ε)", (SIZE,), _columns)',
    ),
    "transforms_pressure": Role(
        "TransformsPressure",
        'SIZE = Param("g", "1", "error of the gauge, as a share", -0.5, 0.5, scale=0.02)',
        "inputs.pressure[:, None]",
        'TransformsPressure("textbook", "p → p (1 + g)", (SIZE,), _columns)',
    ),
    "transforms_contraction": Role(
        "TransformsContraction",
        'SIZE = Param("s", "1", "slack of the clamps, as a share of the stroke", -0.5, 0.5, scale=0.02)',
        "-inputs.contraction[:, None]",
        'TransformsContraction("textbook", "ε → ε (1 − s)", (SIZE,), _columns)',
    ),
}


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
    example = ROLES[role]
    template = Environment(
        loader=PackageLoader("pam_ident.tasks", ""), undefined=StrictUndefined, keep_trailing_newline=True
    )
    text = template.get_template("effect.py.j2").render(
        file=path.name,
        name=given,
        title=given.replace("_", " "),
        role=role,
        classes=sorted([example.type, "Effect"]),
        size=example.size,
        columns=example.columns,
        form=example.form,
    )
    write_whole(path, text)
    return given
