"""What every command has: progress on a terminal, `--quiet`, JSON on stdout, completion."""

import io
import json
import os
import re
import subprocess
import sys

import pytest
from typer.main import get_command

from pam_ident.cli import app, verbs
from pam_ident.core.progress import Stage
from pam_ident.records import read_record
from pam_ident.tasks.law_choice import begin
from pam_ident.tasks.setup import Setup


def leaves(command, path=()):
    """Every command that does something, with the words that lead to it."""
    if hasattr(command, "commands"):
        for name, one in command.commands.items():
            yield from leaves(one, (*path, name))
        if path:
            yield path, command
    else:
        yield path, command


def test_a_line_of_progress_waits_two_seconds_and_tells_how_much_is_done_and_the_time_left(monkeypatch):
    now, screen = [100.0], io.StringIO()
    monkeypatch.setattr(verbs.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("COLUMNS", "90")
    line = verbs.ProgressLine()

    def told(stage, seconds):
        """What stands on the line at the end, its bar, colours and blanks left out; nothing if it was not written."""
        now[0] = seconds
        screen.seek(0)
        screen.truncate()
        line.tell(stage)
        last = re.sub(r"\x1b\[[\d;?]*[A-Za-z]|[━╸╺]", "", screen.getvalue().rpartition("\r")[2])
        return " ".join(last.split())

    assert told(Stage("records", 30, 100), 100.0) == told(Stage("records", 30, 100), 101.9) == ""
    assert told(Stage("records", 40, 100), 110.0) == "records 40/100 -:--:--"
    now_there = Stage("records", 50, 100)
    assert told(now_there, 130.0) == "records 50/100 0:01:40"  # 40 were done before it began
    assert told(now_there, 130.1) == ""
    assert told(Stage("weighing", 7, None, now_there), 131.0) == "records · weighing 50/100 0:01:40"
    assert told(Stage("records", 0, 10), 140.0) == "records 0/10 -:--:--"  # the same once more
    assert told(Stage("records", 1, 10), 142.0) == "records 1/10 -:--:--"
    assert told(Stage("records", 2, 10), 144.0) == "records 2/10 0:00:16"
    assert told(Stage("reading [red]rows", 1000), 150.0) == "reading [red]rows 1000/?"
    line.clear()
    assert screen.getvalue().endswith("\x1b[?25h\r\x1b[1A\x1b[2K")  # cursor back, line gone


def test_where_stderr_is_no_terminal_a_plain_line_tells_every_twenty_seconds(monkeypatch, capsys):
    now = [100.0]
    monkeypatch.setattr(verbs.time, "monotonic", lambda: now[0])
    plain = verbs.PlainLines()
    for now[0] in (100.0, 119.9, 120.0, 121.0, 139.9, 145.0):
        plain.tell(Stage("weighing", 7, None, Stage("records", 3, 9)))
    said = [f"after {seconds} s: records · weighing (3 of 9)" for seconds in (20, 45)]
    assert capsys.readouterr() == ("", "\n".join([*said, ""]))


@pytest.mark.parametrize(("words", "told"), [((), True), (("--json", "-"), True), (("--quiet",), False)])
def test_on_a_pipe_progress_is_told_unless_quiet(monkeypatch, ask, rubbing, words, told):
    monkeypatch.setattr(verbs, "EVERY", 0.0)
    result = ask("compare", rubbing, "--law", "exponential_law", *words)
    assert result.exit_code == 0 and ("after 0 s: " in result.stderr) == told


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


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no terminals here")
def test_on_a_terminal_progress_appears_and_is_gone_at_the_end(root, rubbing, tmp_path):
    import pty

    ours, theirs = pty.openpty()
    code = (
        "import sys; from pam_ident.cli import verbs, main\n"
        "verbs.PATIENCE = verbs.PAUSE = 0.0; sys.argv = ['pam-ident', *sys.argv[1:]]; main()"
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
    text = shown.decode()
    assert "weighing sets of effects" in text and text.endswith("\x1b[2K")
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


def test_help_names_an_argument_once_and_what_may_be_left_out_in_one_pair_of_brackets(ask):
    usage = {verb: ask(verb, "--help").output.splitlines()[0] for verb in ("fit", "diagnose", "workbench", "laws")}
    assert all(line.count("...") <= 1 and "[[" not in line for line in usage.values()), usage
    for words in (("fit",), ("predict",), ("effects", "show")):
        assert not re.search(r"<.*str.*>", ask(*words, "--help").output), words
    assert ask("fit", "--help").output.count("--workers") == 1
    assert "Default: 1." in ask("fit", "--help").output and "for fit" not in ask("batch", "--help").output


@pytest.mark.long
def test_verbs_that_take_a_record_share_their_options(ask, answer, rubbing):
    several = ("inspect", "fit", "compare", "diagnose", "add", "ladder", "report", "validate", "workbench", "against")
    for verb in (*several, "pack", "export"):
        assert "--where" in ask(verb, "--help").output, verb
    for verb in ("diagnose", "ladder", "report"):
        assert {"--without", "--only", "--also"} <= set(ask(verb, "--help").output.split()), verb
    few = ("--only", "creep", "--only", "coulomb_friction", "--without", "coulomb_friction", "--heldout", "refit")
    _, found = answer("ladder", rubbing, "--law", "exponential_law", *few)
    assert not any("coulomb_friction" in name for rung in found["rungs"] for name in rung["effects"])
    none = ask("diagnose", rubbing, "--law", "exponential_law", "--only", "creep:prony_3", "--without", "creep")
    assert none.exit_code == 2 and "creep:prony_3: the only effect that is tried, and left out" in none.stderr


def test_the_workbench_begins_with_the_law_that_suits_the_record(rubbing):
    setup, choice = begin(read_record(rubbing), Setup("auto"))
    assert setup.law == choice.law != "auto" and begin(None, Setup("auto"))[0].law == "exponential_law"
    assert begin(None, Setup("sarosi"))[0].law == "sarosi"


def test_effects_are_listed_as_laws_are(ask):
    lines = ask("effects").output.splitlines()
    at = lines.index("creep: creep and stress relaxation")
    assert lines[at + 1 : at + 3] == ["  −G q, q̇ = ε̇ − q/τ", "  needs in the record: motion, time"]


def test_a_fit_that_is_not_there_is_said_to_be_no_file(ask):
    for words in (("predict", "none.json", "--at", "x.csv"), ("export", "none.json", "--to", "c", "--out", "x.h")):
        assert "none.json: no such file; expected a file of" in ask(*words).stderr
