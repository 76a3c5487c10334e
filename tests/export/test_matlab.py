"""The MATLAB function, run in Octave."""

import shutil
import subprocess

import numpy as np
import pytest
from cases import CASES, EACH_CASE, LENGTH, TRACKS, assert_agrees, columns

from pam_ident.core import UsageError
from pam_ident.export.program import ARGUMENTS, program
from pam_ident.export.targets.matlab import matlab_function


@pytest.fixture(scope="module")
def matlab_forces(tmp_path_factory, inputs) -> dict[str, np.ndarray]:
    """Forces of all cases along all tracks, from one run of Octave."""
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        pytest.skip("no Octave on this machine")
    folder = tmp_path_factory.mktemp("matlab")
    columns(inputs).tofile(folder / "given.bin")
    lines = [
        f"x = reshape(fread(fopen('given.bin'), Inf, 'double'), 8, {LENGTH}, {TRACKS});",
        "file = fopen('out.bin', 'w');",
    ]
    for case in CASES:
        (folder / f"{case.name}.m").write_text(matlab_function(case.fitted, case.name), encoding="utf-8")
        made = program(case.fitted)
        places = [list(ARGUMENTS).index(name) + 1 for name in made.arguments]
        if made.later is None:
            given = ", ".join(f"squeeze(x({k}, :, :))" for k in places)
            lines.append(f"out = {case.name}({given});")
        else:
            given = ", ".join(f"squeeze(x({k}, n, :))" for k in places)
            lines.append(f"out = zeros({LENGTH}, {TRACKS}); state = [];")
            lines.append(f"for n = 1:{LENGTH}, [out(n, :), state] = {case.name}({given}, state); end")
        lines.append("fwrite(file, out, 'double');")
    (folder / "run_all.m").write_text("\n".join(lines), encoding="utf-8")
    command = [octave, "--no-gui", "--norc", "--quiet", "--eval", "run_all"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    found = np.fromfile(folder / "out.bin").reshape(len(CASES), len(inputs))
    return dict(zip([case.name for case in CASES], found, strict=True))


@EACH_CASE
def test_octave_agrees_with_numpy_at_ten_thousand_samples(case, matlab_forces, numpy_forces, inputs):
    assert_agrees(matlab_forces[case.name], numpy_forces[case.name])


@pytest.mark.parametrize("name", ["2nd", "a-b", "end", "pick", ""])
def test_a_name_that_is_no_name_in_matlab_is_refused(name):
    with pytest.raises(UsageError, match="letters, digits"):
        matlab_function(CASES[0].fitted, name)
