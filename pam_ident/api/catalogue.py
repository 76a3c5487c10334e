"""`pam.laws` and `pam.effects`: what is known, by name."""

import warnings
from collections.abc import Iterator, Mapping
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from ..core.nearest import unknown
from ..effects import Effect, load_effect_file
from ..laws import Law

if TYPE_CHECKING:
    import pandas as pd

T = TypeVar("T", Law, Effect)


class Catalogue(Mapping[str, T], Generic[T]):
    """What is known, by name: `pam.laws["sarosi"]`, `pam.laws.sarosi`, `list(pam.laws)`, `pam.laws.to_frame()`.

    Raises KeyError, or AttributeError, for another name, with those that look like it.

    Example:
        >>> import pam_ident as pam
        >>> print(len(pam.laws), pam.laws["chou_hannaford"].title)
        9 ideal law of Chou and Hannaford
        >>> print(pam.effects.creep.title)
        creep and stress relaxation
    """

    def __init__(self, module: ModuleType, kind: str) -> None:
        self._module, self._kind = module, kind

    def _known(self) -> dict[str, T]:
        return {one.name: one for one in self._module.listed()}

    def __getitem__(self, name: str) -> T:
        known = self._known()
        if name not in known:
            raise KeyError(self._unknown(name))
        return known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known())

    def __len__(self) -> int:
        return len(self._known())

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        known = self._known()
        if name in known:
            return known[name]
        if name in self._module.__all__:
            home = self._module.__name__
            warnings.warn(
                f"pam_ident.{self._kind}s.{name} goes in the next version; from {home} import {name}",
                DeprecationWarning,
                stacklevel=2,
            )
            return getattr(self._module, name)
        raise AttributeError(self._unknown(name))

    def _unknown(self, name: str) -> str:
        return unknown(self._kind, name, self._known(), f"pam.{self._kind}s")

    def __dir__(self) -> list[str]:
        return [*self._known(), "load", "to_frame"] if self._kind == "effect" else [*self._known(), "to_frame"]

    def __repr__(self) -> str:
        known = self._known()
        width = max(map(len, known))
        return "\n".join(f"{name:{width}}  {one.title}" for name, one in known.items())

    def _repr_html_(self) -> str:
        return self.to_frame().to_html()

    def to_frame(self) -> "pd.DataFrame":
        """A row each, by name: title, formula (of an effect that of its simplest form), parameters, source."""
        import pandas as pd

        rows = {}
        for name, one in self._known().items():
            form = one if isinstance(one, Law) else one.forms[0]
            names = ", ".join(p.name for p in form.params)
            rows[name] = {"title": one.title, "formula": form.formula, "parameters": names, "source": one.source}
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis(self._kind)


class EffectCatalogue(Catalogue[Effect]):
    """The effects, and those of a file of one's own: `pam.effects.load("ripple.py")`."""

    def load(self, path: str) -> tuple[Effect, ...]:
        """The effects that a Python file defines, to be given to `effects=`. Raises UsageError."""
        return load_effect_file(path)


laws: Catalogue[Law] = Catalogue(import_module("pam_ident.laws"), "law")
"""The force laws that are known."""
effects = EffectCatalogue(import_module("pam_ident.effects"), "effect")
"""The effects that are known."""
