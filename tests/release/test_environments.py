"""The oldest dependencies that pyproject.toml allows, and every Python that it names, in environments of their own."""

import json
import re
import shutil
import subprocess
import sys
import tomllib

import pytest

pytestmark = pytest.mark.long
OTHERS = [name for name in ("python3.11", "python3.12", "python3.13") if not sys.executable.endswith(name)]


def run(*words, **options):
    """What a process prints; its last lines where it fails."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{words}\n{(done.stdout + done.stderr)[-3000:]}"
    return done.stdout


def works(root, folder, python, *pins):
    """The checkout, copied and installed without its extras, passes its selftest and finds the hidden effect."""
    kept = shutil.ignore_patterns(".*", "tests", "docs", "dist", "__pycache__")
    shutil.copytree(root, folder / "tree", ignore=kept)
    run(python, "-m", "venv", folder / "env")
    made = folder / "env" / "bin" / "python"
    run(made, "-m", "pip", "install", "-q", "--disable-pip-version-check", folder / "tree", *pins)
    away = {"cwd": folder}
    run(made, "-c", "import pam_ident.leg.track, pam_ident.workbench.bench", **away)
    run(made, "-m", "pam_ident", "selftest", **away)
    record = root / "datasets" / "hidden_effect" / "record.csv"
    law = ("--law", "exponential_law", "--json", folder / "answer.json")
    run(made, "-m", "pam_ident", "diagnose", record, *law, **away)
    answer = json.loads((folder / "answer.json").read_text(encoding="utf-8"))
    assert (answer["verdict"], answer["selected"]) == ("missing_effect", ["pressure_friction"])
    run(made, "-m", "pam_ident", "fit", record, "--law", "sarosi", "--figures", folder / "figures", **away)


def test_the_oldest_dependencies(root, tmp_path):
    wanted = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    pins = [re.sub(r"\s*>=\s*", "==", line) for line in wanted]
    assert pins and all("==" in pin for pin in pins)
    works(root, tmp_path, sys.executable, *pins)


@pytest.mark.parametrize("name", OTHERS)
def test_another_python(root, tmp_path, name):
    python = shutil.which(name)
    if python is None or subprocess.run([python, "-c", "import venv"], capture_output=True).returncode:
        pytest.skip(f"no {name} on PATH")
    works(root, tmp_path, python)
