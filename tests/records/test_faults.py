"""Files changed by chance, by class: read rightly, or refused in one sentence."""

import json

import faults
import mutations
import numpy as np
import pytest


@pytest.mark.parametrize("kind", [*faults.TEXTS, "lvm", "csv.gz"])
def test_some_of_each_class(kind, tmp_path, capsys):
    faults.run(kind, 60, 7, tmp_path)
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line for line in lines if line["fault"]] == []
    assert {line["end"] for line in lines} == {"read", "refused"}


@pytest.mark.parametrize(("kind", "stream"), [("tdms", [3855093188, 244])])
def test_what_was_once_read_wrongly(kind, stream, tmp_path):
    """A channel's type changed, and the group of another."""
    (tmp_path / "specimen.toml").write_text(faults.SPECIMEN)
    data, _ = faults.changed(kind, np.random.default_rng(stream), faults.good_binary(kind, tmp_path))
    path = tmp_path / f"record.{kind}"
    path.write_bytes(data)
    assert faults.outcome(path, lambda record: "read") == ("refused", "")


@pytest.mark.parametrize(
    "stream",
    [
        pytest.param([2326742395, 6934], id="MPa became MPaa, which counts from vacuum"),
        pytest.param([884762780, 5589], id="a cell put in where the file is cut off"),
    ],
)
def test_what_no_format_can_tell(stream, tmp_path):
    (tmp_path / "specimen.toml").write_text(faults.SPECIMEN)
    assert mutations.one(tmp_path, np.random.default_rng(stream))[1:] == ("read", "")


@pytest.mark.long
def test_all_of_them(capsys):
    """With the same seed each time; `python tests/records/faults.py` draws a fresh one."""
    assert faults.main(seed=20261127) == 0, capsys.readouterr().out


@pytest.mark.long
def test_the_judges_see_what_is_wrong(tmp_path, monkeypatch, capsys):
    """With forces off by a hundredth each class has failures."""
    real = faults.read_record

    def wrong(*args):
        record = real(*args)
        record.force[:] *= 1.01
        record.inputs.time[-1] += 0.05
        return record

    monkeypatch.setattr(faults, "read_record", wrong)
    for kind in (*faults.TEXTS, "lvm"):
        faults.run(kind, 80, 7, tmp_path)
        lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
        assert all(line["fault"] for line in lines if line["end"] == "read"), kind
