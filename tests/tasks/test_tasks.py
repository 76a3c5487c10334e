"""Tasks as a notebook calls them: answers out, nothing printed."""

import shlex
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Specimen, UsageError
from pam_ident.fitting import fit_branches
from pam_ident.fitting.energy import energy_warning, model_loops, passive
from pam_ident.records import build_record
from pam_ident.records.inspection import inspect_record, stroke_speeds
from pam_ident.tasks.fit import FitOptions, fit_record
from pam_ident.tasks.setup import Setup


@pytest.fixture(scope="module")
def record():
    """Two isobars, contraction and extension, 10 N of friction, no noise."""
    e = np.tile(np.linspace(0.0, 0.15, 60), 4)
    p = np.repeat([0.2, 0.4], 120)
    sign = np.tile(np.repeat([1.0, -1.0], 60), 2)
    force = 2400.0 * p - 5500.0 * p * e + (690.0 * p - 10.0) * np.exp(-45.0 * e) - 900.0 * e - 190.0 - 10.0 * sign
    return build_record("made", Specimen(), p, e, force, direction=sign)


def test_the_loop_of_a_law_alone_has_no_area(record):
    setup = Setup("exponential_law")
    loops = model_loops(fit_branches(setup.model, record, "together"))
    assert loops == {0.2: 0.0, 0.4: 0.0} and passive(loops) is True and energy_warning(loops) is None


def test_the_loop_of_two_branches_has_the_area_of_the_friction(record):
    loops = model_loops(fit_branches(Setup("exponential_law").model, record, "separate"))
    for energy in loops.values():
        assert energy == pytest.approx(2 * 10.0 * 0.15 * 0.2, rel=0.02)
    assert passive(loops) is True


@pytest.mark.parametrize("seed", range(4))
def test_noise_is_not_taken_for_a_loop_that_gives_energy_back(record, seed):
    """Two fits of the same curve differ by noise; half of such pairs lie the wrong way round."""
    rng = np.random.default_rng(seed)
    force = record.force + 10.0 * record.inputs.direction + rng.normal(0.0, 3.0, len(record))
    noisy = replace(record, force=force)
    loops = model_loops(fit_branches(Setup("exponential_law").model, noisy, "separate"))
    assert passive(loops) is True and max(map(abs, loops.values())) < 0.1


def test_one_branch_has_no_loop(record):
    loops = model_loops(fit_branches(Setup("exponential_law").model, record, "contraction"))
    assert loops == {} and passive(loops) is None


def test_a_loop_that_gives_energy_back_is_named_by_its_pressures():
    loops = {0.4: -0.5, 0.2: -0.1, 0.3: 0.2}
    assert passive(loops) is False
    assert "at 0.2, 0.4 MPa (most at 0.4 MPa, 0.5 J a cycle)" in str(energy_warning(loops))


def test_tasks_print_nothing(record, capsys):
    fit_record(record, Setup("exponential_law"), FitOptions("separate", "two-stage"))
    inspect_record(record)
    assert capsys.readouterr() == ("", "")


def test_unknown_choices_are_refused(record):
    with pytest.raises(UsageError, match="--method 'twostage': expected one of global, two-stage"):
        fit_record(record, Setup("sarosi"), FitOptions(method="twostage"))
    with pytest.raises(UsageError, match="--branch"):
        fit_record(record, Setup("sarosi"), FitOptions("both"))


def test_two_stage_with_an_effect_falls_back_on_all_isobars_at_once(record):
    answer = fit_record(record, Setup("exponential_law", ("coulomb_friction",)), FitOptions(method="two-stage"))
    assert answer.two_stage == () and answer.isobars is not None
    assert answer.fits["together"].values["coulomb_friction.F_c"] == pytest.approx(10.0, rel=1e-6)


def test_the_command_asks_the_same_again():
    setup = Setup("sarosi", ("creep", "coulomb_friction:held"), ("my file.py",), True, "spec.toml")
    words = shlex.split(setup.command("report", "a b.csv", "--out", "x.html"))
    assert words == [
        "pam-ident", "report", "a b.csv", "--law", "sarosi", "--effect", "creep", "--effect", "coulomb_friction:held",
        "--effect-file", "my file.py", "--free-geometry", "--specimen", "spec.toml", "--out", "x.html",
    ]  # fmt: skip


def test_a_table_has_no_speeds(record):
    assert stroke_speeds(record) == ()
    found = inspect_record(record)
    assert found.branches == {"contraction": 120, "extension": 120} and found.duration_s is None
    assert [isobar.n for isobar in found.isobars] == [120, 120]
