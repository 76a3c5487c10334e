"""Forty things that an analyst types without reading, and what each gives.

Written down before the functions were, from the habits of lmfit (`result.params`, `fit_report`), statsmodels
(`summary`, `predict` with intervals for mean and observation), PyBOP and pysindy (names or objects).
"""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes

import pam_ident as pam
from pam_ident.core import DataError, PamError, UsageError
from pam_ident.core import Specimen as Muscle

from .conftest import SPECIMEN

INTERVALS = ["mean_low_N", "mean_high_N", "reading_low_N", "reading_high_N"]


@pytest.fixture
def file(frame, tmp_path):
    path = tmp_path / "run.csv"
    frame.to_csv(path, index=False)
    lines = [f"{key} = {value!r}".replace("'", '"') for key, value in SPECIMEN.items()]
    (tmp_path / "muscle.toml").write_text("\n".join(["[specimen]", *lines]), encoding="utf-8")
    return path


# reading


def test_01_read_a_file_with_its_specimen_file(file):
    assert len(pam.read(file, specimen=file.parent / "muscle.toml")) == 1440


def test_02_read_a_path_as_text_with_a_dictionary(file):
    assert pam.read(str(file), specimen=SPECIMEN).specimen.braid_angle_deg == 25.4


def test_03_read_a_table_of_pandas(frame):
    assert pam.read(frame, specimen=SPECIMEN).levels.tolist() == [0.2, 0.3, 0.4, 0.5]


def test_04_read_arrays(frame):
    arrays = {name: column.to_numpy() for name, column in frame.items()}
    assert isinstance(pam.read(arrays, specimen=Muscle(**SPECIMEN)), pam.Record)


def test_05_read_a_bundled_set_by_name():
    assert len(pam.read("dmsp20_300")) == 60


def test_06_a_wrong_name_is_answered_by_the_one_like_it():
    with pytest.raises(DataError, match="hiden_effect: no such file; did you mean the data set hidden_effect"):
        pam.read("hiden_effect")


def test_07_a_table_without_a_muscle_is_told_what_lacks(frame):
    with pytest.raises(UsageError, match=r"specimen=.*initial_length_mm"):
        pam.read(frame)


def test_08_a_record_says_what_it_is(record):
    assert repr(record) == "Record made: 1440 samples at 0.2, 0.3, 0.4, 0.5 MPa"


def test_09_record_summary(record):
    assert "1440 samples" in record.summary() and "braid angle 25.4°" in record.summary()


def test_10_record_plot(record):
    assert isinstance(record.plot(), Axes)


def test_11_record_to_frame_and_back(record):
    again = pam.read(record.to_frame(), specimen=record.specimen)
    assert again.force == pytest.approx(record.force) and again.levels.tolist() == record.levels.tolist()


# fitting


def test_12_fit_by_name(fitted):
    assert fitted.law == "exponential_law" and 8.5 < fitted.rmse < 9.5 and fitted.r2 > 0.99


def test_13_fit_with_effects(rubbing):
    assert rubbing.effects == ("coulomb_friction",) and rubbing.rmse == pytest.approx(1.0, abs=0.1)
    assert rubbing.params.loc["coulomb_friction.F_c", "value"] == pytest.approx(9.0, abs=0.2)


def test_14_fit_with_one_effect_as_text(record, rubbing):
    assert pam.fit(record, "exponential_law", "coulomb_friction").values == pytest.approx(rubbing.values)


def test_15_fit_with_objects(record, rubbing):
    found = pam.fit(record, pam.laws["exponential_law"], effects=[pam.effects.coulomb_friction])
    assert found.values == pytest.approx(rubbing.values)


def test_16_fit_a_model(record, rubbing):
    model = pam.Model("exponential_law", effects=["coulomb_friction"])
    assert pam.fit(record, model).values == pytest.approx(rubbing.values)
    assert repr(model).startswith("Model exponential_law: F = ") and len(repr(model)) < 300


def test_16b_fit_several_records_with_what_they_share(record, tmp_path):
    found = pam.fit([record, "nothing_hidden"], "exponential_law", shared="mu")
    one, two = found.muscles
    assert found.shared == ("mu",) and one.values["mu"] == two.values["mu"] and one.values["a0"] != two.values["a0"]
    assert list(dict.fromkeys(found.params.index.get_level_values("record"))) == ["all", "made", "nothing_hidden"]
    assert found.params.loc[("all", "mu"), "stderr"] > 0.0 and len(found.params) == 13
    assert found.valid and "2 records share mu" in repr(found) and "nothing_hidden" in found.summary()
    assert len(two.predict(0.3, 0.1)) == 1 and two.rmse < found.rmse < one.rmse
    found.to_json(tmp_path / "both.json")
    lines = (tmp_path / "both.json").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["shared"]["parameters"] for line in lines] == [["mu"], ["mu"]]
    with pytest.raises(DataError, match="the fits of 2 records"):
        pam.load(tmp_path / "both.json")
    halves = [record.take(np.arange(k, len(record), 2)) for k in (0, 1)]
    whole = pam.fit(halves, "sarosi", shared="all")
    whole.to_json(tmp_path / "one.json")
    one, force = pam.load(tmp_path / "one.json"), whole.muscles[0].predict(0.3, 0.1)["force_N"].item()
    assert one.predict(0.3, 0.1)["force_N"].item() == pytest.approx(force)
    with pytest.raises(UsageError, match="name it by law="):
        pam.fit(halves, shared="mu")


def test_16c_records_of_one_force_are_two_unless_their_states_are_the_same_too(record):
    other = replace(record, inputs=replace(record.inputs, pressure=1.01 * record.inputs.pressure))
    assert len(pam.fit([record, other], "exponential_law", shared="mu").muscles) == 2
    with pytest.raises(UsageError, match="given twice"):
        pam.fit([record, record], "exponential_law", shared="mu")


def test_17_fit_from_the_path_at_once():
    assert pam.fit("dmsp20_300", "martens_boblan").valid


def test_18_fit_without_a_law_takes_one_and_says_why(record):
    found = pam.fit(record)
    assert found.law == "exponential_law" and "held-out" in found.law_choice.why and "held-out" in repr(found)


def test_19_a_wrong_law_is_refused_at_once_with_the_one_like_it():
    with pytest.raises(UsageError, match=r"unknown law 'exponental_law'; did you mean exponential_law\?"):
        pam.fit("no such file", "exponental_law")


def test_20_a_wrong_effect_is_too():
    with pytest.raises(UsageError, match=r"unknown effect 'crep'; did you mean creep\?"):
        pam.fit("no such file", "exponential_law", effects=["crep"])
    with pytest.raises(UsageError, match="unknown law"):
        pam.Model("exponental_law")
    with pytest.raises(UsageError, match="expected a name"):
        pam.fit("no such file", 3)
    with pytest.raises(UsageError, match="effects 5: expected names"):
        pam.fit("no such file", "exponential_law", effects=5)


def test_21_both_branches_apart(record):
    found = pam.fit(record, "exponential_law", branch="separate")
    assert found.params.index.names == ["branch", "parameter"] and found.rmse < 1.2
    residual = found.residuals["residual_N"]
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(found.rmse)


def test_22_hold_a_parameter(record):
    assert pam.fit(record, "exponential_law", held={"mu": 40.0}).params.loc["mu", "value"] == 40.0


# what a fit knows


def test_23_params_is_a_frame(fitted):
    assert isinstance(fitted.params, pd.DataFrame) and fitted.params["value"]["a1"] == fitted.values["a1"]
    assert set(fitted.params) >= {"value", "stderr", "low", "high", "unit"}


def test_24_summary_and_repr(fitted):
    assert "std. error" in fitted.summary() and "F = (a0 + a1 p)" in fitted.summary()
    assert len(repr(fitted)) < 400 and len(repr(fitted).splitlines()) <= 4
    row = next(line.split() for line in fitted.summary().splitlines() if line.startswith("a1 "))
    assert len({len(row[k].partition(".")[2]) for k in (1, 3, 4)}) == 1, "an interval ends at the place of its value"


def test_25_residuals_has_every_coordinate(fitted):
    found = fitted.residuals
    assert set(found) >= {
        "time_s",
        "pressure_MPa",
        "contraction",
        "branch",
        "cycle",
        "force_N",
        "model_N",
        "residual_N",
    }
    assert np.sqrt(np.mean(found["residual_N"] ** 2)) == pytest.approx(fitted.rmse)


def test_26_predict_a_number(rubbing):
    (row,) = rubbing.predict(0.3, 0.05, branch="contraction").to_dict("records")
    assert row["reading_low_N"] < row["mean_low_N"] < row["force_N"] < row["mean_high_N"] < row["reading_high_N"]
    assert row["reading_high_N"] - row["force_N"] == pytest.approx(2.0, abs=0.4)


def test_27_predict_arrays_that_broadcast(fitted):
    found = fitted.predict(0.25, np.linspace(0.0, 0.1, 5))
    assert len(found) == 5 and not found[INTERVALS].isna().any(axis=None) and not found["outside"].any()


def test_28_predict_at_a_record_or_a_table(fitted, record, frame):
    assert fitted.predict(record)["force_N"].to_numpy() == pytest.approx(fitted.residuals["model_N"].to_numpy())
    table = frame.drop(columns="force_N")
    assert fitted.predict(table)["force_N"].to_numpy() == pytest.approx(fitted.residuals["model_N"].to_numpy())


def test_28a_predict_at_columns_of_any_unit(fitted):
    length = fitted.specimen.initial_length_mm
    found = fitted.predict(pressure_bar=[2.0, 3.0], length_mm=0.95 * length)["force_N"]
    assert found.to_numpy() == pytest.approx(fitted.predict([0.2, 0.3], 0.05)["force_N"].to_numpy())
    with pytest.raises(UsageError, match="columns of one length; pressure_bar has 2, length_mm has 3"):
        fitted.predict(pressure_bar=[2.0, 3.0], length_mm=[1.0, 2.0, 3.0])
    with pytest.raises(UsageError, match="give contraction beside pressure"):
        fitted.predict()


def test_29_predict_without_what_an_effect_needs_says_so(rubbing):
    with pytest.raises(DataError, match="coulomb_friction needs branch at each state: add branch"):
        rubbing.predict(0.3, 0.05)


def test_29a_a_contact_that_bends_slides_in_a_state_without_a_way(record):
    bending = pam.fit(record, "exponential_law", "pressure_friction:bending")
    found = bending.predict([0.4, 0.4], [0.05, 0.05], branch=["contraction", "extension"])["force_N"].to_numpy()
    assert found[1] - found[0] == pytest.approx(18.0, abs=2.0)
    with pytest.raises(DataError, match=r"pressure_friction:bending depends on the way .*: give the states of the way"):
        bending.predict(0.4, 0.05, branch="contraction", time_s=0.0)


def test_29b_predict_by_a_fit_that_is_not_valid_says_so(record):
    loose = pam.fit(record, "exponential_law", "threshold_pressure")
    (problem,) = loose.problems
    with pytest.warns(UserWarning) as told:
        loose.predict(0.2, 0.05)
    assert [str(one.message) for one in told] == [problem]


def test_30_predict_beyond_the_record_says_so(fitted):
    with pytest.warns(UserWarning, match="1 of 2 states lie outside what was fitted"):
        assert fitted.predict([0.3, 0.9], 0.05)["outside"].tolist() == [False, True]


@pytest.mark.filterwarnings("ignore:.* states lie outside")
def test_30a_the_length_under_a_load_is_predicted_from_a_table(fitted):
    found = fitted.predict({"pressure_MPa": [0.4, 0.4], "force_N": [250.0, 350.0]})
    longer, shorter = found["displacement_mm"]
    assert longer > shorter and fitted.predict(0.4, found["contraction"][0])["force_N"].item() == pytest.approx(250.0)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda it: pam.fit(it.record, "sarosi", effect=["creep"]), "pam.fit: unknown argument 'effect'; did you mean"),
        (lambda it: pam.compare(it.record, onyl="creep"), "pam.compare: unknown argument 'onyl'"),
        (lambda it: pam.Model("sarosi", effect="creep"), "pam.Model: unknown argument 'effect'; did you mean effects"),
        (lambda it: pam.fit(), "pam.fit: missing a required argument: 'record'"),
        (lambda it: pam.fit("sarosi", it.record), "expected a name, .* behind the record: pam.fit(record, law)"),
        (lambda it: pam.fit(it.record, "sarosi", held={"s3": "x"}), "held={'s3': 'x'}: expected a number by parameter"),
        (lambda it: pam.fit(it.record, "sarosi", held=["s3"]), "held=['s3']: expected a number by parameter"),
        (lambda it: it.export("cpp", "x.h"), "to='cpp': expected one of c, "),
        (lambda it: pam.track(plant="x"), "plant='x': expected what pam.fit or pam.ladder gave, or a file"),
        (lambda it: pam.track(plnt="x"), "unknown argument 'plnt'; did you mean plant? There is ageing, "),
        (lambda it: pam.read({"pressure_bar": [1]}, {"length": 3}), "There is braid_angle_deg, initial_length_mm"),
        (lambda it: pam.read({"pressure_bar": [1]}, dict.fromkeys(SPECIMEN, "1")), "expected numbers, in mm and deg"),
        (lambda it: pam.diagnose(it.record, "sarosi", only="creep", without="creep"), "creep: the only effect"),
    ],
)  # fmt: skip
def test_a_call_that_cannot_be_is_told_what_was_given_and_what_was_expected(fitted, call, words):
    with pytest.raises(UsageError, match=re.escape(words).replace(r"\.\*", ".*")):
        call(fitted)


@pytest.mark.parametrize(
    ("of", "guess", "meant"),
    [
        ("fitted", "rmse_N", "rmse"),
        ("fitted", "stderr", "params"),
        ("record", "df", "to_frame"),
        ("record", "p", "passed or plot or pressure"),
        ("fitted", "save", "to_json"),
        ("fitted", "conf_int", r"params\?"),
        ("fitted", "noise", r"pam.diagnose\(record, model\)\?"),
        ("record", "head", r"to_frame\?"),
        ("record", "sample_rate", r"inputs.interval\?"),
        ("record", "query", r"pam.read\(record, where=…\)\?"),
        ("diagnosis", "probability", "candidates"),
        ("diagnosis", "colour", "against, candidates, "),
    ],
)
def test_a_name_that_is_guessed_is_answered_by_what_may_be_meant(request, of, guess, meant):
    with pytest.raises(AttributeError, match=f"object has no attribute '{guess}'; (did you mean|it offers) {meant}"):
        getattr(request.getfixturevalue(of), guess)


def test_rows_are_read_by_a_condition(frame):
    assert pam.read(frame, SPECIMEN, where="pressure_MPa > 0.25").levels.tolist() == [0.3, 0.4, 0.5]
    with pytest.raises(UsageError, match=re.escape("where=\"branch == 'out' or\": cannot be read; expected")):
        pam.read(frame, SPECIMEN, where="branch == 'out' or")


def test_30b_predict_where_no_muscle_is_is_refused_as_the_command_does(fitted):
    with pytest.raises(DataError, match="contraction, element 1: contraction ratio 10; expected within"):
        fitted.predict(0.3, [0.05, 10])
    with pytest.raises(DataError, match="pressure: 30 MPa; expected a gauge pressure below 10 MPa"):
        fitted.predict(30, 0.1)


def test_31_plot(fitted):
    axes = fitted.plot()
    assert isinstance(axes, Axes) and axes.get_ylabel() == "force (N)"


def test_32_to_json_and_load(rubbing, tmp_path, record):
    rubbing.to_json(tmp_path / "fit.json")
    again = pam.load(tmp_path / "fit.json")
    pd.testing.assert_frame_equal(again.predict(record), rubbing.predict(record))
    pd.testing.assert_frame_equal(again.params, rubbing.params, check_dtype=False)


def test_32b_a_ladder_comes_back_to_be_asked(tmp_path, record):
    pam.ladder(record, "exponential_law", heldout="refit").to_json(tmp_path / "ladder.json")
    again = pam.load(tmp_path / "ladder.json")
    assert again.validate(record).rmse == pytest.approx(again["rungs"][-1]["rmse_N"]) and "rms (from" in repr(again)
    assert {"value", "stderr", "low", "high"} <= set(again.params) and len(again.predict(record)) == len(record)


def test_33_validate_on_another_record(fitted, record):
    found = fitted.validate(record)
    assert found.rmse == found.trial.rmse == pytest.approx(fitted.rmse) and 0.9 < found.coverage <= 1.0
    assert set(found.simpler) == {"mean_over_pressure", "polynomial"} and "mean_over_pressure" not in found.as_well


def test_33b_what_is_printed_is_a_few_lines(fitted, record):
    for one in (fitted.validate(record), pam.effects.creep, pam.laws["sarosi"]):
        assert repr(one).count("\n") < 9 and len(repr(one)) < 1500 and "(name=" not in repr(one)
        assert one._repr_html_().startswith("<pre>")
    assert "N rms" in repr(fitted.validate(record)) and pam.laws["sarosi"].formula in repr(pam.laws["sarosi"])


def test_33c_export(fitted, tmp_path):
    fitted.to_json(tmp_path / "fit.json")
    again = pam.load(tmp_path / "fit.json")
    assert fitted.export("c", tmp_path / "arm.h") == again.export("c", tmp_path / "arm.h") == (tmp_path / "arm.h",)
    assert [path.name for path in fitted.export("mujoco", tmp_path / "leg.xml")] == ["leg.xml", "leg.py"]


def test_34_to_lmfit(rubbing):
    found = rubbing.to_lmfit()
    assert found["coulomb_friction__F_c"].value == rubbing.values["coulomb_friction.F_c"]
    assert found["a1"].stderr == pytest.approx(rubbing.params["stderr"]["a1"])


# the other verbs


def test_35_compare_a_record_or_a_fit(fitted, record):
    ours, theirs = pam.compare(fitted), pam.compare(record, "exponential_law")
    assert ours.sentence == theirs.sentence and ours.follows["share"].idxmax() == "direction"
    assert ours.follows["share"].sum() == pytest.approx(1.0) and isinstance(ours.plot(), Axes)


@pytest.fixture(scope="module")
def diagnosis(record):
    return pam.diagnose(record, "exponential_law", only=["coulomb_friction", "viscous_damping", "force_bias"])


def test_36_diagnose(diagnosis, tmp_path):
    assert diagnosis.verdict == "missing_effect" and diagnosis.selected == ("coulomb_friction",)
    assert diagnosis.candidates["probability"].idxmax() == "coulomb_friction" and isinstance(diagnosis.plot(), Axes)
    assert diagnosis.params.loc["coulomb_friction.F_c", "value"] == pytest.approx(9.0, abs=0.3)
    assert len(repr(diagnosis)) < 600 and diagnosis.to_json()["selected"] == ["coulomb_friction"]


def test_37_ladder(record):
    found = pam.ladder(record, "exponential_law", only="coulomb_friction", heldout="refit")
    assert found.effects == ("coulomb_friction",) and found.rungs["rmse_N"].is_monotonic_decreasing
    assert isinstance(found.plot(), Axes) and len(repr(found)) < 500


@pytest.mark.long
def test_38_report(fitted, tmp_path):
    assert fitted.report(tmp_path / "answer.html").read_text(encoding="utf-8").startswith("<!")
    assert pam.report(fitted, out=tmp_path / "other.html").is_file()


# the module


def test_39_tab_shows_these_and_nothing_else():
    shown = {name for name in dir(pam) if not name.startswith("__")}
    assert shown == {
        "read", "fit", "compare", "diagnose", "ladder", "report", "batch", "track", "load", "Record", "Model", "laws",
        "effects", "PamError", "DataError", "FitError", "UsageError",
    }  # fmt: skip
    with pytest.raises(pam.DataError, match="no such file") as refused:
        pam.read("nowhere.csv")
    assert isinstance(refused.value, pam.PamError)
    with pytest.raises(AttributeError, match="did you mean ladder"):
        _ = pam.lader
    for name, instead in {
        "add": "effects=",
        "validate": ".validate(",
        "predict": ".predict(",
        "inspect": "read",
    }.items():
        with pytest.raises(AttributeError, match=f"no attribute '{name}'; use pam.*{re.escape(instead)}"):
            getattr(pam, name)


def test_40_what_there_is():
    assert "exponential_law" in list(pam.laws) and "creep" in pam.effects and "creep" in dir(pam.effects)
    assert "creep and stress relaxation" in repr(pam.effects) and pam.laws.to_frame().loc["sarosi", "title"]
    with pytest.raises(KeyError, match="did you mean sarosi"):
        pam.laws["sarosy"]
    assert issubclass(UsageError, PamError)


def test_a_record_has_what_was_driven_at_hand_and_says_what_is_grave(frame):
    record = pam.read(frame, specimen=SPECIMEN)
    assert record.pressure is record.inputs.pressure and record.time is record.inputs.time
    assert record.contraction is record.inputs.contraction
    tenfold = pam.read(frame.assign(pressure_MPa=0.1 * frame["pressure_MPa"]), specimen=SPECIMEN)
    assert "\n- WARNING (scale): " in tenfold.summary() and "WARNING" not in record.summary()
    with pytest.raises(UsageError, match=r"expected the path of a columns\.toml"):
        pam.read(frame, specimen=SPECIMEN, columns={"force_N": "F"})
