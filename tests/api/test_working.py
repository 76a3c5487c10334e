"""Long work in a notebook shows a bar, and an interrupt takes it away; small matrices have one thread."""

import pytest

import pam_ident as pam
from pam_ident.api import working
from pam_ident.api.working import in_python
from pam_ident.core import UsageError
from pam_ident.core.progress import Stage, steps


class Handle:
    def __init__(self, shown):
        self.shown = shown

    def update(self, text):
        self.shown.append(text.data)


@pytest.fixture
def shown(monkeypatch):
    """What a notebook would have shown, one after the other."""
    display = pytest.importorskip("IPython.display")
    found = []

    def show(text, display_id):
        found.append(text.data)
        return Handle(found)

    monkeypatch.setattr(display, "display", show)
    monkeypatch.setattr(working, "in_jupyter", lambda: True)
    monkeypatch.setattr(working, "PATIENCE", 0.0)
    monkeypatch.setattr(working, "PAUSE", 0.0)
    return found


def test_a_bar_is_shown_and_goes(shown, record):
    pam.fit(record)
    assert any("comparing laws" in text and "<progress" in text for text in shown) and shown[-1] == ""


def test_an_interrupt_ends_the_work_and_takes_the_bar_away(shown):
    @working.worked
    def long():
        for k in steps(range(5), "cycles <one>"):
            if k == 2:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        long()
    assert len(shown) == 4 and shown[-1] == ""
    assert shown[2] == '<progress value="2" max="5"></progress> cycles &lt;one&gt; 2 of 5'


def test_without_a_notebook_nothing_is_shown(capsys):
    assert not working.in_jupyter()
    with working.working():
        list(steps(range(3), "cycles"))
    assert capsys.readouterr() == ("", "")


def test_a_stage_without_a_count_has_a_bar_without_an_end():
    assert working.bar_html(Stage("fitting")) == "<progress></progress> fitting"


def test_an_error_names_arguments_and_not_options():
    assert in_python("name it by --law") == "name it by law="
    assert in_python("--assume scale if it is meant") == "assume='scale' if it is meant"
    assert in_python("--branch 'up': expected one of together") == "branch='up': expected one of together"
    assert (
        in_python("a file of `pam-ident fit --law LAW`, `pam-ident laws`")
        == "a file of `pam-ident fit --law LAW`, pam.laws"
    )
    with pytest.raises(UsageError, match=r"unknown effect 'zzz'; pam\.effects lists all") as caught:
        pam.fit("dmsp20_300", "sarosi", effects="zzz")
    assert "pam-ident" not in str(caught.value)
