"""The program as a process: quick to start, the same by every door, plain when something breaks."""

import json
import os
import re
import subprocess
import sys

import pytest

HEAVY = ("numpy", "scipy", "pandas", "matplotlib", "jinja2", "rich", "jax", "lmfit", "optimistix", "bokeh")


UNUSED = ("matplotlib", "jinja2", "bokeh", "pam_ident.diagnosis", "scipy.optimize", "jax", "lmfit")
"""What a fit of one curved parameter does without."""


@pytest.fixture
def process(root, tmp_path):
    """Run Python in an empty folder with the checkout importable."""

    def run(*words, **options):
        environment = {**os.environ, "PYTHONPATH": str(root)}
        return subprocess.run(
            [sys.executable, *map(str, words)], capture_output=True, text=True, cwd=tmp_path, env=environment, **options
        )

    return run


def test_help_loads_nothing_heavy(process):
    code = (
        "import sys; from pam_ident.cli import main; sys.argv = ['pam-ident', '--help']\n"
        "try: main()\nexcept SystemExit as end: assert not end.code\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])"
    )
    done = process("-c", code)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("verb", ["fit", "inspect", "effects"])
def test_a_fit_draws_nothing_and_so_loads_no_figures(process, root, clean, verb):
    words = {"fit": ["fit", str(clean), "--law", "sarosi", "--json", "f.json"], "inspect": ["inspect", str(clean)]}
    code = (
        f"import sys; from pam_ident.cli import main; sys.argv = ['pam-ident', *{words.get(verb, [verb])!r}]\n"
        "try: main()\nexcept SystemExit as end: assert not end.code\n"
        f"print([name for name in {UNUSED!r} if name in sys.modules])"
    )
    done = process("-c", code)
    assert done.returncode == 0 and done.stdout.splitlines()[-1] == "[]", done.stderr


def test_every_door_is_the_same_program(process, root):
    texts = {process(*door, "--help").stdout for door in ((root / "cli.py",), ("-m", "pam_ident"))}
    assert len(texts) == 1
    text = texts.pop()
    for verb in (
        "demo",
        "inspect",
        "fit",
        "compare",
        "diagnose",
        "add",
        "ladder",
        "report",
        "rig",
        "selftest",
        "effects",
    ):
        assert f"\n  {verb} " in text
    assert process(root / "cli.py", "--version").stdout == process("-m", "pam_ident", "--version").stdout


def test_a_fit_as_a_process(process, root, clean, tmp_path):
    done = process(root / "cli.py", "fit", clean, "--law", "exponential_law", "--json", "fit.json")
    assert done.returncode == 0 and done.stderr == "" and "rmse" in done.stdout
    assert json.loads((tmp_path / "fit.json").read_text())["schema"] == "pam-ident/fit/1"
    assert [path.name for path in tmp_path.iterdir()] == ["fit.json"]


def test_bad_data_as_a_process(process, root, write_record):
    path = write_record("time_s,pressure_MPa\n0,1\n")
    done = process(root / "cli.py", "fit", path, "--law", "sarosi")
    assert done.returncode == 4 and done.stdout == ""
    assert "Traceback" not in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_a_disk_that_refuses_ends_in_one_line(ask, clean, tmp_path, monkeypatch):
    from pam_ident.core import files

    def refuse(*_):
        raise OSError(28, "No space left on device", str(tmp_path / "fit.json"))

    monkeypatch.setattr(files.os, "replace", refuse)
    result = ask("fit", clean, "--law", "sarosi", "--json", tmp_path / "fit.json")
    assert result.exit_code == 2 and len(result.stderr.strip().splitlines()) == 1
    assert "No space left" in result.stderr and list(tmp_path.iterdir()) == []


def test_a_fault_of_the_program_is_one_message_too(ask, clean, monkeypatch):
    import pam_ident.tasks.fit as task

    def fail(*_):
        raise ValueError("nobody expected this")

    monkeypatch.delenv("PAM_IDENT_DEBUG", raising=False)
    monkeypatch.setattr(task, "fit_record", fail)
    result = ask("fit", clean, "--law", "sarosi")
    assert result.exit_code == 1 and "nobody expected this" in result.stderr
    assert "Traceback" not in result.stderr and len(result.stderr.strip().splitlines()) == 2


def test_a_reader_that_goes_away_is_no_fault(root, process):
    command = f"{sys.executable} {root / 'cli.py'} effects | head -c 1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert done.stderr == ""


def test_no_arguments_shows_the_help_with_every_command_in_a_whole_sentence(ask):
    result = ask()
    assert result.exit_code == 2 and "diagnose" in result.output
    assert not re.search(r"\.\.\.$", result.output.partition("Commands:")[2], re.M)
