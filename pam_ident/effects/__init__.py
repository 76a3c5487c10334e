"""Physical effects a law may lack, one a file.

A file that defines EFFECT brings everything with it: listing, candidacy in the diagnosis, contract
tests. Other packages add theirs by the entry point group `pam_ident.effects`, a user by
`--effect-file FILE.py`.
"""

from collections.abc import Iterable
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

from ..core import UsageError
from ..core.discover import instances, instances_in
from ..core.nearest import unknown
from .base import AddsForce, Effect, Form, ScalesForce, TransformsContraction, TransformsPressure

__all__ = [
    "AddsForce",
    "Effect",
    "Form",
    "ScalesForce",
    "TransformsContraction",
    "TransformsPressure",
    "catalogue",
    "get_effect",
    "in_words",
    "listed",
    "load_effect_file",
    "load_effect_files",
    "named",
]


@cache
def _packaged() -> dict[str, Effect]:
    found = {effect.name: effect for effect in instances(__name__, __path__, Effect)}
    for point in entry_points(group="pam_ident.effects"):
        effect = point.load()
        if isinstance(effect, Effect):
            found[effect.name] = effect
    return found


def catalogue(extra: tuple[Effect, ...] = ()) -> dict[str, Effect]:
    """Every effect by name: the package's, those of installed packages (entry points `pam_ident.effects`), and more.

    Args:
        extra: effects of the user's own, such as `load_effect_file` gives; one of a known name takes its place.

    Example:
        >>> from pam_ident.effects import catalogue
        >>> known = catalogue()
        >>> print(known["creep"].title, "needs", known["creep"].needs)
        creep and stress relaxation needs ('motion', 'time')
    """
    return _packaged() | {effect.name: effect for effect in extra}


def listed(extra: tuple[Effect, ...] = ()) -> tuple[Effect, ...]:
    """Every effect of the catalogue in the order of its name."""
    return tuple(effect for _, effect in sorted(catalogue(extra).items()))


def in_words(label: str, extra: Iterable[Effect] = ()) -> str:
    """What a sentence calls an effect, `name` or `name:form`: its title, or the label where it is none of these.

    Args:
        label: what is typed after `--effect`.
        extra: effects beside the catalogue's, such as a model's own.

    Example:
        >>> from pam_ident.effects import in_words
        >>> print(in_words("pressure_friction:contact_area"))
        friction that grows with pressure
    """
    effect = catalogue(tuple(extra)).get(label.partition(":")[0])
    return effect.title if effect else label


def named(label: str, extra: Iterable[Effect] = ()) -> str:
    """The same with what is typed in brackets: `friction that grows with pressure (pressure_friction)`."""
    words = in_words(label, extra)
    return label if words == label else f"{words} ({label})"


def get_effect(name: str, extra: tuple[Effect, ...] = ()) -> tuple[Effect, Form]:
    """An effect and one of its forms.

    Args:
        name: `effect` for its simplest form, or `effect:form`.
        extra: effects of the user's own.

    Raises:
        UsageError: for an unknown name, with those that look like it.

    Example:
        >>> from pam_ident.effects import get_effect
        >>> effect, form = get_effect("coulomb_friction")
        >>> print(f"{effect.title}: {form.formula}, {form.params[0].name} in {form.params[0].unit}")
        Coulomb friction: −F_c sgn(ε̇), F_c in N
    """
    base, _, form = name.partition(":")
    known = catalogue(extra)
    if base not in known:
        raise UsageError(unknown("effect", base, known, "`pam-ident effects`"))
    effect = known[base]
    if not form:
        return effect, effect.forms[0]
    for item in effect.forms:
        if item.name == form:
            return effect, item
    raise UsageError(f"effect {base} has no form {form!r}; it has {', '.join(f.name for f in effect.forms)}")


def load_effect_files(paths: Iterable[str | Path]) -> tuple[Effect, ...]:
    """Effects of several files, as `load_effect_file`."""
    return tuple(effect for path in paths for effect in load_effect_file(path))


def load_effect_file(path: str | Path) -> tuple[Effect, ...]:
    """The effects that a user's Python file defines.

    Args:
        path: the file; each name in capitals that is bound to an Effect counts.

    Raises:
        UsageError: when the file cannot be run or defines none.

    Example:
        >>> from pam_ident.effects import load_effect_file
        >>> from pam_ident.tasks.new_effect import new_effect
        >>> new_effect("squeak.py")  # writes a scaffold to begin with
        'squeak'
        >>> (mine,) = load_effect_file("squeak.py")
        >>> print(mine.name, mine.forms[0].formula)
        squeak +A exp(−x/length)
    """
    return tuple(instances_in(path, Effect))
