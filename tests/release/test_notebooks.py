"""Every notebook runs from top to bottom, and holds no outputs."""

from pathlib import Path

import pytest

BOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))


def read(book):
    nbformat = pytest.importorskip("nbformat")
    return nbformat.read(book, as_version=4)


def test_notebooks_hold_no_outputs():
    assert BOOKS
    for book in BOOKS:
        held = [cell for cell in read(book).cells if cell.get("outputs") or cell.get("execution_count")]
        assert not held, f"{book.name} holds outputs; strip them"


@pytest.mark.long
@pytest.mark.filterwarnings("default")  # of Jupyter's client; the notebook's own warnings stay in its kernel
@pytest.mark.parametrize("book", BOOKS, ids=lambda book: book.stem)
def test_it_runs(book):
    client = pytest.importorskip("nbclient").NotebookClient
    client(read(book), timeout=600, kernel_name="python3", resources={"metadata": {"path": str(book.parent)}}).execute()
