"""One word, one meaning: the public nouns stand in the glossary once, and no two public classes share a name."""

import ast
import re
from collections import defaultdict
from importlib import import_module
from inspect import isclass
from pkgutil import iter_modules

import pytest

import pam_ident


def letters(text):
    return re.sub(r"[^a-z]", "", text.lower())


@pytest.fixture(scope="module")
def glossary(root):
    """Meaning by term, letters only; synonyms are separated by commas."""
    found = defaultdict(list)
    text = (root / "docs" / "glossary.md").read_text(encoding="utf-8")
    for terms, meaning in re.findall(r"^([^\n:#][^\n]*)\n: (.+(?:\n  .+)*)$", text, re.M):
        for term in terms.split(","):
            found[letters(term)].append(meaning)
    return found


def offered_classes():
    """Public classes of the root and of the packages, by name."""
    homes = [pam_ident, *(import_module(f"pam_ident.{info.name}") for info in iter_modules(pam_ident.__path__))]
    homes = [home for home in homes if hasattr(home, "__all__") and home.__name__ != "pam_ident.plot"]
    return {name for home in homes for name in home.__all__ if isclass(getattr(home, name))}


def object_model_nouns(root):
    """What the first column of the table of nouns names."""
    text = (
        (root / "docs" / "object-model.md").read_text(encoding="utf-8").partition("## Nouns")[2].partition("\n## ")[0]
    )
    return {name for row in re.findall(r"^\| (`.*?) \|", text, re.M) for name in re.findall(r"`(\w+)`", row)}


def test_every_public_noun_is_in_the_glossary(root, glossary):
    nouns = offered_classes() | object_model_nouns(root)
    assert len(nouns) > 60 and {"Model", "Fit", "Bench", "Solver"} <= nouns
    missing = sorted(noun for noun in nouns if letters(noun) not in glossary)
    assert not missing, f"docs/glossary.md lacks {', '.join(missing)}"


def test_a_term_has_one_meaning(glossary):
    assert len(glossary) > 90
    assert not [term for term, meanings in glossary.items() if len(meanings) > 1]


def test_the_glossary_is_in_order(root):
    text = (root / "docs" / "glossary.md").read_text(encoding="utf-8")
    heads = [letters(one) for one in re.findall(r"^([^\n:#][^\n]*)\n: ", text, re.M)]
    assert heads == sorted(heads)


def test_no_two_public_classes_share_a_name(root):
    homes = defaultdict(list)
    for path in sorted((root / "pam_ident").rglob("*.py")):
        if path.name.startswith("_") and path.name != "__init__.py":
            continue
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                homes[node.name].append(str(path.relative_to(root)))
    shared = {name: paths for name, paths in homes.items() if len(paths) > 1}
    assert len(homes) > 150
    assert not shared, "\n".join(f"{name}: {', '.join(paths)}" for name, paths in shared.items())
