"""A new file format is one file: CONTRIBUTING's example, put where a contributor puts it."""

import sys
from pathlib import Path

import numpy as np
import pytest

from pam_ident.core import DataError
from pam_ident.records import formats, read_record

PAGE = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
EXAMPLE = PAGE.split("```python\n# pam_ident/records/formats/json_lines.py\n")[1].split("```")[0]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder for records, read by formats of which the example is one."""
    (tmp_path / "formats").mkdir()
    (tmp_path / "formats" / "json_lines.py").write_text(EXAMPLE)
    monkeypatch.setattr(formats, "__path__", [*formats.__path__, str(tmp_path / "formats")])
    formats.catalogue.cache_clear()
    records = tmp_path / "records"
    records.mkdir()
    muscle = 'name = "m"\ninitial_length_mm = 200.0\ninitial_radius_mm = 10.0\nbraid_angle_deg = 25.0\n'
    (records / "specimen.toml").write_text(f"[specimen]\n{muscle}")
    yield records
    formats.catalogue.cache_clear()
    sys.modules.pop(f"{formats.__name__}.json_lines", None)


def test_a_new_format_is_read_by_its_ending_and_found_in_a_folder(folder):
    line = '{{"pressure_bar": 3.0, "displacement_mm": {}, "force_N": {}}}\n'
    (folder / "run.jsonl").write_text("".join(line.format(2.0 * k, 400.0 - k) for k in range(20)))
    for path in (folder / "run.jsonl", folder):
        record = read_record(path)
        np.testing.assert_allclose(record.inputs.contraction, 0.01 * np.arange(20))
        assert record.levels == pytest.approx([0.3]) and record.force[-1] == 381.0


def test_a_broken_file_of_it_is_refused_in_words(folder):
    (folder / "run.jsonl").write_text("{not json")
    with pytest.raises(DataError, match=r"run\.jsonl: not a readable file of JSON lines .*; write it again"):
        read_record(folder / "run.jsonl")
