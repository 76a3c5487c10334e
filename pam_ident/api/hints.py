"""What is said of an attribute that nobody has: which may be meant."""

from typing import TYPE_CHECKING, Any

from ..core.nearest import no_attribute


class Hinting:
    """Names, for an attribute that is not there, those that look like it or whose documentation speaks of it."""

    if not TYPE_CHECKING:  # a checker would take any name for known

        def __getattr__(self, name: str) -> Any:
            kind = type(self)
            if name.startswith("_") or hasattr(kind, name):  # or one whose own work has failed
                return object.__getattribute__(self, name)
            public = [one for one in dir(self) if not one.startswith("_")]
            known = {one: getattr(kind, one).__doc__ or "" if hasattr(kind, one) else "" for one in public}
            raise AttributeError(no_attribute(f"{kind.__name__!r} object", name, known))
