"""A fitted model stepped through time: from fits and files, over a record, traced, mapped, differentiated."""

import json
from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import DataError, Specimen, UsageError
from pam_ident.core.inputs import Sensors
from pam_ident.effects import load_effect_file
from pam_ident.export.fitted import Fitted
from pam_ident.fitting import fit, fit_branches
from pam_ident.leg.arrays import jax, jnp
from pam_ident.leg.muscle import Muscle
from pam_ident.model import Model
from pam_ident.records import build_record
from pam_ident.validation.effect_contract import LAW_VALUES, plausible

MUSCLE = Specimen("made", 200.0, 10.0, 25.4, 1.5, sensors=Sensors(1.0))
RICH = (
    "coulomb_friction:stribeck",
    "presliding_hysteresis:maxwell_slip_3",
    "creep",
    "viscous_damping",
    "pressure_lag",
    "series_compliance",
    "bladder_elasticity",
)


def saw_tooth(model, values, speeds=(8.0, 40.0), pressures=(0.2, 0.4, 0.5), noise=0.0):
    """A record of strokes without holds that the model itself made."""
    rows, t = [], 0.0
    for p in pressures:
        for v in speeds:
            for begin, end in ((2.0, 40.0), (40.0, 2.0)) * 2:
                took = abs(end - begin) / v
                share = (np.arange(60) + 0.5) / 60
                rows += [(t + took * s, p, begin + (end - begin) * s) for s in share]
                t += took
        t += 15.0
    time, p, x = np.array(rows).T
    blank = build_record("made", MUSCLE, p, x / 200.0, np.zeros(len(time)), time=time)
    rng = np.random.default_rng(3)
    return replace(blank, force=model.force(blank.inputs, values) + noise * rng.standard_normal(len(time)))


def rich_model():
    model, values = Model.build("exponential_law", RICH), dict(LAW_VALUES)
    for term in model.terms:
        values |= plausible(term.effect, term.form, 0.5)
    return model, values


@pytest.fixture(scope="module")
def rich():
    model, values = rich_model()
    return Muscle(model, MUSCLE, values, values)


def state(p=(0.3, 0.2), e=(0.1, 0.05)):
    return jnp.asarray(p), jnp.asarray(e)


def walk(muscle, record, rows):
    """Forces of one muscle that is taken along a record's samples, compiled."""
    inputs = record.inputs
    columns = [inputs.time[rows], inputs.pressure[rows], inputs.contraction[rows], inputs.velocity[rows]]
    t, p, e, v = (jnp.asarray(column)[:, None] for column in columns)
    force = jax.jit(muscle.force)
    memory, found = muscle.start(p[0], e[0], t[0]), []
    for k in range(len(t)):
        one, memory = force(muscle.values(), memory, t[k], p[k], e[k], v[k])
        found.append(float(one[0]))
    return np.array(found)


@pytest.mark.long
def test_a_fitted_model_says_along_a_record_what_its_fit_says():
    model = Model.build("exponential_law", ("coulomb_friction", "presliding_hysteresis", "creep", "viscous_damping"))
    values = dict(LAW_VALUES)
    for term in model.terms:
        values |= plausible(term.effect, term.form)
    record = saw_tooth(model, values, noise=0.5)
    found = fit(model, record)
    muscle = Muscle(model, record.specimen, found.values, found.values)
    assert muscle.together and muscle.specimen is record.specimen
    rows = np.flatnonzero(record.inputs.segment == 0)  # a muscle does not jump to its next start as a rig does
    alike = np.sign(record.inputs.velocity[rows]) == record.inputs.direction[rows]
    assert alike.mean() > 0.97 and np.abs(record.inputs.velocity[rows]).min() > 2.0
    live = walk(muscle, record, rows)
    np.testing.assert_allclose(live[alike], found.force[rows][alike], rtol=1e-9, atol=1e-8)


def test_branches_fitted_apart_are_blended_by_the_direction():
    model = Model.build("exponential_law", ("creep",))
    there = LAW_VALUES | {"creep.G": 150.0, "creep.tau": 3.0}
    back = there | {"a0": -120.0, "creep.tau": 1.0}
    muscle = Muscle(model, MUSCLE, there, back)
    assert not muscle.together
    p, e = state()
    memory = muscle.start(p, e)
    ones = [Muscle(model, MUSCLE, values, values) for values in (there, back)]
    apart = [one.force(one.values(), one.start(p, e), 0.1, p, e + 0.01, jnp.asarray([20.0, 20.0]))[0] for one in ones]
    assert abs(apart[1] - apart[0]).min() > 60.0
    for speed, share in ((20.0, 1.0), (-20.0, 0.0), (0.0, 0.5), (0.1, 0.5 + 0.5 * np.tanh(0.5))):
        got, _ = muscle.force(muscle.values(), memory, 0.1, p, e + 0.01, jnp.full(2, speed))
        np.testing.assert_allclose(got, share * apart[0] + (1.0 - share) * apart[1], rtol=1e-12)


def test_dry_friction_turns_over_with_the_speed_and_is_gone_at_rest():
    model = Model.build("exponential_law", ("coulomb_friction:held",))
    values = LAW_VALUES | {"coulomb_friction.F_c": 12.0, "coulomb_friction.F_hold": 5.0}
    muscle = Muscle(model, MUSCLE, values, values)
    law = Muscle(Model.build("exponential_law"), MUSCLE, LAW_VALUES, LAW_VALUES)
    p, e = jnp.full(5, 0.3), jnp.full(5, 0.1)
    v = jnp.asarray([-5.0, -0.2, 0.0, 0.2, 5.0])
    rubbing, smooth = (one.force(one.values(), one.start(p, e), 0.1, p, e, v)[0] for one in (muscle, law))
    expected = [12.0, 12.0 * np.tanh(1.0), 0.0, -12.0 * np.tanh(1.0), -12.0]
    np.testing.assert_allclose(rubbing - smooth, expected, atol=1e-9)


def test_cycles_are_counted_as_in_a_record():
    """Each second reversal begins a cycle; a tremor below the speed of reversal does not."""
    model = Model.build("exponential_law", ("mullins_softening",))
    values = LAW_VALUES | {"mullins_softening.s": 0.1, "mullins_softening.n_0": 2.0}
    muscle = Muscle(model, MUSCLE, values, values)
    p, e = jnp.asarray([0.3]), jnp.asarray([0.1])
    law = float(Model.build("exponential_law").force(_record_state(0.3, 0.1), LAW_VALUES)[0])
    memory, cycles = muscle.start(p, e), []
    for k, v in enumerate((0.0, 9.0, 0.05, -0.05, 9.0, -9.0, 0.0, -9.0, 9.0, -9.0, 9.0)):
        force, memory = muscle.force(muscle.values(), memory, 0.1 * k, p, e, jnp.asarray([v]))
        cycles.append(1.0 - 2.0 * np.log((float(force[0]) / law - 1.0) / 0.1))
    np.testing.assert_allclose(cycles, [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 3], atol=1e-9)
    times = np.arange(400) * 0.01
    swing = build_record("s", MUSCLE, np.full(400, 0.3), 0.1 - 0.05 * np.cos(times * 5.0), np.zeros(400), time=times)
    memory, live = muscle.start(p, e), []
    for k, v in enumerate(swing.inputs.velocity):
        force, memory = muscle.force(muscle.values(), memory, times[k], p, e, jnp.asarray([v]))
        live.append(1.0 - 2.0 * np.log((float(force[0]) / law - 1.0) / 0.1))
    off = np.abs(np.array(live) - swing.inputs.cycle) > 1e-6
    assert swing.inputs.cycle[-1] == 4.0 and off.sum() <= 3  # a sample at each beginning, where the speed is near 0


def _record_state(p, e):
    return build_record("one", MUSCLE, np.array([p]), np.array([e]), np.zeros(1)).inputs


def test_it_starts_at_rest(rich):
    """No creep, and no deflection but that of the record's first sample; what remains is the law with what does not
    depend on motion."""
    p, e = state()
    values = dict(rich.contraction) | {"presliding_hysteresis.z_0": 0.0}
    rested = replace(rich, contraction=values, extension=values)
    force, _ = rested.force(rested.values(), rested.start(p, e), 0.0, p, e, jnp.zeros(2))
    gone = {"coulomb_friction", "presliding_hysteresis", "creep", "viscous_damping", "pressure_lag"}
    still = {k: v for k, v in rich.contraction.items() if k.split(".")[0] not in gone}
    model = Model.build("exponential_law", ("series_compliance", "bladder_elasticity"))
    expected = [model.force(_record_state(float(a), float(b)), still)[0] for a, b in zip(p, e, strict=True)]
    np.testing.assert_allclose(force, expected, rtol=1e-9)


def swing(muscle, values, memory, steps=200, h=0.0005):
    """Two muscles against each other for `steps`, each with a trial half way, then the accepted instant."""
    p = jnp.asarray([0.3, 0.25])
    way = jnp.asarray([1.0, -1.0])

    def at(memory, t):
        e, v = 0.1 + 0.04 * jnp.sin(40.0 * t) * way, 200.0 * 1.6 * jnp.cos(40.0 * t) * way
        return muscle.force(values, memory, t, p, e, v)

    def step(memory, t):
        trial, _ = at(memory, t + h / 2)
        force, after = at(memory, t + h)
        return after, (force, trial)

    return jax.lax.scan(step, memory, h * jnp.arange(steps))[1]


@pytest.mark.long
def test_it_is_compiled_and_mapped_over_a_thousand_parameter_sets(rich):
    p, e = state((0.3, 0.25), (0.1, 0.1))
    rng = np.random.default_rng(4)
    many = jax.tree.map(lambda x: x * (1.0 + 0.02 * rng.standard_normal(1000)), rich.values())

    def run(values):
        return swing(rich, values, rich.start(p, e, values=values), steps=20)[0]

    together = jax.jit(jax.vmap(run))(many)
    assert together.shape == (1000, 20, 2) and bool(jnp.isfinite(together).all())
    alone = jax.jit(run)
    for k in (0, 417, 999):
        np.testing.assert_allclose(together[k], alone(jax.tree.map(lambda x, k=k: x[k], many)), rtol=1e-9)


@pytest.mark.long
def test_derivatives_by_the_parameters_are_those_of_finite_differences(rich):
    p, e = state((0.3, 0.25), (0.1, 0.1))
    memory = rich.start(p, e)

    def last(values):
        return swing(rich, values, memory, steps=30)[0][-1]

    last = jax.jit(last)
    slopes = jax.jacfwd(last)(rich.values())["contraction"]
    for name in ("a1", "mu", "creep.tau", "series_compliance.compliance", "coulomb_friction.v_s", "pressure_lag.T_p"):
        h = 1e-5 * abs(rich.contraction[name])
        up, down = ({"contraction": rich.contraction | {name: rich.contraction[name] + s}} for s in (h, -h))
        by_steps = (last(rich.values() | up) - last(rich.values() | down)) / (2.0 * h)
        np.testing.assert_allclose(slopes[name], by_steps, rtol=1e-4, atol=1e-9, err_msg=name)


def test_a_fitted_geometry_stays_as_it_was_fitted():
    model = Model.build("chou_hannaford", ("bladder_elasticity",), free_geometry=True)
    values = {"bladder_elasticity.E": 1.2, "r0": 10.6, "theta0": 24.3}
    muscle = Muscle(model, MUSCLE, values, values)
    assert set(muscle.values()["contraction"]) == {"bladder_elasticity.E"}
    p, e = state()
    force = jax.jit(muscle.force)(muscle.values(), muscle.start(p, e), 0.0, p, e, jnp.zeros(2))[0]
    expected = [model.force(_record_state(float(a), float(b)), values)[0] for a, b in zip(p, e, strict=True)]
    np.testing.assert_allclose(force, expected, rtol=1e-12)


@pytest.fixture(scope="module")
def record():
    model = Model.build("exponential_law", ("coulomb_friction",))
    return saw_tooth(model, LAW_VALUES | {"coulomb_friction.F_c": 9.0}, noise=0.5)


@pytest.fixture(scope="module")
def files(tmp_path_factory, record):
    """A record on disk, and what the program writes about it: a fit, fits by branch, a ladder."""
    from typer.testing import CliRunner

    from pam_ident.cli import app

    folder = tmp_path_factory.mktemp("made")
    inputs = record.inputs
    table = np.column_stack([inputs.time, inputs.pressure, inputs.displacement_mm, record.force])
    head = "time_s,pressure_MPa,displacement_mm,force_N"
    np.savetxt(folder / "record.csv", table, delimiter=",", header=head, comments="", fmt="%.9g")
    geometry = "initial_length_mm = 200.0\ninitial_radius_mm = 10.0\nbraid_angle_deg = 25.4\nwall_thickness_mm = 1.5\n"
    (folder / "specimen.toml").write_text(f'[specimen]\nname = "made"\n{geometry}', encoding="utf-8")
    for name, words in {
        "fit": ("fit", "--effect", "coulomb_friction:held", "--branch", "together"),
        "apart": ("fit", "--branch", "separate"),
        "one": ("fit", "--branch", "contraction"),
        "ladder": ("ladder", "--heldout", "refit"),
    }.items():
        command = [words[0], str(folder / "record.csv"), "--law", "exponential_law", *words[1:]]
        result = CliRunner().invoke(app, [*command, "--json", str(folder / f"{name}.json")])
        assert (folder / f"{name}.json").is_file(), result.output
    return folder


def test_a_fit_comes_back_from_its_file(files, record):
    (muscle,) = Muscle.read(files / "fit.json")
    assert muscle.model.labels == ["coulomb_friction:held"] and muscle.together
    assert muscle.specimen == replace(MUSCLE, sensors=None)
    written = json.loads((files / "fit.json").read_text())["branches"]["together"]["parameters"]
    assert muscle.values()["extension"] == {name: one["value"] for name, one in written.items()}
    assert muscle.contraction["coulomb_friction.F_c"] == pytest.approx(9.0, abs=0.2)
    assert Muscle.read(files / "fit.json", specimen=MUSCLE)[0].specimen is MUSCLE


def test_branches_fitted_apart_come_back_apart(files, record):
    (muscle,) = Muscle.read(files / "apart.json")
    fits = fit_branches(Model.build("exponential_law"), record, "separate")
    assert not muscle.together
    for branch in ("contraction", "extension"):
        assert muscle.values()[branch] == pytest.approx(fits[branch].values, rel=1e-4)


def test_a_ladder_comes_back_rung_by_rung(files):
    rungs = Muscle.read(files / "ladder.json")
    written = json.loads((files / "ladder.json").read_text())["rungs"]
    assert len(rungs) == len(written) >= 2 and rungs[0].model.terms == ()
    for muscle, one in zip(rungs, written, strict=True):
        assert muscle.model.labels == one["effects"] and muscle.specimen.name == "made"
        assert muscle.contraction == {name: q["value"] for name, q in one["parameters"].items()}


def test_a_muscle_from_one_branch_is_refused(files):
    with pytest.raises(UsageError, match=r"one\.json: holds contraction; expected both branches"):
        Muscle.read(files / "one.json")


def _lacks_specimen(found):
    del found["specimen"]


def _lacks_parameter(found):
    del found["branches"]["together"]["parameters"]["mu"]


def _nothing_found(found):
    found["branches"]["together"]["parameters"]["mu"]["value"] = None


def _odd_specimen(found):
    found["specimen"]["braid_angle_deg"] = 80.0


def _odd_branches(found):
    found["branches"] = ["together"]


def _unknown_effect(found):
    found["effects"] = ["spindle_play"]


@pytest.mark.parametrize(
    ("change", "error", "told"),
    [
        (_lacks_specimen, DataError, "does not hold its specimen; give a specimen, or fit again"),
        (_lacks_parameter, DataError, "parameter mu of contraction is None"),
        (_nothing_found, DataError, "parameter mu has the value None"),
        (_odd_specimen, DataError, "braid_angle_deg"),
        (_odd_branches, DataError, "'branches' is missing or no dict"),
        (_unknown_effect, UsageError, "unknown effect 'spindle_play'"),
    ],
)
def test_a_file_that_is_not_whole_is_refused(files, tmp_path, change, error, told):
    found = json.loads((files / "fit.json").read_text())
    change(found)
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(found), encoding="utf-8")
    with pytest.raises(error, match=told):
        Muscle.read(path)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (None, "no such file"),
        ("no braces", "is no JSON"),
        ("[1, 2]", "no schema"),
        ('{"schema": "pam-ident/comparison/1"}', "pam-ident/comparison/1"),
    ],
)
def test_another_file_is_refused_with_the_commands_that_write_one(tmp_path, text, told):
    path = tmp_path / "other.json"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match=told) as caught:
        Muscle.read(path)
    for words in (str(path), "pam-ident fit RECORD", "pam-ident ladder RECORD"):
        assert words in str(caught.value)


OWN = """
import numpy as np

from pam_ident.core import Param
from pam_ident.effects import AddsForce, Effect

SIZE = Param("W", "N", "weight", -100.0, 100.0, scale=5.0)


def _columns(inputs, shape, force):
    xp = inputs.pressure.__array_namespace__()
    return COLUMNS


EFFECT = Effect("mine", "Mine", "our own rig", (AddsForce("textbook", "+W", (SIZE,), _columns),), "t")
"""


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ("np.sin(10.0 * inputs.contraction)[:, None]", r"effect mine cannot .*__array_namespace__"),
        ("xp.cumsum(inputs.contraction)[:, None]", "effect mine cannot .*rows are muscles"),
        ("(inputs.time - inputs.time[0])[:, None]", "effect mine cannot .*rows are muscles"),
        ("xp.diff(inputs.contraction)[:, None]", r"effect mine cannot .*shape \(2, 1\) for 3 muscles"),
        ("inputs.pressures[:, None]", "effect mine cannot .*AttributeError"),
    ],
)
def test_an_effect_that_cannot_be_stepped_is_told_why(tmp_path, columns, told):
    with pytest.raises(UsageError, match=told):
        own_muscle(tmp_path, columns)


def own_muscle(folder, columns):
    """A muscle whose model holds an effect of one's own."""
    (folder / "mine.py").write_text(OWN.replace("COLUMNS", columns), encoding="utf-8")
    model = Model.build("chou_hannaford", ("mine",), load_effect_file(folder / "mine.py"))
    return Muscle(model, MUSCLE, {"mine.W": 7.0}, {"mine.W": 7.0})


def test_an_effect_of_ones_own_is_stepped(tmp_path):
    p, e = state()
    muscle = own_muscle(tmp_path, "xp.sin(10.0 * inputs.contraction)[:, None]")
    law = replace(muscle, model=Model.build("chou_hannaford"))
    heavy, light = (m.force(m.values(), m.start(p, e), 0.0, p, e, jnp.zeros(2))[0] for m in (muscle, law))
    np.testing.assert_allclose(heavy - light, 7.0 * np.sin(10.0 * np.asarray(e)), rtol=1e-9)


def test_a_parameter_that_an_earlier_version_took_for_granted_may_be_missing(tmp_path):
    """How far a contact was bent at the first sample: not at all."""
    model = Model.build("exponential_law", ("presliding_hysteresis",))
    values = LAW_VALUES | plausible(model.terms[0].effect, model.terms[0].form)
    path = tmp_path / "fit.json"
    held = {name: {"value": value, "unit": "N"} for name, value in values.items() if not name.endswith("z_0")}
    content = {
        "schema": "pam-ident/fit/1",
        "law": "exponential_law",
        "effects": list(model.labels),
        "branches": {"together": {"parameters": held, "rmse_N": 1.0}},
    }
    path.write_text(json.dumps(content))
    (muscle,) = Muscle.read(path, MUSCLE)
    assert muscle.contraction == {name: held.get(name, {"value": 0.0})["value"] for name in model.names}
    exported = Fitted.read(path, MUSCLE)
    assert exported.values("together") == muscle.contraction
