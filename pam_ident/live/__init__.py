"""Figures to zoom and to point at, for the workbench, a report's page and notebooks. They need Bokeh, an extra."""

from importlib.metadata import PackageNotFoundError, version

OLDEST = (3, 8)
"""Bokeh as the extra `workbench` asks for it, which the metadata of a checkout that is not installed cannot tell."""


def available() -> bool:
    """Whether there is the Bokeh that the extra `workbench` asks for; pages and notebooks can do without."""
    try:
        return tuple(map(int, version("bokeh").split(".")[:2])) >= OLDEST
    except PackageNotFoundError:
        return False
