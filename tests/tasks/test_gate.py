"""The gate before every answer: what is grave stops naming, what is degenerate is refused, what is good passes."""

import os
import subprocess
import sys
import warnings
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from degenerate import KINDS, NAMELESS, frame, good

from pam_ident.core import DataError, PamError, Specimen, UsageError
from pam_ident.core.threads import one_blas_thread
from pam_ident.records import read_record, record_from_frame
from pam_ident.records.datasets import dataset_names, dataset_record
from pam_ident.records.doubt import GRAVE
from pam_ident.records.gate import doubts_of
from pam_ident.records.inspection import inspect_record
from pam_ident.tasks.compare import compare_record
from pam_ident.tasks.diagnose import diagnose_record
from pam_ident.tasks.fit import fit_record
from pam_ident.tasks.gate import GraveDoubt, admit, check_codes, may_name
from pam_ident.tasks.setup import Setup

MUSCLE = Specimen("made", 200.0, 10.0, 25.4, 1.5)
QUICK = ("3 rows", "1000 identical rows", "hardly a pressure", "no force", "a saw of every row", "a spike of 1e300")
SETUP = Setup("chou_hannaford")


def record_of(table):
    return record_from_frame(frame(np.asarray(table, float)), MUSCLE)


@pytest.fixture
def fine():
    return record_of(good(np.random.default_rng(3)))


def codes(record):
    return [doubt.code for doubt in doubts_of(record) if doubt.grave]


def asked(record, setup):
    """All verbs; the names that are given, or None where that is refused. Anything but a PamError of 3 or 4 fails."""
    inspect_record(record)
    names = None
    for verb in (fit_record, compare_record, diagnose_record):
        try:
            found = verb(record, setup)
        except PamError as error:
            assert error.exit_code in (3, 4) and "\n" not in str(error) and len(str(error)) < 700, str(error)
        else:
            names = found.selected if verb is diagnose_record else None
    return names


def check_degenerate(name, seed, law):
    try:
        record = record_of(KINDS[name](np.random.default_rng(seed)))
    except PamError as error:
        assert error.exit_code == 4
        return
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        names = asked(record, Setup(law))
    if name in NAMELESS:
        assert not names, name


@pytest.mark.parametrize("name", QUICK)
def test_a_degenerate_record_is_refused_in_one_sentence(name):
    check_degenerate(name, 1, "chou_hannaford")


@pytest.mark.long
@pytest.mark.parametrize("law", ["chou_hannaford", "exponential_law"])
@pytest.mark.parametrize("name", KINDS)
def test_no_degenerate_record_breaks_anything_or_is_named(name, law):
    check_degenerate(name, 2, law)


def test_there_are_sixty_kinds_of_degenerate_records():
    assert len(KINDS) >= 60 and set(QUICK) <= NAMELESS <= set(KINDS)


@pytest.mark.parametrize("name", [n for n in dataset_names() if n not in ("gait",)])
def test_no_data_set_is_stopped(name):
    record = read_record(dataset_record(name))
    assert not codes(record) and record.kind == "isobaric"
    may_name(record, Setup("exponential_law").model)


SLIPS = {
    "pressure in bar": (1, lambda p: 10.0 * p, "scale"),
    "pressure in psi": (1, lambda p: 145.0 * p / 20.0, "scale"),
    "MPa headed Pa": (1, lambda p: 1e-6 * p, "scale"),
    "absolute pressure": (1, lambda p: p + 0.101325, "pressure_absolute"),
    "turned pressure": (1, lambda p: -p, "pressure_sign"),
    "force in pounds": (3, lambda f: f / 4.448, "scale"),
    "force in kN": (3, lambda f: f / 1000.0, "scale"),
    "turned force": (3, lambda f: -f, "force_sign"),
    "clipped force": (3, lambda f: np.minimum(f, 0.5 * f.max()), "force_clipped"),
    "a spike": (3, lambda f: np.where(np.arange(len(f)) == 9, 1e6, f), "impossible_value"),
    "length in m": (2, lambda x: x / 1000.0, "displacement_scale"),
    "length in inches": (2, lambda x: x / 25.4, "displacement_scale"),
    "turned length": (2, lambda x: -x, "displacement_sign"),
    "milliseconds": (0, lambda t: 1e3 * t, "clock_scale"),
    "a clock a thousand times too fast": (0, lambda t: 1e-3 * t, "clock_scale"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_grave_and_stops_naming_until_it_is_assumed(fine, slip):
    column, change, code = SLIPS[slip]
    assert not codes(fine)
    table = good(np.random.default_rng(3))
    table[:, column] = change(table[:, column])
    record = record_of(table)
    assert code in codes(record) and set(codes(record)) <= set(GRAVE)
    with pytest.raises(GraveDoubt, match="nothing is named") as stopped:
        may_name(record, SETUP.model)
    assert stopped.value.exit_code == 4 and f"--assume {code}" in str(stopped.value)
    assert [d.grave for d in stopped.value.doubts] == sorted((d.grave for d in stopped.value.doubts), reverse=True)


@pytest.mark.parametrize(("rise", "grave"), [(0.0, True), (0.2, False), (0.4, False)])
def test_a_bladder_that_takes_more_where_it_is_shorter_is_no_absolute_pressure(rise, grave):
    table = good(np.random.default_rng(3))
    pressure, contraction = table[:, 1], table[:, 2] / MUSCLE.initial_length_mm
    taken = pressure - 0.095 - rise * contraction
    table[:, 3] += MUSCLE.ideal_force(taken, contraction) - MUSCLE.ideal_force(pressure, contraction)
    assert ("pressure_absolute" in codes(record_of(table))) is grave


HEADED = {
    "kelvin": (lambda t: t.assign(temperature_C=296.15), "temperature_scale"),
    "epoch milliseconds": (lambda t: t.assign(time_s=1.7e12 + 1e3 * t.time_s), "clock_scale"),
    "ratios": (lambda t: t.assign(contraction_pct=t.pop("displacement_mm") / 200.0), "displacement_scale"),
    "branches": (
        lambda t: t.assign(branch=np.where(np.gradient(t.displacement_mm) > 0.0, "extension", "contraction")),
        "branch_sign",
    ),
    "absolute bar": (lambda t: t.assign(pressure_bar=10.0 * t.pop("pressure_MPa") + 1.01325), "pressure_absolute"),
}


@pytest.mark.parametrize("slip", HEADED)
def test_what_is_under_the_wrong_header_is_told_and_stops_naming(slip):
    change, code = HEADED[slip]
    record = record_from_frame(change(frame(good(np.random.default_rng(3)))), MUSCLE)
    for told in (inspect_record(record).doubts, fit_record(record, SETUP).warnings):
        assert code in [doubt.code for doubt in told if doubt.grave]
    with pytest.raises(GraveDoubt, match="nothing is named"):
        diagnose_record(record, SETUP)


@pytest.mark.parametrize(("course", "told"), [(lambda t: t, True), (lambda t: -t, True), (np.sqrt, False)])
def test_a_temperature_that_goes_with_the_clock_is_told(course, told):
    table = frame(good(np.random.default_rng(3)))
    warm = 25.0 + 8.0 * course(table.time_s / table.time_s.max())
    record = record_from_frame(table.assign(temperature_C=warm), MUSCLE)
    found = [(doubt.code, doubt.grave) for doubt in fit_record(record, SETUP).warnings]
    assert (("temperature_clock", False) in found) is told


@pytest.mark.long
@pytest.mark.parametrize(("name", "found"), [("nothing_hidden", ()), ("hidden_effect", ("pressure_friction",))])
def test_a_clock_of_whole_seconds_hides_nothing_and_adds_nothing(name, found):
    """Two or three rows a second: taken as they stand, both were of an unknown effect."""
    table = pd.read_csv(dataset_record(name))
    record = record_from_frame(table.assign(time_s=np.floor(table.time_s)), read_record(name).specimen)
    assert [note.code for note in record.notes] == ["coarse_clock"]
    assert diagnose_record(record, Setup("exponential_law")).selected == found


def test_all_rows_but_three_slack_name_nothing():
    table = frame(good(np.random.default_rng(3)))
    record = record_from_frame(table.assign(slack=(np.arange(len(table)) > 2) * 1.0), MUSCLE)
    assert len(record) == 3
    with pytest.raises(PamError, match="3 rows, and the least") as refused:
        diagnose_record(record, SETUP)
    assert refused.value.exit_code == 3


def test_what_is_assumed_does_not_stop():
    table = good(np.random.default_rng(3))
    table[:, 3] = np.minimum(table[:, 3], 0.6 * table[:, 3].max())
    record = record_of(table)
    with pytest.raises(GraveDoubt):
        may_name(record, SETUP.model)
    for assume in (("force_clipped",), ("all",)):
        assert [d.code for d in may_name(record, SETUP.model, assume) if d.grave] == ["force_clipped"]
    with pytest.raises(UsageError, match="--assume clipped: expected all or one of"):
        check_codes(["clipped"])


def test_a_doubt_names_the_column_as_the_file_does():
    table = frame(good(np.random.default_rng(3))).rename(columns={"force_N": "Force (kN)"})
    found = doubts_of(record_from_frame(table, MUSCLE))
    assert "scale" in [doubt.code for doubt in found]
    table["Force (kN)"] *= -1e-3
    (turned,) = [d for d in doubts_of(record_from_frame(table, MUSCLE)) if d.code == "force_sign"]
    assert turned.column == "Force (kN)"


@pytest.mark.parametrize(("times", "slip"), [(1.0 / 10.0, "bar and MPa (10)"), (1.0 / 145.0, "psi and MPa (145)")])
def test_slips_of_about_that_size_are_those_that_a_measured_muscle_allows(fine, times, slip):
    (told,) = [doubt.text for doubt in doubts_of(replace(fine, force=times * fine.force)) if doubt.code == "scale"]
    assert slip in told and "psi and kPa" not in told and "psi and bar" not in told, told


def test_a_force_that_answers_nothing_is_grave(fine):
    noise = np.random.default_rng(2).normal(100.0, 1.0, len(fine))
    for force in (np.full(len(fine), 100.0), noise):
        with pytest.raises(GraveDoubt, match="force_constant"):
            may_name(replace(fine, force=force), SETUP.model)
    assert "force_constant" not in [doubt.code for doubt in doubts_of(fine)]


def test_a_length_that_is_driven_at_one_load_is_no_dead_weight_test():
    time = np.arange(0.0, 200.0, 0.1)
    pressure, turns = np.repeat([0.1, 0.2, 0.3, 0.4], 500), np.cos(time * 0.6)
    force = np.random.default_rng(4).normal(100.0, 1.0, len(time))
    asked = {"driven": 20.0 + 20.0 * turns, "answering": 40.0 * pressure / 0.4 + 0.1 * turns}
    kinds = {}
    for name, length in asked.items():
        columns = {"time_s": time, "pressure_MPa": pressure, "displacement_mm": length, "force_N": force}
        kinds[name] = record_from_frame(pd.DataFrame(columns), MUSCLE).kind
    assert kinds == {"driven": "isobaric", "answering": "isotonic"}


def test_a_law_that_explains_nothing_is_said_first(fine):
    shuffled = replace(fine, force=np.random.default_rng(1).permutation(fine.force))
    for law in ("chou_hannaford", "exponential_law"):
        with pytest.raises(GraveDoubt, match="explains nothing") as stopped:
            may_name(shuffled, Setup(law).model)
        assert stopped.value.doubts[0].code == "explains_nothing"


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("one pressure", "isobaric"),
        ("locked at one length", "isometric"),
        ("locked at four lengths", "isometric"),
        ("a dead weight", "isotonic"),
        ("no load", "isotonic"),
        ("a pressure that rises all the time", "dynamic"),
    ],
)
def test_the_kind_of_test_is_found_and_can_be_said(name, kind):
    record = record_of(KINDS[name](np.random.default_rng(1)))
    assert record.kind == kind
    assert replace(record, said_kind="isobaric").kind == "isobaric"


def test_what_a_verb_cannot_answer_is_refused():
    weight, locked = (record_of(KINDS[n](np.random.default_rng(1))) for n in ("a dead weight", "locked at one length"))
    admit(weight)
    with pytest.raises(DataError, match="an isotonic test"):
        admit(weight, in_chunks=True)
    with pytest.raises(PamError, match="the length changes by"):
        may_name(locked, SETUP.model)
    assert fit_record(locked, SETUP).fits["together"].rmse < 3.0


BLAS = """
import hashlib, sys
from pam_ident.records.datasets import dataset_record
from pam_ident.tasks.fit import fit_record
from pam_ident.tasks.setup import Setup
import pam_ident as pam
setup = Setup("exponential_law", ("coulomb_friction",))
record = setup.read(dataset_record("hidden_effect"))
one, other = fit_record(record, setup).fits["together"], pam.fit(record, setup.model)
assert one.values == other.values
numbers = [*one.values.values(), *(e.stderr for e in one.estimates), one.rmse]
print(" ".join(float(x).hex() for x in numbers))
"""


@pytest.mark.long
def test_numbers_do_not_hang_on_the_callers_threads():
    told = []
    for threads in ("1", "2"):
        more = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), threads)
        done = subprocess.run([sys.executable, "-c", BLAS], env=os.environ | more, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        told.append(done.stdout)
    assert told[0] == told[1] and len(told[0].split()) > 10


def test_blas_has_one_thread_inside():
    import scipy.linalg  # noqa: F401
    from threadpoolctl import threadpool_info

    with one_blas_thread():
        pools = [pool for pool in threadpool_info() if pool["user_api"] == "blas"]
        assert pools and all(pool["num_threads"] == 1 for pool in pools)


def test_a_muscle_that_never_comes_near_its_full_length_may_have_another_one():
    table = good(np.random.default_rng(3))
    assert not [one for one in doubts_of(record_of(table)) if "full length" in one.text]
    table[:, 2] += 25.0
    (told,) = [one for one in doubts_of(record_of(table)) if "full length" in one.text]
    assert not told.grave and "initial_length_mm of the specimen (200)" in told.text


def test_a_force_that_falls_as_the_pressure_rises_is_told():
    """Two runs, one of them in kilogram-force."""
    table = good(np.random.default_rng(3))
    table[table[:, 1] > np.median(table[:, 1]), 3] /= 9.81
    told = {one.code: one.text for one in doubts_of(record_of(table))}
    assert "the force falls as the pressure rises" in told["scale"] and "pressure_absolute" not in told
