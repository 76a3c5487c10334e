"""The numbers hang neither on the threads that the caller sets nor on how the program is asked: to the byte."""

import os
import subprocess
import sys

import pytest

THREADS = ("1", "2", "4")
ASKED = {
    "fit": ("hidden_effect", "exponential_law", ["coulomb_friction"]),
    "diagnose": ("hidden_effect", "exponential_law", []),
}
SCRIPT = """
import sys
import numpy as np
import scipy.linalg
import pam_ident as pam
from threadpoolctl import threadpool_info, threadpool_limits

verb, record, law, out, threads, *effects = sys.argv[1:]
threadpool_limits(int(threads), "blas")  # BLAS itself takes no more from the environment than there are cores
assert all(pool["num_threads"] == int(threads) for pool in threadpool_info() if pool["user_api"] == "blas")
getattr(pam, verb)(record, law, effects).to_json(out)
"""


def answer(root, folder, verb, way, threads):
    """The bytes of a verb's JSON, asked at the shell or in Python by a caller with so many threads."""
    record, law, effects = ASKED[verb]
    out = folder / f"{verb}-{way}-{threads}.json"
    if way == "shell":
        words = [root / "cli.py", verb, record, "--law", law, "--json", out]
        words += [word for name in effects for word in ("--effect", name)]
    else:
        words = ["-c", SCRIPT, verb, record, law, out, threads, *effects]
    own = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), threads)
    done = subprocess.run(
        [sys.executable, *map(str, words)],
        env=os.environ | own | {"PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        cwd=folder,
    )
    assert done.returncode == 0, done.stderr
    return out.read_bytes()


@pytest.mark.long
@pytest.mark.parametrize("verb", ASKED)
def test_one_two_or_four_threads_at_the_shell_or_in_python_give_the_same_bytes(root, tmp_path, verb):
    found = {(w, n): answer(root, tmp_path, verb, w, n) for w in ("shell", "python") for n in THREADS}
    assert len(set(found.values())) == 1, {key: hash(text) for key, text in found.items()}
