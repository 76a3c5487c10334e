"""The notebooks show what running them gives, and nothing of the machine that ran them."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
OF_A_MACHINE = re.compile(r"/(?:tmp|home|root|Users|usr)/|[A-Z]:\\\\|site-packages|\b20\d\d-\d\d-\d\d|\d\d:\d\d:\d\d")


@pytest.fixture(scope="module")
def maker():
    pytest.importorskip("nbclient")
    spec = importlib.util.spec_from_file_location("make_notebooks", ROOT / "docs" / "make_notebooks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def cells(book):
    """The code cells of a notebook."""
    nbformat = pytest.importorskip("nbformat")
    return [cell for cell in nbformat.read(book, as_version=4).cells if cell.cell_type == "code"]


def test_there_are_notebooks():
    assert len(BOOKS) >= 7


@pytest.mark.parametrize("book", BOOKS, ids=lambda book: book.stem)
def test_it_shows_its_answers_and_is_small_and_teaches_without_asserts(book):
    run = cells(book)
    assert [cell.execution_count for cell in run] == list(range(1, len(run) + 1)), "run docs/make_notebooks.py"
    assert sum(bool(cell.outputs) for cell in run) >= len(run) - 2
    assert not any(one.output_type == "error" or one.get("name") == "stderr" for cell in run for one in cell.outputs)
    assert not any(re.search(r"^\s*assert\b", cell.source, re.M) for cell in run)
    assert book.stat().st_size <= 1_500_000
    shown = book.read_text(encoding="utf-8")
    assert shown.count('const bokeh = \\"') == ("<figure" in shown), "one cell brings Bokeh for all"
    assert not OF_A_MACHINE.search(str([cell.outputs for cell in run]))


@pytest.mark.long
@pytest.mark.filterwarnings("default")  # of Jupyter's client; the notebook's own warnings stay in its kernel
@pytest.mark.parametrize("book", BOOKS, ids=lambda book: book.stem)
def test_it_shows_what_a_run_gives(book, maker, agree):
    now = [cell for cell in maker.run(book).cells if cell.cell_type == "code"]
    for shown, fresh in zip(cells(book), now, strict=True):
        assert agree(maker.words(shown), maker.words(fresh)), "run docs/make_notebooks.py, and read the notebook again"
        assert [set(one.get("data", ())) for one in shown.outputs if "data" in one] == [
            set(one.get("data", ())) for one in fresh.outputs if "data" in one
        ]
