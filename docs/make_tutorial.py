"""Run the commands of docs/tutorial.md and the README and write what they print beneath them:
`python docs/make_tutorial.py`."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE, README = ROOT / "docs" / "tutorial.md", ROOT / "README.md"
BLOCK = re.compile(r"```console\n\$ (?P<command>[^\n]+)\n(?P<output>.*?)```\n", re.S)


def refreshed(text: str) -> str:
    """The page with every console block's output as the program prints it now.

    The blocks run in their order, in one new folder that holds the checkout's data sets. Raises CalledProcessError
    for a command that fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "datasets").symlink_to(ROOT / "datasets")
        return BLOCK.sub(lambda found: _block(found["command"], folder), text)


def _block(command: str, folder: str) -> str:
    program = f'pam-ident() {{ "{sys.executable}" -m pam_ident "$@"; }}; set -eo pipefail; '
    wide = {**os.environ, "COLUMNS": "100"}
    done = subprocess.run(
        ["bash", "-c", program + command], cwd=folder, env=wide, check=True, capture_output=True, text=True
    )
    return f"```console\n$ {command}\n{done.stdout.rstrip()}\n```\n"


if __name__ == "__main__":
    for page in (PAGE, README):
        page.write_text(refreshed(page.read_text(encoding="utf-8")), encoding="utf-8")
