"""The next experiment: predicted on paper, run on the rig, and then the right effect stands alone."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import Specimen
from pam_ident.diagnosis import diagnose
from pam_ident.diagnosis.experiment import Question, _expected, next_experiment
from pam_ident.diagnosis.possible_runs import possible_runs
from pam_ident.diagnosis.select import investigate
from pam_ident.diagnosis.strokes import Strokes, listed
from pam_ident.diagnosis.track import SharedNoise
from pam_ident.effects import catalogue, get_effect, in_words
from pam_ident.fitting import fit
from pam_ident.model import Model, Term
from pam_ident.records import Record, read_record
from pam_ident.rig import Plan, Protocol, Secret, make_record, write_case
from pam_ident.rig.protocol_file import read_protocol

EXPONENTIAL, CHOU = "exponential_law", "modified_chou_hannaford"
ONE_SPEED = Protocol(speeds_mm_s=(10.0,), hold_s=0.0, hold_rows=0)
ONE_ISOBAR = Protocol((0.3,))
FRICTIONS = {"coulomb_friction", "viscous_damping"}
OVER_PRESSURE = {"coulomb_friction", "pressure_friction"}


def rig_record(folder, plan: Plan) -> Record:
    write_case(folder, make_record(plan))
    return read_record(folder / "record.csv")


def as_run(folder, strokes: Strokes) -> Protocol:
    """The protocol as the rig reads it from the file."""
    path = folder / "next.toml"
    path.write_text(strokes.toml("the next experiment"))
    return read_protocol(path)


@pytest.fixture(scope="module")
def rubbing(tmp_path_factory):
    """A record of one speed, with friction that leaves nothing in holds, tried."""
    plan = Plan(61, CHOU, (Secret("coulomb_friction", "tanh", 2.0),), protocol=ONE_SPEED)
    record = rig_record(tmp_path_factory.mktemp("rubbing"), plan)
    base = fit(Model.build(CHOU), replace(record, inputs=record.steady), detail=False)
    selection, _ = investigate(base, [e for e in catalogue().values() if e.candidate])
    return plan, record, selection, selection.refit([Term(*get_effect("coulomb_friction"))])


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "poor", "effect", "rivals", "lever"),
    [
        (EXPONENTIAL, ONE_SPEED, "coulomb_friction", FRICTIONS, "speed"),
        (CHOU, ONE_ISOBAR, "pressure_friction", OVER_PRESSURE, "pressure"),
        (EXPONENTIAL, ONE_SPEED, "viscous_damping", FRICTIONS, "speed"),
        (CHOU, ONE_ISOBAR, "coulomb_friction", OVER_PRESSURE, "pressure"),
    ],
)
def test_the_run_it_asks_for_names_the_right_one_alone(tmp_path, law, poor, effect, rivals, lever):
    plan = Plan(62, law, (Secret(effect, "textbook", 2.0),), protocol=poor)
    first = diagnose(Model.build(law), rig_record(tmp_path, plan))
    assert any(rivals <= set(group) for group in first.groups)
    experiment = first.next_experiment
    assert experiment is not None and experiment.protocol is not None and experiment.minutes is not None
    assert lever in experiment.vary and experiment.minutes < 20.0
    told = {s.rival: s.standard_errors for s in experiment.predicted if s.effect == first.selected[0]}
    (other,) = rivals - {first.selected[0]}
    assert told[other] > 5.0 and in_words(other) in experiment.text
    higher = max(experiment.protocol.pressures_MPa) > max(poor.pressures_MPa)
    assert higher == ("only if the muscle is rated for it" in experiment.text)
    run = replace(plan, protocol=as_run(tmp_path, experiment.protocol))
    again = diagnose(Model.build(law), rig_record(tmp_path, run))
    assert again.selected == (effect,) and again.groups == ()


def test_the_predicted_separation_is_what_refits_on_the_rig_s_run_find(tmp_path, rubbing):
    """√(χ² of the best rival form − χ² of the truth) of exact fits to the run, against the linearised forecast."""
    plan, record, selection, fitted = rubbing
    question = Question(selection, fitted, fitted.terms[0], [get_effect("viscous_damping")[0]])
    strokes = possible_runs(record, Model.build(CHOU), fitted.values)[0].strokes
    inputs = strokes.inputs(record.specimen)
    (forecast,), (both_ways,) = question._if_true(inputs, *question.ways[0]), question.separations(inputs)
    run = rig_record(tmp_path, replace(plan, protocol=as_run(tmp_path, strokes)))
    run = replace(run, inputs=run.steady)
    forms = [f"viscous_damping:{form.name}" for form in get_effect("viscous_damping")[0].forms]
    squares = [np.sum(fit(Model.build(CHOU, (name,)), run, detail=False).residual ** 2) for name in forms]
    truth = np.sum(fit(Model.build(CHOU, ("coulomb_friction",)), run, detail=False).residual ** 2)
    assert forecast.standard_errors == pytest.approx(np.sqrt(min(squares) - truth) / plan.sigma_N, rel=0.25)
    assert both_ways.standard_errors < forecast.standard_errors  # friction could follow damping that thins


def test_power_without_a_rival_is_the_closed_form_of_one_more_column(rubbing):
    _, record, selection, fitted = rubbing
    inputs = Strokes((0.3, 0.2, 0.5), (40.0, 30.0, 50.0), (2.0, 40.0)).inputs(record.specimen)
    (found,) = Question(selection, fitted, fitted.terms[0], []).separations(inputs)
    # k0 π r0² p [a (1 − k1 ε)² − b] + k2 spans p, pε and pε² up to one tie, which friction of one size does not feel.
    s, p, e = record.specimen, inputs.pressure, inputs.contraction
    k0, k1 = fitted.values["k0"], fitted.values["k1"]
    area = np.pi * s.initial_radius_mm**2
    slope_k0 = area * p * (s.a * (1 - k1 * e) ** 2 - s.b)
    slope_k1 = -2 * k0 * area * p * s.a * (1 - k1 * e) * e
    law = np.column_stack([slope_k0, slope_k1, np.ones_like(p)])
    model = selection.base.model.adding(*fitted.terms)
    rubs = model.force(inputs, fitted.values) - selection.base.model.force(inputs, fitted.values)
    left = rubs - law @ np.linalg.lstsq(law, rubs, rcond=None)[0]
    assert found.standard_errors == pytest.approx(np.linalg.norm(left) / selection.noise.sigma, rel=1e-6)


@pytest.mark.parametrize(
    "strokes",
    [
        Strokes((0.3, 0.2), (35.0, 35.0), (2.0, 40.0)),
        Strokes((0.3,), (35.0,), (5.0, 20.0), hold_s=(1.0, 10.0, 100.0), minor_loops_mm=(1.0, 3.0)),
        Strokes((0.5, 0.4), (45.0, 45.0), (1.0, 40.0), cycles_per_speed=3, hold_s=(4.0,), warming_K=15.0),
    ],
)
def test_the_run_on_paper_is_the_run_on_the_rig(tmp_path, strokes):
    plan = Plan(5, CHOU, protocol=as_run(tmp_path, strokes))
    record = make_record(plan)
    course = plan.protocol.run(record.muscle, np.random.default_rng(1))
    rows = course.rows
    paper = strokes.inputs(Specimen())
    assert paper.time is not None and paper.moving is not None and paper.velocity is not None
    assert paper.temperature is not None and paper.cycle is not None
    assert len(paper) == len(rows) and paper.moving.sum() == (course.moving[rows] != 0).sum()
    assert strokes.seconds == pytest.approx(course.time[-1], rel=0.01) == pytest.approx(paper.time[-1], rel=0.01)
    assert paper.cycle.max() == course.cycle[rows].max()
    for pressure, top in zip(strokes.pressures_MPa, strokes.tops_mm, strict=True):
        there, here = course.pressure[rows] == pressure, paper.pressure == pressure
        assert course.eps[rows][there].max() * 200.0 == pytest.approx(top) == paper.displacement_mm[here].max()
        for way in (1.0, -1.0):
            speeds = np.abs(course.rate[rows][there & (course.moving[rows] == way)]) * 200.0
            mean = np.mean(np.abs(paper.velocity[here & (paper.velocity * way > 0)]))
            assert np.mean(speeds) == pytest.approx(mean, rel=0.01)
    assert np.ptp(paper.temperature) == pytest.approx(np.ptp(record.column("temperature_C")), abs=0.7)


def test_where_nothing_is_open_nothing_is_asked_for(tmp_path):
    record = rig_record(tmp_path, Plan(43, EXPONENTIAL))
    assert diagnose(Model.build(EXPONENTIAL), record).next_experiment is None


def test_what_no_run_separates_is_said_with_the_test_that_would(rubbing):
    """Stribeck friction without its dip is Coulomb friction, whatever is run."""
    _, _, selection, fitted = rubbing
    found = next_experiment(selection, fitted, [("coulomb_friction", "stribeck_friction")])
    assert found is not None and found.protocol is None and found.minutes is None
    assert found.predicted[0].standard_errors < 1.0
    assert "no run of strokes" in found.text and get_effect("stribeck_friction")[0].test in found.text


@pytest.mark.long
def test_an_unknown_pattern_brings_a_run_to_look_at_it_with(tmp_path):
    record = rig_record(tmp_path, Plan(44, EXPONENTIAL, unknown=Secret("screw_ripple", "textbook", 2.0)))
    answer = diagnose(Model.build(EXPONENTIAL), record)
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert answer.pattern is not None and answer.pattern.kind == "periodic"
    found = answer.next_experiment
    assert found is not None and found.vary == ("speed",) and found.protocol is not None
    assert len(found.protocol.speeds_mm_s) == 2


def test_numbers_are_said_as_on_the_rig():
    assert listed((0.1,)) == "0.1" and listed((1.0, 10.0, 100.0)) == "1, 10 and 100"
    words = Strokes((0.3, 0.1), (30.0, 12.0), (2.0, 40.0), hold_s=(1.0, 10.0), minor_loops_mm=(1.0, 3.0)).words()
    assert words.startswith("run 0.1 and 0.3 MPa at 2 and 40 mm/s, 2 cycles each from 0 to 30 mm")
    assert "hold 1 and 10 s in turn" in words and "minor loops of 1 and 3 mm" in words


def test_runs_above_the_record_s_pressures_are_the_last_choice(rubbing):
    _, record, _, fitted = rubbing
    top = record.levels[-1]
    found = sorted(possible_runs(record, Model.build(CHOU), fitted.values), key=lambda run: run.cost)
    above = [max(run.strokes.pressures_MPa) > top for run in found]
    assert above == sorted(above) and set(above) == {False, True}
    assert [run.beyond for run in found] == [top if higher else None for higher in above]


@pytest.mark.parametrize("clock", ["samples", "seconds"])
def test_noise_that_is_coloured_throughout_can_be_expected_of_any_run(rubbing, clock):
    _, record, selection, fitted = rubbing
    shared = SharedNoise((), np.ones(len(record)))
    slow = replace(selection.noise, share=1.0, memory=5.0, clock=clock, decay=np.full(len(record), 0.9), shared=shared)
    found = possible_runs(record, Model.build(CHOU), fitted.values)
    assert found
    for possible in found:
        inputs = possible.strokes.inputs(record.specimen)
        expected = _expected(slow, inputs)
        assert np.all(expected.spread > 0.0) and np.all(np.isfinite(expected.whiten(np.ones(len(inputs)))))
