"""No public name without words: what it is, the shape of its arrays, the errors of ours that it raises."""

import ast
import re

import pytest

OURS = {"DataError", "FitError", "UsageError"}
ARRAY = re.compile(r"\bArray\b|\bndarray\b|\bNDArray\b")
# "shape …", or a tuple of sizes: (n,), (n, k), (B,), (…, N, 2), (n + 1, …)
SHAPE = re.compile(r"\bshapes?\b|\((?:\w+|…)(?: \+ \w+)?,(?: ?(?:\w+|…|len\(\w+\)),?)*\)")


def public_nodes(tree):
    """(name, node, class or None) of every public function, class and method, and of what checks a class's fields."""
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef | ast.ClassDef) or node.name.startswith("_"):
            continue
        if any(ast.unparse(one) == "overload" for one in node.decorator_list):  # its words are the function's
            continue
        yield node.name, node, None
        for inner in node.body if isinstance(node, ast.ClassDef) else ():
            if not isinstance(inner, ast.FunctionDef | ast.ClassDef):
                continue
            if not inner.name.startswith("_") or inner.name in ("__init__", "__post_init__"):
                yield f"{node.name}.{inner.name}", inner, node


def words(node, home):
    """The docstring of a function or class, and that of its class beside it."""
    return (ast.get_docstring(node) or "") + "\n" + ((home and ast.get_docstring(home)) or "")


def takes_or_returns_arrays(node):
    if not isinstance(node, ast.FunctionDef):
        return False
    every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    annotations = [a.annotation for a in every] + [node.returns]
    return any(a is not None and ARRAY.search(ast.unparse(a)) for a in annotations)


def raised(node):
    """Errors of ours that the body of a function raises by name."""
    found = set()
    for inner in ast.walk(node):
        if isinstance(inner, ast.Raise) and inner.exc is not None:
            what = inner.exc.func if isinstance(inner.exc, ast.Call) else inner.exc
            found |= {ast.unparse(what).rpartition(".")[2]} & OURS
    return found


def faults(text, commands=()):
    """What is missing in a module's source; docstrings of `commands` are their help, and name no errors."""
    tree = ast.parse(text)
    found = [] if ast.get_docstring(tree) else ["the module: no docstring"]
    for name, node, home in public_nodes(tree):
        own = name.rpartition(".")[2]
        if not ast.get_docstring(node) and not own.startswith("__"):
            found.append(f"{name}: no docstring")
        if takes_or_returns_arrays(node) and not own.startswith("__") and not SHAPE.search(words(node, home)):
            found.append(f"{name}: the docstring names no shape")
        if isinstance(node, ast.FunctionDef) and name not in commands:
            found += [f"{name}: raises {e}, unnamed" for e in sorted(raised(node)) if e not in words(node, home)]
    return found


def command_names():
    from pam_ident.cli import app, effects

    return {one.callback.__name__ for group in (app, effects.app) for one in group.registered_commands}


def modules(root):
    every = sorted((root / "pam_ident").rglob("*.py"))
    return [path for path in every if not path.name.startswith("_") or path.name.startswith("__")]


def test_every_public_name_is_documented(root):
    paths = modules(root)
    assert len(paths) > 150
    found = []
    for path in paths:
        commands = command_names() if path.parent.name == "cli" else ()
        found += [f"{path.relative_to(root)}: {one}" for one in faults(path.read_text(encoding="utf-8"), commands)]
    assert not found, "\n".join(found)


GOOD = '''"""A module."""


class Thing:
    """A thing of values (n,). Raises DataError for none."""

    def __init__(self, values: Array) -> None:
        if not len(values):
            raise DataError("none")

    @property
    def first(self) -> float:
        """The first value."""
        return self.values[0]


def half(values: Array) -> Array:
    """Half of values of any shape."""
    return values / 2
'''


@pytest.mark.parametrize(
    ("good", "bad", "said"),
    [
        ('"""A module."""', "", "the module: no docstring"),
        ('        """The first value."""\n', "", "Thing.first: no docstring"),
        ("Raises DataError for none.", "", "Thing.__init__: raises DataError, unnamed"),
        (" of any shape", "", "half: the docstring names no shape"),
    ],
)
def test_a_missing_word_is_found(good, bad, said):
    assert faults(GOOD) == []
    assert good in GOOD
    assert faults(GOOD.replace(good, bad)) == [said]
