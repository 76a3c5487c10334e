"""Functional mock-up units, FMI 2.0 and 3.0: FMPy validates them, and runs them beside the muscle of the leg."""

import shutil
import zipfile

import numpy as np
import pytest
from cases import BY_NAME, MUSCLE, Case

from pam_ident.core import UsageError
from pam_ident.export.targets import get_target
from pam_ident.export.targets.python import python_function
from pam_ident.leg.arrays import jax, jnp
from pam_ident.leg.muscle import Muscle
from pam_ident.model import Model
from pam_ident.validation.effect_contract import LAW_VALUES, plausible

NAMES = ("pressure_MPa", "contraction", "velocity_mm_s")
MEMORY = Model("exponential_law", ["coulomb_friction:relaxing", "creep:prony_3", "presliding_hysteresis:dahl"])
SIZES = {k: v for term in MEMORY.terms for k, v in plausible(term.effect, term.form).items()}
LAW, RECALLS, BRANCHES = (
    BY_NAME["law_exponential_law"],
    Case("memory", MEMORY, {"together": LAW_VALUES | SIZES}),
    BY_NAME["branches"],
)
BOTH = pytest.mark.parametrize("unit", [(RECALLS, "fmu"), (RECALLS, "fmu3")], indirect=True, ids=("2.0", "3.0"))
ALL = pytest.mark.parametrize(
    "unit",
    [
        (LAW, "fmu"),
        (RECALLS, "fmu"),
        (RECALLS, "fmu3"),
        *(
            pytest.param((case, to), marks=pytest.mark.long)
            for case, to in ((LAW, "fmu3"), (BRANCHES, "fmu"), (BRANCHES, "fmu3"))
        ),
    ],
    indirect=True,
    ids=lambda one: f"{one[0].name}-{one[1]}",
)


@pytest.fixture
def fmpy():
    return pytest.importorskip("fmpy", reason="FMPy is not installed")


@pytest.fixture
def unit(request, tmp_path):
    """A case, and its unit as a file that is compiled for this machine."""
    case, to = request.param
    made = get_target(to).write(case.fitted, "arm")
    if "compiled for" not in made.notes[0]:
        pytest.skip(made.notes[0])
    path = tmp_path / "arm.fmu"
    path.write_bytes(made.text)
    return case, path


def gait(step=0.005) -> np.ndarray:
    """Time, pressure, contraction and speed along three strides of a knee, (n, 4); at rest at first."""
    t = np.arange(0.0, 3.0, step)
    phase = 2.0 * np.pi * t
    contraction = 0.1 + 0.06 * (1.0 - np.cos(phase)) / 2.0 + 0.03 * (1.0 - np.cos(2.0 * phase)) / 2.0
    speed = 200.0 * np.pi * (0.06 * np.sin(phase) + 0.06 * np.sin(2.0 * phase))
    return np.stack([t, 0.3 + 0.15 * np.sin(phase - 0.7), contraction, speed], axis=1)


def in_python(case, rows) -> np.ndarray:
    """The leg's muscle, instant by instant."""
    values = case.branches
    one, other = (values[b] for b in (("together",) * 2 if len(values) == 1 else ("contraction", "extension")))
    muscle = Muscle(case.model, MUSCLE, one, other)
    memory, forces = muscle.start(*jnp.array(rows[:1, 1:3].T), rows[0, 0]), []
    step = jax.jit(muscle.force)
    for t, *state in rows:
        force, memory = step(muscle.values(), memory, t, *jnp.array(state)[:, None])
        forces.append(force[0])
    return np.array(forces)


def assert_agrees(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


@BOTH
def test_fmpy_finds_no_fault(fmpy, unit):
    from fmpy.validation import validate_fmu

    _, path = unit
    assert validate_fmu(str(path)) == []
    told = fmpy.read_model_description(str(path))
    assert told.coSimulation.modelIdentifier == told.modelExchange.modelIdentifier == "arm"
    units = {v.name: v.unit for v in told.modelVariables}
    expected = {"pressure_MPa": "MPa", "contraction": None, "velocity_mm_s": "mm/s", "held": None, "force_N": "N"}
    assert {name: units[name] for name in units if name != "time"} == expected


@pytest.mark.long
@ALL
def test_in_co_simulation_the_force_is_that_of_python_along_a_gait(fmpy, unit, tmp_path):
    """Also after a step that is taken back."""
    case, path = unit
    rows, expected = gait(), in_python(case, gait())
    arm = slave(fmpy, path, tmp_path)
    inputs, force = references(fmpy, path)
    columns = [NAMES.index(name) + 1 for name in NAMES if name in inputs]
    found = []
    for k, row in enumerate(rows):
        arm.set([inputs[name] for name in NAMES if name in inputs], row[columns])
        found.append(arm.get([force])[0])
        if k == 200:
            before = arm.getFMUState()
            kept = arm.deserializeFMUState(arm.serializeFMUState(before))
            arm.doStep(row[0], 0.2)
            arm.set([inputs["contraction"]], [0.2])
            arm.doStep(row[0] + 0.2, 0.2)
            arm.setFMUState(kept)
        arm.doStep(row[0], 0.005)
    arm.terminate()
    arm.freeInstance()
    assert_agrees(found, expected)


@pytest.mark.long
@BOTH
def test_in_model_exchange_it_is_the_same(fmpy, unit):
    case, path = unit
    rows = gait()
    signals = np.array([tuple(row) for row in rows], dtype=[(name, float) for name in ("time", *NAMES)])
    found = fmpy.simulate_fmu(
        str(path), fmi_type="ModelExchange", input=signals, solver="Euler", step_size=0.005, output_interval=0.005,
        stop_time=rows[-1, 0], output=["force_N"],
    )  # fmt: skip
    np.testing.assert_allclose(found["time"], rows[:, 0], atol=1e-9)
    assert_agrees(found["force_N"], in_python(case, rows))


@BOTH
def test_while_it_is_held_the_direction_stays(fmpy, unit, tmp_path):
    """As the exported function, which is told the direction."""
    case, path = unit
    moving, rest = gait()[:150], np.arange(50)
    held = np.repeat(moving[-1:], 50, axis=0) * [1.0, 1.0, 1.0, 0.0]
    rows = np.concatenate([moving, held, moving[::-1] * [1.0, 1.0, 1.0, -1.0]])
    rows[:, 0] = 0.005 * np.arange(len(rows))
    defined: dict = {}
    exec(python_function(case.fitted, "muscle"), defined)
    arm, (inputs, force) = slave(fmpy, path, tmp_path), references(fmpy, path)
    state, found, expected = None, [], []
    for k, (t, p, e, v) in enumerate(rows):
        hold = float(k - 150 in rest)
        direction = np.sign(moving[-1, 3]) if hold else np.tanh(v / 0.2)
        one, state = defined["muscle"](p, e, direction, t, hold, state)
        expected.append(one)
        arm.set([inputs[name] for name in (*NAMES, "held")], [p, e, v, hold])
        found.append(arm.get([force])[0])
        arm.doStep(t, 0.005)
    assert_agrees(found, expected)
    assert abs(expected[150] - expected[149]) > 1.0


def slave(fmpy, path, tmp_path):
    """An instance in co-simulation, initialized at 0 s, whose `set` and `get` are those of the version's reals."""
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    told = fmpy.read_model_description(str(path))
    unpacked = fmpy.extract(str(path), str(tmp_path / "unpacked"))
    given = {"guid": told.guid, "unzipDirectory": unpacked, "modelIdentifier": "arm", "instanceName": "arm"}
    if told.fmiVersion == "2.0":
        arm = FMU2Slave(**given)
        arm.set, arm.get = arm.setReal, arm.getReal
        arm.instantiate()
        arm.setupExperiment(startTime=0.0)
        arm.enterInitializationMode()
    else:
        arm = FMU3Slave(**given)
        arm.set, arm.get = arm.setFloat64, arm.getFloat64
        arm.instantiate()
        arm.enterInitializationMode(startTime=0.0)
    arm.exitInitializationMode()
    return arm


def references(fmpy, path):
    found = {v.name: v.valueReference for v in fmpy.read_model_description(str(path)).modelVariables}
    return found, found["force_N"]


@pytest.mark.parametrize("to", ["fmu", "fmu3"])
def test_without_a_compiler_its_sources_are_there_and_it_is_said(monkeypatch, tmp_path, to):
    """Whatever it is called, and the same file for the same fit."""
    monkeypatch.setattr(shutil, "which", lambda name: None)
    one, other = (get_target(to).write(RECALLS.fitted, "model") for _ in range(2))
    assert "only sources" in one.notes[0] and "no C compiler" in one.notes[0] and one == other
    (tmp_path / "model.fmu").write_bytes(one.text)
    with zipfile.ZipFile(tmp_path / "model.fmu") as archive:
        found = {name for name in archive.namelist() if name.endswith((".c", ".h"))}
        assert found == {f"sources/{name}" for name in ("fmi.h", "model.h", f"fmi{2 if to == 'fmu' else 3}.c")}
        assert b"double model_step(" in archive.read("sources/model.h")


def test_a_name_that_is_no_name_in_c_is_refused():
    with pytest.raises(UsageError, match="letters, digits"):
        get_target("fmu").write(LAW.fitted, "2nd")
