"""Sphinx extension: before a build, write the pages that follow from the program into `docs/generated`."""

import re
import shutil
from pathlib import Path
from typing import Any

import signatures
from api_page import PACKAGES, package_page, root_page
from command_page import command_page
from effect_pages import effect_page, law_page

from pam_ident.effects import catalogue as effects
from pam_ident.laws import catalogue as laws
from pam_ident.plot import to_png

ROOT = Path(__file__).parents[2]


def write_pages(folder: Path) -> None:
    """Write every generated page anew into `folder`, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    _write_effects(folder / "effects")
    law_list = sorted(laws().values(), key=lambda law: (len(law.params), law.name))
    for law in law_list:
        _write(folder / "laws" / f"{law.name}.md", law_page(law))
    _write(folder / "laws" / "index.md", _index("Force laws", "With the fewest parameters first.", law_list))
    _write(folder / "commands.md", command_page())
    _write(folder / "api" / "index.md", root_page())
    for package in PACKAGES:
        _write(folder / "api" / f"{package}.md", package_page(package))
    _write_datasets(folder / "datasets")


def _write_effects(folder: Path) -> None:
    every = [effect for _, effect in sorted(effects().items())]
    names = [effect.name for effect in every]
    for effect in every:
        figure = signatures.draw(effect)
        if figure is not None:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{effect.name}.png").write_bytes(to_png(figure, dpi=130))
        page = effect_page(
            effect,
            signatures.look_alikes(effect, every),
            [(law, signatures.share_left(effect, law)) for law in laws()],
            None if figure is None else f"{effect.name}.png",
            names,
        )
        _write(folder / f"{effect.name}.md", page)
    text = "A page each, made from the effect's file. How the diagnosis uses them: [diagnosis](../../diagnosis.md)."
    _write(folder / "index.md", _index("Effects", text, every))


def _write_datasets(folder: Path) -> None:
    """The READMEs of the data sets; links to files beside them stay as names."""
    names = sorted(path.parent.name for path in (ROOT / "datasets").glob("*/README.md"))
    for name in names:
        text = (ROOT / "datasets" / name / "README.md").read_text(encoding="utf-8")
        _write(folder / f"{name}.md", re.sub(r"\[([^\]]+)\]\((?![a-z]+:)[^)]*\)", r"\1", text))
    listing = "\n".join(names)
    text = "# Bundled data\n\nEach with its source, units and how it was made."
    _write(folder / "index.md", f"{text}\n\n```{{toctree}}\n:maxdepth: 1\n\n{listing}\n```\n")


def _index(title: str, text: str, things: Any) -> str:
    rows = "\n".join(f"| [{one.name}]({one.name}.md) | {one.title} |" for one in things)
    listing = "\n".join(one.name for one in things)
    return f"# {title}\n\n{text}\n\n| name | is |\n|---|---|\n{rows}\n\n```{{toctree}}\n:hidden:\n\n{listing}\n```\n"


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def lead_inside(app: Any, docname: str, source: list[str]) -> None:
    """Turn links that leave the documentation into links to its pages, or into plain words where it has none."""
    text = re.sub(r"\]\(\.\./datasets/(\w+)(?:/README\.md)?\)", r"](generated/datasets/\1.md)", source[0])
    if not docname.startswith("generated/"):
        text = re.sub(r"\[([^\]]+)\]\(\.\./[^)]*\)", r"\1", text)
    source[0] = text


def plain_docstring(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Docstrings are plain text with `code` in backticks: keep |x| and * from being read as markup."""
    lines[:] = [re.sub(r"(`[^`]*`)|([|*])", lambda m: m[1] or "\\" + m[2], line) for line in lines]


def parsable_signature(app: Any, what: str, name: str, thing: Any, options: Any, signature: str, returns: str) -> Any:
    """Defaults without a spelling of their own, such as <factory>, become three dots."""
    return (re.sub(r"<[^<>]*>", "...", signature) if signature else signature), returns


def setup(app: Any) -> dict[str, Any]:
    """What Sphinx calls."""
    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir) / "generated"))
    app.connect("source-read", lead_inside)
    app.connect("autodoc-process-docstring", plain_docstring)
    app.connect("autodoc-process-signature", parsable_signature)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
