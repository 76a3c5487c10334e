"""A file is there whole or not at all, and holds no NaN."""

import json
import math

import numpy as np
import pytest

from pam_ident.core import UsageError, files


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "answer.json"
    path.write_text("old")

    def refuse(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "replace", refuse)
    with pytest.raises(OSError, match="No space"):
        files.write_whole(path, "new")
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_what_was_written_replaces_the_old_file_and_others_may_read_it(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("old")
    files.write_whole(path, "neü")
    assert path.read_bytes() == "neü".encode() and list(tmp_path.iterdir()) == [path]
    plain = tmp_path / "plain"
    plain.write_text("")
    assert path.stat().st_mode == plain.stat().st_mode


def test_json_has_null_for_what_is_no_number(tmp_path):
    path = tmp_path / "answer.json"
    answer = {"a": math.nan, "b": [np.float64(1.5), -math.inf], "c": np.array([1.0, math.nan]), "d": np.bool_(True)}
    files.write_json(path, answer)
    assert json.loads(path.read_text()) == {"a": None, "b": [1.5, None], "c": [1.0, None], "d": True}


def test_one_object_a_line(tmp_path):
    path = tmp_path / "answers.jsonl"
    files.write_json_lines(path, [{"a": "x\ny"}, {"b": [1, 2]}])
    assert [json.loads(line) for line in path.read_text().splitlines()] == [{"a": "x\ny"}, {"b": [1, 2]}]


def test_targets_that_cannot_be_written_are_refused(tmp_path):
    assert files.check_target(tmp_path / "map.SVG", (".svg", ".png")) == tmp_path / "map.SVG"
    with pytest.raises(UsageError, match=r"\.svg or \.png"):
        files.check_target(tmp_path / "map.gif", (".svg", ".png"))
    with pytest.raises(UsageError, match="there is no folder"):
        files.check_target(tmp_path / "none" / "map.svg")
    with pytest.raises(UsageError, match="is a folder"):
        files.check_target(tmp_path)
    with pytest.raises(UsageError, match="the name of a folder"):
        files.check_target(f"{tmp_path}/results/")
