"""Work in a thread: what it finds, how it is stopped, how it fails."""

import threading

from pam_ident.core import DataError
from pam_ident.core.progress import Stage, tell
from pam_ident.workbench.work import Work


def test_what_it_yields_can_be_taken_while_it_goes_on():
    go_on = threading.Event()

    def begin():
        tell("first", 1, 2)
        yield "a"
        go_on.wait(10)
        yield "b"

    work = Work(begin)
    found = []
    while not found:
        found += work.take()
    assert found == ["a"] and work.busy and work.stage == Stage("first", 1, 2)
    go_on.set()
    work.wait(10)
    assert work.take() == ["b"] and not work.busy and not work.error and not work.stopped


def test_it_ends_at_the_next_stage_when_told_to():
    begun, go_on = threading.Event(), threading.Event()

    def begin():
        begun.set()
        go_on.wait(10)
        tell("next")
        yield "never"

    work = Work(begin)
    assert begun.wait(10)
    work.stop()
    go_on.set()
    work.wait(10)
    assert work.stopped and work.take() == [] and not work.error


def test_what_goes_wrong_is_told_in_words():
    def begin(error):
        yield "kept"
        raise error

    for error, words in ((DataError("row 3"), "row 3"), (ZeroDivisionError("x"), "ZeroDivisionError: x")):
        work = Work(lambda error=error: begin(error))
        work.wait(10)
        assert words in work.error and work.take() == ["kept"]
