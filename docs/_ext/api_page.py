"""Reference pages of the public names: those of the root, and of each subpackage's `__all__`."""

import inspect
from dataclasses import fields, is_dataclass
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

import pam_ident

PACKAGES = (
    "core", "records", "laws", "effects", "model", "fitting", "diagnosis", "leg", "export", "plot", "report", "rig",
    "workbench", "api", "tasks", "batch", "validation", "schema", "parallel",
)  # fmt: skip


def public_names(package: str) -> list[str]:
    """Names that a subpackage or module offers: its `__all__`, or the public things that it defines itself."""
    module = import_module(f"pam_ident.{package}")
    if package in (
        "leg",
        "export",
        "tasks",
        "api",
        "batch",
        "validation",
        "schema",
        "parallel",
    ):  # every command of it starts at one of its modules
        return sorted(info.name for info in iter_modules(module.__path__) if not info.name.startswith("_"))
    offered = getattr(module, "__all__", None)
    if offered is not None:
        return list(offered)
    found = {n: v for n, v in vars(module).items() if inspect.isclass(v) or inspect.isfunction(v)}
    return [n for n, v in found.items() if not n.startswith("_") and v.__module__ == module.__name__]


def root_page() -> str:
    """The names at the root with their homes, and the list of the subpackages' pages."""
    rows = []
    for name in pam_ident.__all__:
        thing = getattr(pam_ident, name)
        first = (inspect.getdoc(thing) or "").splitlines()[0]
        role = "class" if inspect.isclass(thing) else "func" if inspect.isfunction(thing) else "data"
        rows.append(f"| {{py:{role}}}`{name} <{pam_ident._HOME[name]}>` | {first} |")
    listing = "\n".join(PACKAGES)
    return (
        "# Reference of the Python names\n\n"
        "The names at the root; everything else is found in the subpackages below.\n\n"
        "| name | is |\n|---|---|\n" + "\n".join(rows) + f"\n\n```{{toctree}}\n:maxdepth: 1\n\n{listing}\n```\n"
    )


def package_page(package: str) -> str:
    """The page of a subpackage: its own words, then its public names."""
    name = f"pam_ident.{package}"
    module = import_module(name)
    lines = [f"# {name}", "", "```{eval-rst}", f".. automodule:: {name}", ""]
    for public in public_names(package):
        thing = _thing(module, public)
        if inspect.ismodule(thing):
            lines += [f".. rubric:: {thing.__name__}", "", f".. automodule:: {thing.__name__}", "   :members:", ""]
        elif not getattr(thing, "__module__", name).startswith(name):
            lines += [f"``{public}`` is that of :py:mod:`{'.'.join(thing.__module__.split('.')[:2])}`.", ""]
        elif inspect.isclass(thing):
            lines += _class(f"{name}.{public}", thing)
        elif callable(thing):
            lines += [f".. autofunction:: {name}.{public}", ""]
        else:
            lines += [f".. py:data:: {name}.{public}", "", f"   By name: {', '.join(thing)}.", ""]
    for path, thing in _other_classes(package):
        lines += _class(path, thing)
    return "\n".join([*lines, "```", ""])


def _class(path: str, thing: type) -> list[str]:
    """A class with its members; a field whose default is a function is no method."""
    functions = [f.name for f in fields(thing) if inspect.isfunction(f.default)] if is_dataclass(thing) else []
    hidden = [f"   :exclude-members: {', '.join(functions)}"] if functions else []
    return [f".. autoclass:: {path}", "   :members:", *hidden, ""]


def _other_classes(package: str) -> list[tuple[str, type]]:
    """Public classes of a subpackage's modules that are no public names themselves: public ones take or return them."""
    home = import_module(f"pam_ident.{package}")
    shown = [id(_thing(home, name)) for name in public_names(package)]
    found = []
    for info in iter_modules(getattr(home, "__path__", ())):
        module = None if info.name.startswith("_") else import_module(f"{home.__name__}.{info.name}")
        if module is None or id(module) in shown:
            continue
        classes = [v for v in vars(module).values() if inspect.isclass(v) and v.__module__ == module.__name__]
        classes = [one for one in classes if not one.__name__.startswith("_") and id(one) not in shown]
        found += [(f"{module.__name__}.{one.__name__}", one) for one in classes]
    return found


def _thing(home: ModuleType, name: str) -> Any:
    return getattr(home, name) if hasattr(home, name) else import_module(f"{home.__name__}.{name}")
