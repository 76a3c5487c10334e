"""MATLAB files damaged by chance must not take the program with them, which scipy's reader alone does."""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from corpus import HEADERS, values

from pam_ident.core import DataError
from pam_ident.records.formats.mat import read_tables
from pam_ident.records.mat_check import DEEPEST, check_elements

COLUMNS = dict(zip(HEADERS, values().T, strict=True))
KINDS = {
    "vectors": {**COLUMNS, "note": "rig 3", "spectrum": np.array([1.0 + 2.0j, 3.0])},
    "struct": {"run": COLUMNS},
    "structs": {"run": [COLUMNS, COLUMNS]},
    "cells": {"run": np.array([COLUMNS, "x", np.arange(3.0)], dtype=object)},
}
VALUES = (0, 1, 2, 5, 6, 7, 8, 9, 14, 15, 127, 128, 255)
"""Types and classes of elements, and what makes sizes wild."""


def written(content, **how):
    from scipy.io import savemat

    savemat(file := io.BytesIO(), content, **how)
    return file.getvalue()


def damaged(good, seed):
    rng = np.random.default_rng(seed)
    content = bytearray(good)
    for _ in range(int(rng.integers(1, 4))):
        content[int(rng.integers(116, len(content)))] = rng.choice([*VALUES, rng.integers(256)])
    return bytes(content[: int(rng.integers(128, len(content)))] if rng.random() < 0.1 else content)


def read_damaged(count, folder):
    """Read damaged files of each kind in this process, and print of each how many were read, and how many refused."""
    for kind, content in KINDS.items():
        good, path, refused = written(content), Path(folder) / f"{kind}.mat", 0
        for k in range(count):
            path.write_bytes(damaged(good, k))
            try:
                read_tables(path)
            except DataError:
                refused += 1
        print(kind, count - refused, refused)


@pytest.mark.parametrize("count", [100, pytest.param(2000, marks=pytest.mark.long)])
def test_a_damaged_file_is_read_or_refused_and_the_program_lives(tmp_path, count):
    here = str(Path(__file__).parent)
    words = f"import sys; sys.path.insert(0, {here!r}); from test_mat_damage import read_damaged as read"
    words += f"; read({count}, {str(tmp_path)!r})"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.returncode, done.stderr[-500:])
    found = {kind: (int(read), int(refused)) for kind, read, refused in map(str.split, done.stdout.splitlines())}
    assert found.keys() == KINDS.keys() and min(map(min, found.values())) > count // 10, found


@pytest.mark.parametrize("how", [{}, {"do_compression": True}, {"oned_as": "column"}], ids=str)
def test_sound_files_of_all_kinds_pass(how):
    from scipy.sparse import csc_array

    odd = {
        "empty": np.zeros((0, 3)),
        "no_struct": np.zeros((0,), dtype=[("a", "O"), ("b", "O")]),
        "no_fields": {},
        "cells": np.array([[1.0, "a"], [np.zeros(0), np.arange(3, dtype=np.int8)]], dtype=object),
        "whole": np.arange(5, dtype=np.uint16),
        "true": np.array([True, False]),
        "texts": np.array(["é", "two"]),
        "sparse": csc_array(np.eye(3)),
        "complex_sparse": csc_array(np.eye(2) * 1j),
        "deep": {"a": {"b": [{"c": 1.0}, {"c": "x"}]}},
    }
    check_elements(written(odd | KINDS["vectors"], **how))


def test_a_nest_without_end_is_refused():
    inner = {"a": 1.0}
    for _ in range(DEEPEST + 1):
        inner = {"a": inner}
    with pytest.raises(ValueError, match="nested"):
        check_elements(written(inner))
