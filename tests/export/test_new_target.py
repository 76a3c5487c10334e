"""A new target of exports is one file: CONTRIBUTING's example, put where a contributor puts it."""

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

RECORD = Path(__file__).parents[2] / "datasets" / "paper_laws" / "reconstructed.csv"
PAGE = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
EXAMPLE = PAGE.split("```python\n# pam_ident/export/targets/sheet.py\n")[1].split("```")[0]


@pytest.fixture
def program(tmp_path, root):
    """The program with a folder that holds the example beside its own targets."""
    (tmp_path / "targets").mkdir()
    (tmp_path / "targets" / "sheet.py").write_text(EXAMPLE)
    code = "import sys; from pam_ident.export import targets; targets.__path__.append('targets')\n"
    code += "from pam_ident.cli import main; main()"

    def run(*words):
        words = [sys.executable, "-c", code, *map(str, words)]
        environment = {"PYTHONPATH": str(root), "PATH": "", "COLUMNS": "100"}
        return subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)

    return run


@pytest.mark.long
def test_a_new_target_is_listed_and_written(program, tmp_path):
    assert "c, fmu, fmu3, matlab, mujoco, python, sheet or json" in program("export", "--help").stdout
    words = ("export", RECORD, "--law", "sarosi", "--to", "sheet", "--out")
    done = program(*words, "arm.csv")
    assert done.returncode == 0 and "wrote arm.csv" in done.stdout, done.stderr
    table = pd.read_csv(tmp_path / "arm.csv")
    assert list(table.columns) == ["branch", "parameter", "value", "unit"] and len(table) == 6
    assert "ending in .csv" in program(*words, "arm.txt").stderr
