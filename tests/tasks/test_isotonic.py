"""What the verbs answer of weights that a muscle of the virtual rig lifts: the length, or one sentence."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pam_ident.batch.record import answer
from pam_ident.batch.request import BatchRequest, plan
from pam_ident.core import DataError, Specimen, UsageError
from pam_ident.core.digits import millimetres
from pam_ident.diagnosis.remainder import weight_or_level
from pam_ident.effects import catalogue
from pam_ident.fitting import fit
from pam_ident.fitting.carried import driven, length_rmse
from pam_ident.model import Model
from pam_ident.records import build_record, read_record
from pam_ident.rig import Plan, Secret, make_record, write_case
from pam_ident.schema.diagnosis import comparison_json, diagnosis_json
from pam_ident.schema.fit import fit_json
from pam_ident.schema.prediction import law_choice_json, validation_json
from pam_ident.tasks.add import add_effects
from pam_ident.tasks.compare import compare_record, failure_picture
from pam_ident.tasks.diagnose import diagnose_record
from pam_ident.tasks.fit import FitOptions, fit_record
from pam_ident.tasks.gate import GraveDoubt, Refused
from pam_ident.tasks.ladder import climb_ladder
from pam_ident.tasks.law_choice import choose_for_all, settle
from pam_ident.tasks.predict import predict_at, read_fit
from pam_ident.tasks.report import report_record
from pam_ident.tasks.setup import AUTO, Setup
from pam_ident.tasks.validate import validate_fit
from pam_ident.workbench.bench import Bench

SETUP = Setup("exponential_law")
NOISE_MM = 0.025


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    """One muscle of the rig under weights and on isobars: the records' files."""
    folder = tmp_path_factory.mktemp("rig")
    for protocol in ("weight_ramps", "weight_stairs", "standard"):
        write_case(folder / protocol, make_record(Plan(4, protocol=protocol)))
    return {path.name: path / "record.csv" for path in folder.iterdir()}


@pytest.fixture(scope="module")
def saved(cases, tmp_path_factory):
    """Fits to each of them, read back from their files."""
    folder = tmp_path_factory.mktemp("fits")

    def fitted(name):
        answer = fit_record(read_record(cases[name]), SETUP)
        path = folder / f"{name}.json"
        path.write_text(json.dumps(fit_json(name, SETUP.law, answer), default=lambda a: a.tolist()))
        return read_fit(path)

    return {name: fitted(name) for name in ("weight_ramps", "standard")}


def test_a_fit_says_its_errors_in_mm_and_what_the_newtons_are(cases):
    answer = fit_record(read_record(cases["weight_ramps"]), SETUP)
    assert not answer.problems and answer.passive is None
    found = fit_json("w", SETUP.law, answer)
    one = found["branches"]["together"]
    assert one["rmse_mm"] < NOISE_MM and one["max_error_mm"] < 8 * NOISE_MM and one["r2"] > 0.999
    assert one["rmse_N"] == pytest.approx(2.0, rel=0.1)  # the load cell's noise, at the measured length
    assert one["left_out"] == 0 and len(one["weights_N"]) == 3
    assert "repeats_N" not in one and one["repeats_mm"] == pytest.approx(one["rmse_mm"], rel=0.1)
    assert found["loops"] == [] and one["simpler"]["mean_over_pressure"] is None


def test_a_fit_of_isobars_has_no_millimetres(cases):
    one = fit_json("s", SETUP.law, fit_record(read_record(cases["standard"]), SETUP))["branches"]["together"]
    assert not [key for key in one if key.endswith("_mm") or key in ("left_out", "weights_N")]


def test_compare_says_under_which_weight_the_length_fails(cases):
    found = compare_record(read_record(cases["weight_ramps"]), Setup("hildebrandt"))
    assert "misses the length by 0.0" in found.sentence and " mm rms" in found.sentence
    told = comparison_json("w", found)
    weights = told["by"]["load_N"]
    assert [w["rms_N"] for w in weights] == [None] * 3 and sum(w["share"] for w in weights) == pytest.approx(1.0)
    assert min(w["rms_mm"] for w in weights) > NOISE_MM
    assert (
        sum(part["share"] for part in told["follows"]) == pytest.approx(1.0)
        and told["map"]["rms_N"] is None
        and np.nanmax(told["map"]["rms_mm"]) > 0.0
    )
    assert len(told["by"]["pressure_MPa"]) == 10 and told["rmse_mm"] == found.fit.length_errors.rmse
    with pytest.raises(UsageError, match="--out draws an error of the force"):
        failure_picture(found, ".svg")


def test_a_fit_on_isobars_predicts_lengths_and_the_reverse(cases, saved):
    lengths = validate_fit(saved["standard"], read_record(cases["weight_stairs"]))
    assert lengths.in_mm and lengths.trial.rmse < NOISE_MM and lengths.coverage > 0.9
    assert "predicts the length of" in lengths.sentence and not lengths.as_well
    told = validation_json("f", "w", lengths)
    assert told["rmse_mm"] == lengths.trial.rmse and told["rmse_N"] == lengths.in_force.rmse
    own = fit_record(read_record(cases["standard"]), SETUP).fits["together"].rmse
    forces = validate_fit(saved["weight_ramps"], read_record(cases["standard"]))
    assert not forces.in_mm and forces.trial.rmse < 1.3 * own and "rmse_mm" not in validation_json("f", "s", forces)


def test_the_static_curve_is_predicted_at_other_loads(saved, tmp_path):
    made = make_record(Plan(4, protocol="weight_ramps"))
    table = pd.DataFrame(
        {"pressure_MPa": np.tile(np.linspace(0.3, 0.5, 5), 2), "force_N": np.repeat([100.0, 230.0], 5)}
    )
    table.to_csv(tmp_path / "loads.csv", index=False)
    for one in saved.values():
        frame = predict_at(one, tmp_path / "loads.csv").frame
        length = made.muscle.specimen.initial_length_mm
        truth = made.muscle.contraction(table["pressure_MPa"].to_numpy(), table["force_N"].to_numpy()) * length
        assert np.abs(frame["displacement_mm"] - truth).max() < 0.1
        assert np.all((frame["mean_low_mm"] - 0.02 < truth) & (truth < frame["mean_high_mm"] + 0.02))
    assert np.isfinite(predict_at(saved["standard"], tmp_path / "loads.csv").frame["reading_low_mm"]).all()
    table.assign(force_N=1e5).to_csv(tmp_path / "heavy.csv", index=False)
    assert predict_at(saved["standard"], tmp_path / "heavy.csv").frame["outside"].all()
    table.assign(force_N=-5e3).to_csv(tmp_path / "pushed.csv", index=False)
    assert predict_at(saved["standard"], tmp_path / "pushed.csv").frame["displacement_mm"].isna().all()


@pytest.mark.long
@pytest.mark.parametrize(
    ("effect", "form", "named"),
    [
        ("creep", "textbook", ["creep"]),
        ("coulomb_friction", "sticking", ["coulomb_friction"]),
        ("pressure_lag", "textbook", ["pressure_lag"]),
        ("mullins_softening", "textbook", ["mullins_softening"]),
        (None, None, []),
    ],
)
def test_what_is_hidden_under_weights_is_named_less_surely(tmp_path, effect, form, named):
    secrets = (Secret(effect, form, 3.0),) if effect else ()
    write_case(tmp_path, make_record(Plan(11, protocol="weight_ramps", secrets=secrets)))
    found = diagnose_record(read_record(tmp_path / "record.csv"), SETUP)
    assert list(found.selected) == named and found.verdict == ("missing_effect" if named else "adequate")
    assert all(one.probability < 0.9 for one in found.ranking)
    assert "errors are those of the force at the measured length" in found.sentence
    assert found.best.rmse < 1.1 * found.noise_floor


@pytest.mark.long
def test_a_static_effect_brings_nothing_along_where_the_law_predicts_other_lengths(tmp_path):
    """Along the law's own lengths two static effects had been a softening and a free form, and a group of four."""
    law, hidden = "modified_chou_hannaford", (Secret("bladder_elasticity", "mooney_rivlin", 8.0),)
    write_case(tmp_path, make_record(Plan(5, law, hidden, protocol="weight_ramps")))
    found = diagnose_record(read_record(tmp_path / "record.csv"), Setup(law))
    assert "bladder_elasticity" in found.selected and all(catalogue()[name].static for name in found.selected)
    assert found.best.rmse < 1.1 * found.noise_floor and found.rmse_after_mm < 0.1 * found.rmse_mm
    assert found.base.record is found.best.record


def test_nothing_measured_of_the_length_enters_what_explains_it(cases):
    record = read_record(cases["weight_ramps"])
    along = driven(SETUP.model, record)
    one = fit(SETUP.model, record)
    noisy = replace(record.inputs, contraction=record.inputs.contraction + 1e-4 * np.sin(np.arange(len(record))))
    assert np.array_equal(
        driven(SETUP.model, replace(record, inputs=noisy), one.values).inputs.contraction, along.inputs.contraction
    )
    left = along.force - SETUP.model.force(along.inputs, one.values)
    assert len(along) > 0.99 * len(record)
    told = one.residual[np.isin(record.inputs.time, along.inputs.time)]
    assert np.allclose(left, told, atol=0.02)  # the error of the force at the measured length
    assert driven(SETUP.model, along) is along


@pytest.mark.long
def test_a_ladder_and_an_addition_are_of_the_same_force(tmp_path):
    write_case(tmp_path, make_record(Plan(11, protocol="weight_stairs", secrets=(Secret("creep", "textbook", 3.0),))))
    record = read_record(tmp_path / "record.csv")
    found = climb_ladder(record, replace(SETUP, heldout="refit"))
    added = add_effects(record, replace(SETUP, effects=("creep",)))
    assert [rung.fit.model.effect_names for rung in found.rungs] == [[], ["creep"]]
    assert added.before.rmse == pytest.approx(found.rungs[0].fit.rmse, rel=1e-6)
    assert added.after.rmse < 0.6 * added.before.rmse


@pytest.mark.long
def test_a_ladder_that_ends_early_ends_along_the_predicted_lengths(cases, monkeypatch):
    """An effect that remembers the way cannot predict the length, so what ends the ladder may not be fitted to that."""
    model = Model.build("exponential_law", ["mullins_softening"])
    ends = []
    monkeypatch.setattr(
        "pam_ident.tasks.ladder.nested", lambda found, again, ended, *_: ends.append(ended(model)) or found
    )
    climb_ladder(read_record(cases["weight_ramps"]), SETUP)
    assert ends[0].base.model.labels == model.labels and ends[0].base.record.carried


@pytest.mark.long
def test_errors_of_the_length_stand_beside_those_of_the_force(tmp_path):
    hidden = (Secret("coulomb_friction", "sticking", 3.0),)
    write_case(tmp_path, make_record(Plan(11, protocol="weight_ramps", secrets=hidden)))
    record = read_record(tmp_path / "record.csv")
    ladder = climb_ladder(record, replace(SETUP, heldout="refit"))
    first = ladder.first
    before, after = (fit(one.model, record).length_errors.rmse for one in (first.base, first.best))
    assert [rung.rmse_mm for rung in ladder.rungs] == pytest.approx([before, after], rel=1e-3)
    told = diagnosis_json("r", first, ())
    assert [told["rmse_mm"], told["rmse_after_mm"]] == pytest.approx([before, after], rel=1e-3)
    words = f"fitted to the length, the model errs by {millimetres(before)} → {millimetres(after)}"
    assert after < 0.8 * before and words in first.sentence
    creeping = fit(replace(SETUP, effects=("creep",)).model, driven(SETUP.model, record))
    assert length_rmse(creeping) is None  # it remembers the way that it should say


def test_a_slip_of_the_lengths_unit_stops_naming(cases, tmp_path):
    table = pd.read_csv(cases["weight_stairs"])
    (tmp_path / "specimen.toml").write_text(cases["weight_stairs"].with_name("specimen.toml").read_text(), "utf-8")
    table.assign(displacement_mm=table["displacement_mm"] / 10.0).to_csv(tmp_path / "cm.csv", index=False)
    with pytest.raises(GraveDoubt, match=r"under its loads the contraction changes by 0\.0"):
        diagnose_record(read_record(tmp_path / "cm.csv"), SETUP)


def test_a_load_that_was_not_held_is_no_weight(cases):
    told = replace(read_record(cases["standard"]), said_kind="isotonic")
    with pytest.raises(Refused, match="rms off a held load"):
        diagnose_record(told, SETUP)


@pytest.mark.long
@pytest.mark.parametrize("name", ["weight_ramps", "weight_stairs"])
def test_laws_are_compared_by_the_length_that_they_predict(cases, name):
    setup, choice = settle(read_record(cases[name]), Setup(AUTO))
    taken = next(trial for trial in choice.trials if trial.law == setup.law)
    assert " mm on held-out data" in choice.why and taken.heldout_rmse < 2 * NOISE_MM
    assert {"rmse_mm", "heldout_rmse_mm"} < law_choice_json(choice)["law_choice"]["laws"][0].keys()


def test_what_cannot_be_answered_is_refused_in_one_sentence(cases):
    record = read_record(cases["weight_ramps"])
    with pytest.raises(UsageError, match="by length in the other"):
        choose_for_all((record, read_record(cases["standard"])), Setup(AUTO))
    for wish in ({"method": "two-stage"}, {"intervals": "profile"}, {"loss": "huber"}):
        with pytest.raises(UsageError, match="the length answers"):
            fit_record(record, SETUP, FitOptions(**wish))
    with pytest.raises(DataError, match="remembers the way"):
        fit_record(record, Setup("exponential_law", ("creep",)))


@pytest.mark.parametrize("name", ["01.57", "06.28", "181607", "182351"])
def test_a_sandbag_says_that_one_weight_is_not_enough(realdata, name):
    file = realdata / "mit2151_mckibben300mm" / "deadweight" / f"{name}.dat"
    answer = fit_record(read_record(file), Setup("modified_chou_hannaford"))
    assert "one_weight" in [doubt.code for doubt in answer.warnings]
    assert any("hang other weights" in problem for problem in answer.problems)
    assert not answer.fits["together"].estimates[0].identified
    assert (answer.fits["together"].lengths.limit.sum() > 1800) == (name == "182351")


@pytest.mark.long
def test_a_batch_keeps_the_error_of_the_length(cases, tmp_path):
    question = BatchRequest(SETUP, diagnose=True)
    items = plan(cases["weight_ramps"].parent.parent, question, tmp_path).items
    rows = {item.name: answer(question, item)["rows"][0] for item in items}
    lifted, held = rows["weight_ramps/record.csv"], rows["standard/record.csv"]
    assert lifted["error"] is None and lifted["verdict"] == "adequate"
    assert lifted["rmse_mm"] < NOISE_MM and held["rmse_mm"] is None


@pytest.mark.long
def test_the_workbench_goes_along_the_lengths_that_the_law_predicts(cases):
    record = read_record(cases["weight_ramps"])
    bench = Bench.begin(record, "ramps.csv", SETUP)
    assert bench.record.carried and bench.fit.rmse == pytest.approx(
        add_effects(record, replace(SETUP, effects=("creep",))).before.rmse
    )
    found = bench.diagnosed()
    assert found.diagnosis.verdict == diagnose_record(record, SETUP).verdict == "adequate"
    assert "errors are those of the force at the measured length" in found.diagnosis.sentence
    assert found.adding("creep").rungs[0] is found.rungs[0]


def locked_record():
    """A muscle locked at four lengths, its pressure driven up and down, with friction that grows with it."""
    muscle, rng = Specimen("locked", 200.0, 10.0, 25.4), np.random.default_rng(3)
    ramp = np.r_[np.linspace(0.05, 0.5, 100), np.linspace(0.5, 0.05, 100)]
    p, e = np.tile(ramp, 4), np.repeat([0.0, 0.05, 0.1, 0.15], 200)
    rub = -20.0 * p * np.tile(np.repeat([1.0, -1.0], 100), 4)
    force = muscle.ideal_force(p, e) + rub + rng.normal(0.0, 2.0, 800)
    return build_record("locked", muscle, p, e, force, time=0.2 * np.arange(800))


@pytest.mark.long
@pytest.mark.parametrize("kind", ["isometric", "isotonic"])
def test_a_report_of_a_driven_pressure_tells_of_no_isobar(cases, tmp_path, kind):
    record = locked_record() if kind == "isometric" else read_record(cases["weight_ramps"])
    out = tmp_path / "report.html"
    report_record(record, Setup("modified_chou_hannaford", only=("pressure_friction",), heldout="refit"), str(out))
    page = out.read_text(encoding="utf-8")
    assert f"samples, {kind}: pressure driven" in page and "What answered the pressure" in page
    assert "Isobar by isobar" not in page and "Energy of the loops" not in page


def test_noise_is_looked_at_by_the_weight_that_was_held():
    """It may grow with the weight, and a heavy one move more slowly: nothing sticks there."""
    rng, parts, begun = np.random.default_rng(6), [], 0.0
    muscle, law = Specimen("m", 200.0, 10.0, 25.4, 1.5), Model.build("chou_hannaford")
    for weight in (100.0, 400.0):
        ramp = np.arange(0.25, 0.55, 0.004)
        pressure = np.tile(np.r_[ramp, ramp[::-1]], 4)
        force = weight + 0.002 * weight * rng.standard_normal(len(pressure))
        contraction = muscle.ideal_contraction(pressure, np.full(len(pressure), weight))
        parts.append((begun + 0.1 * np.arange(len(pressure)), pressure, contraction, force))
        begun = parts[-1][0][-1] + 20.0
    time, pressure, contraction, force = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    record = build_record("two weights", muscle, pressure, contraction, force, time=time)
    along = driven(law, record)
    assert record.kind == "isotonic" and len(np.unique(along.level)) == 1
    assert np.unique(np.round(weight_or_level(along), -1)).tolist() == [100, 400]
