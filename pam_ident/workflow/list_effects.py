"""The effects that are known."""

from ..effects import Effect, catalogue, get_effect, load_effect_file


def list_effects(effect_files: tuple[str, ...] = ()) -> tuple[Effect, ...]:
    """Every effect in the order of its name, the user's own files included. Raises UsageError for a bad file."""
    extra = sum((load_effect_file(path) for path in effect_files), ())
    return tuple(effect for _, effect in sorted(catalogue(extra).items()))


def find_effect(name: str, effect_files: tuple[str, ...] = ()) -> Effect:
    """The effect called `name` (a form after a colon is let through). Raises UsageError listing the known ones."""
    extra = sum((load_effect_file(path) for path in effect_files), ())
    return get_effect(name, extra)[0]
