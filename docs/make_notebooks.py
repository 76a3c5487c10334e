"""Run the notebooks and keep what they show: `python docs/make_notebooks.py [NAME ...]`.

Of a cell tagged `live` nothing is kept: what it shows needs a kernel.
"""

import io
import os
import re
import sys
import tempfile
from base64 import b64decode, b64encode
from itertools import count
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "notebooks"
FIGURE_ID = re.compile(r"pam-[0-9a-f]{10}(?=-)")
COLOURS = 48
NOT_TEXT = re.compile(r"<(style|script|figure).*?</\1>|<[^>]*>", re.S)


def run(book: Path) -> nbformat.NotebookNode:
    """A notebook as it is after a run from top to bottom, in a new folder beside the documents.

    Raises CellExecutionError for a cell that fails.
    """
    found = nbformat.read(book, as_version=4)
    quiet = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "docs").symlink_to(ROOT / "docs")
        place = Path(folder) / FOLDER.name
        place.mkdir()
        client = NotebookClient(found, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(place)}})
        client.execute(env=quiet)
    return tidied(found)


def tidied(book: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """The same without times, the machine's Python, bars that were taken away, and what `live` cells show."""
    book.metadata.language_info = {"name": "python"}
    for cell in book.cells:
        cell.metadata.pop("execution", None)
        if cell.cell_type == "code":
            live = "live" in cell.metadata.get("tags", ())
            cell.outputs = [] if live else [one for one in cell.outputs if one.get("data", {}).get("text/html") != ""]
    numbers, names = count(1), {}
    for data in (one.data for cell in book.cells for one in cell.get("outputs", ()) if "data" in one):
        if "text/html" in data:
            data["text/html"] = FIGURE_ID.sub(
                lambda old: names.setdefault(old.group(), f"pam-{next(numbers)}"), data["text/html"]
            )
        if "image/png" in data:
            data["image/png"] = smaller(data["image/png"])
    return book


def smaller(png: str) -> str:
    """A picture, in base 64, in few colours."""
    kept = io.BytesIO()
    Image.open(io.BytesIO(b64decode(png))).convert("RGB").quantize(COLOURS).save(kept, "PNG", optimize=True)
    return b64encode(kept.getvalue()).decode()


def words(cell: nbformat.NotebookNode) -> str:
    """What a cell shows as text: pictures and markup left out."""
    said = []
    for one in cell.outputs:
        data = one.get("data", {})
        kind = next((kind for kind in ("text/html", "text/markdown", "text/latex", "text/plain") if kind in data), None)
        said.append(one.text if "text" in one else NOT_TEXT.sub(" ", data[kind]) if kind else "")
    return " ".join("".join(said).split())


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(one.stem for one in FOLDER.glob("*.ipynb")):
        path = FOLDER / f"{name}.ipynb"
        nbformat.write(run(path), path)
        print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")
