"""The C header, compiled: what a force in C is, and what a compiler says of it."""

import shutil
import subprocess

import numpy as np
import pytest
from cases import CASES, EACH_CASE, LENGTH, assert_agrees, columns

from pam_ident.core import UsageError
from pam_ident.export.program import ARGUMENTS, program
from pam_ident.export.targets.c import c_header

FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2", "-ffp-contract=off")


@pytest.fixture(scope="module")
def c_forces(request, tmp_path_factory, inputs) -> dict[str, np.ndarray]:
    """Forces of all cases that are asked for along all tracks, from one program in C that includes their headers."""
    asked = [one.callspec.params["case"] for one in request.session.items if "c_forces" in one.fixturenames]
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler on this machine")
    folder = tmp_path_factory.mktemp("c")
    lines = ["#include <stdio.h>", "#include <stdlib.h>"]
    lines += [f'#include "{case.name}.h"' for case in asked]
    lines += ["int main(void) {", f"  const int n = {len(inputs)};"]
    lines += ["  double (*x)[8] = malloc(sizeof(double[8]) * (size_t)n), *out = malloc(sizeof(double) * (size_t)n);"]
    lines += ["  if (fread(x, sizeof *x, (size_t)n, stdin) != (size_t)n) return 1;"]
    for case in asked:
        (folder / f"{case.name}.h").write_text(c_header(case.fitted, case.name), encoding="utf-8")
        made = program(case.fitted)
        given = ", ".join(f"x[k][{list(ARGUMENTS).index(name)}]" for name in made.arguments)
        if made.later is None:
            lines.append(f"  for (int k = 0; k < n; ++k) out[k] = {case.name}_force({given});")
        else:
            lines += [f"  {{ {case.name}_state s; {case.name}_init(&s); for (int k = 0; k < n; ++k) {{"]
            lines += [
                f"    if (k % {LENGTH} == 0) {case.name}_init(&s);",
                f"    out[k] = {case.name}_step(&s, {given});",
            ]
            lines += ["  } }"]
        lines.append("  fwrite(out, sizeof *out, (size_t)n, stdout);")
    (folder / "main.c").write_text("\n".join([*lines, "  return 0;", "}", ""]), encoding="utf-8")
    build = [compiler, *FLAGS, "main.c", "-o", "main", "-lm"]
    done = subprocess.run(build, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    ran = subprocess.run([folder / "main"], input=columns(inputs).tobytes(), capture_output=True, check=True)
    found = np.frombuffer(ran.stdout).reshape(len(asked), len(inputs))
    return dict(zip([case.name for case in asked], found, strict=True))


@pytest.mark.long
@EACH_CASE
def test_c_agrees_with_numpy_at_ten_thousand_samples(case, c_forces, numpy_forces, inputs):
    assert_agrees(c_forces[case.name], numpy_forces[case.name])


@pytest.mark.parametrize("name", ["2nd", "a-b", "double", "", "größe", "a" * 60])
def test_a_name_that_is_no_name_in_c_is_refused(name):
    with pytest.raises(UsageError, match="letters, digits"):
        c_header(CASES[0].fitted, name)
