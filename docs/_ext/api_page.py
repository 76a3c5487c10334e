"""Reference pages of the public names: those of the root, and of each subpackage's `__all__`."""

import inspect
from importlib import import_module
from pkgutil import iter_modules

import pam_ident

PACKAGES = ("core", "records", "laws", "effects", "model", "fitting", "diagnosis", "leg", "plot", "report", "rig")
ALSO = {
    "core": ("recursion.Live",),
    "fitting": (
        "fit.Estimate",
        "isobars.IsobarRow",
        "problem.Projection",
        "bootstrap.Bootstrap",
        "covariance.Covariance",
        "floor.LackOfFit",
        "floor.NoiseFloor",
        "identifiability.StandIn",
        "identifiability.Verdict",
        "profile.Profile",
    ),
    "diagnosis": ("nouns.Separation", "strokes.Strokes"),
    "rig": ("muscle.Muscle", "muscle.Law", "muscle.Specimen", "protocol.Course", "hidden.Hidden"),
}
"""Classes that are no public name themselves, but that public ones take or return."""


def public_names(package: str) -> list[str]:
    """Names that a subpackage or module offers: its `__all__`, or the public things that it defines itself."""
    module = import_module(f"pam_ident.{package}")
    if package == "leg":  # every command of it starts at one of its modules
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
        if name == "__version__":
            rows.append("| `__version__` | the version of the program |")
            continue
        thing = getattr(pam_ident, name)
        first = (inspect.getdoc(thing) or "").splitlines()[0]
        home = pam_ident._HOME[name]
        role = "mod" if inspect.ismodule(thing) else "class" if inspect.isclass(thing) else "func"
        target = home if role == "mod" else f"{home}.{name}"
        rows.append(f"| {{py:{role}}}`{name} <{target}>` | {first} |")
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
        thing = getattr(module, public) if hasattr(module, public) else import_module(f"{name}.{public}")
        if inspect.ismodule(thing):
            lines += [f".. automodule:: {thing.__name__}", "   :members:", ""]
        elif not getattr(thing, "__module__", name).startswith(name):
            lines += [f"``{public}`` is that of :py:mod:`{'.'.join(thing.__module__.split('.')[:2])}`.", ""]
        elif inspect.isclass(thing):
            lines += [f".. autoclass:: {name}.{public}", "   :members:", ""]
        elif callable(thing):
            lines += [f".. autofunction:: {name}.{public}", ""]
        else:
            lines += [f".. py:data:: {name}.{public}", "", f"   By name: {', '.join(thing)}.", ""]
    for public in ALSO.get(package, ()):
        lines += [f".. autoclass:: {name}.{public}", "   :members:", ""]
    return "\n".join([*lines, "```", ""])
