"""What every command has: progress on a terminal, `--quiet`, JSON on stdout, completion."""

import json
import os
import subprocess
import sys

import pytest
from typer.main import get_command

from pam_ident.cli import app
from pam_ident.cli.verbs import Clock, duration
from pam_ident.core.progress import Stage


def leaves(command, path=()):
    """Every command that does something, with the words that lead to it."""
    if hasattr(command, "commands"):
        for name, one in command.commands.items():
            yield from leaves(one, (*path, name))
        if path:
            yield path, command
    else:
        yield path, command


def test_times_are_told_in_the_unit_they_are_read_in():
    assert [duration(s) for s in (4.4, 89.0, 119.0, 3600.0, 9000.0)] == ["4 s", "89 s", "2 min", "60 min", "2.5 h"]


def test_a_line_of_progress_waits_two_seconds_and_tells_pace_and_time_left():
    clock = Clock()
    assert clock.line(Stage("records", 40, 100), 100.0) is None
    assert clock.line(Stage("records", 40, 100), 101.9) is None
    now = Stage("records", 50, 100)
    assert clock.line(now, 130.0) == "records: 50 of 100, 0.33/s, 2 min left · 30 s"  # 40 were done before it began
    assert clock.line(now, 130.1) is None
    inner = Stage("weighing", 7, None, now)
    assert clock.line(inner, 131.0) == "records: 50 of 100, 0.32/s, 3 min left · weighing · 31 s"
    assert clock.line(Stage("records", 0, 10), 140.0) == "records: 0 of 10 · 40 s"  # the same once more
    assert clock.line(Stage("records", 1, 10), 142.0) == "records: 1 of 10, 0.50/s, 18 s left · 42 s"
    assert clock.line(Stage("reading rows", 1000), 150.0) == "reading rows: 1000 · 50 s"
    assert clock.line(Stage("reading rows", 4000), 152.0) == "reading rows: 4000, 1500/s · 52 s"


def test_every_command_has_quiet_and_json():
    found = dict(leaves(get_command(app)))
    assert len(found) > 15
    options = {path: {word for p in one.params for word in p.opts} for path, one in found.items()}
    assert [path for path, words in options.items() if "--quiet" not in words] == []
    assert [path for path, words in options.items() if "--json" not in words] == []


def test_quiet_prints_nothing_but_writes_what_was_asked_for(ask, rubbing, tmp_path):
    result = ask("diagnose", rubbing, "--law", "exponential_law", "--quiet", "--json", tmp_path / "d.json")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
    assert json.loads((tmp_path / "d.json").read_text())["selected"] == ["coulomb_friction"]


def test_json_to_stdout_is_alone_there(ask, clean):
    result = ask("fit", clean, "--law", "exponential_law", "--json", "-")
    assert json.loads(result.stdout)["schema"] == "pam-ident/fit/1"
    several = ask("diagnose", clean, clean, "--law", "exponential_law", "--json", "-")
    assert [json.loads(line)["verdict"] for line in several.stdout.splitlines()] == ["adequate"] * 2


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no terminals here")
def test_on_a_terminal_progress_appears_and_is_gone_at_the_end(root, rubbing, tmp_path):
    import pty

    ours, theirs = pty.openpty()
    code = (
        "import sys; from pam_ident.cli import verbs, main\n"
        "verbs.PATIENCE = 0.0; sys.argv = ['pam-ident', *sys.argv[1:]]; main()"
    )
    with open(tmp_path / "out.txt", "w") as out:
        words = ["diagnose", str(rubbing), "--law", "exponential_law"]
        environment = {**os.environ, "PYTHONPATH": str(root)}
        process = subprocess.Popen([sys.executable, "-c", code, *words], stdout=out, stderr=theirs, env=environment)
        os.close(theirs)
        shown = b""
        try:
            while part := os.read(ours, 65536):
                shown += part
        except OSError:  # the other end is closed
            pass
        assert process.wait() == 0
    os.close(ours)
    lines = shown.decode().split("\r\x1b[K")
    assert any("weighing sets of effects" in line for line in lines) and lines[-1] == ""
    assert "coulomb_friction" in (tmp_path / "out.txt").read_text()


@pytest.mark.parametrize(
    ("words", "expected"),
    [("pam-ident dia", "diagnose"), ("pam-ident fit r.csv --law expo", "exponential_law"),
     ("pam-ident fit r.csv --law sarosi --effect coul", "coulomb_friction"),
     ("pam-ident fit r.csv --effect coulomb_friction:te", "coulomb_friction:textbook"),
     ("pam-ident add r.csv --effect coulomb_friction : te", "textbook"),
     ("pam-ident fit r.csv --effect coulomb_friction :", "stribeck"),
     ("pam-ident fit r.csv --effect coulomb_friction : textbook --law expo", "exponential_law")],
)  # fmt: skip
def test_the_shell_completes_commands_laws_and_effects(root, words, expected):
    environment = {
        **os.environ, "PYTHONPATH": str(root), "_PAM_IDENT_COMPLETE": "complete_bash",
        "COMP_WORDS": words.replace(" ", "\n"),
        "COMP_CWORD": str(len(words.split()) - 1),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "pam_ident"], capture_output=True, text=True, env=environment, check=False
    )
    assert expected in done.stdout.split(), done.stderr
