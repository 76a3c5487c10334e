"""Effects that are no candidates by themselves: told of where they may be, and named where they are asked for."""

from dataclasses import replace

import numpy as np
import pytest

from pam_ident.core import UsageError
from pam_ident.diagnosis import climb, diagnose
from pam_ident.diagnosis.nouns import Follows
from pam_ident.diagnosis.sentence import could_be_tried
from pam_ident.effects import catalogue
from pam_ident.fitting import fit
from pam_ident.model import Model
from pam_ident.records import read_record, thinned
from pam_ident.records.datasets import dataset_record
from pam_ident.rig import Plan, Secret, make_record, write_case

LAW = Model.build("modified_chou_hannaford")


@pytest.fixture(scope="module")
def weighted(tmp_path_factory):
    """A record of strokes that speed up and brake with a mass, by the rig's own formula, and that mass in kg."""
    folder = tmp_path_factory.mktemp("mass")
    made = make_record(
        Plan(15, LAW.law.name, unknown=Secret("dynamics", "moving_mass", 3.0), sigma_N=1.0, protocol="sines")
    )
    write_case(folder, made)
    run, moves = made.course, made.course.moving != 0
    x = 1e-3 * run.length_mm * run.eps  # m, of which the second derivative is taken within each move
    rate = np.gradient(np.gradient(x, run.time + 1e-9 * np.arange(len(x))), run.time + 1e-9 * np.arange(len(x)))
    inner = moves & np.roll(moves, 4) & np.roll(moves, -4) & (np.abs(rate) < 3.0 * np.std(rate[moves]))
    mass = -float(rate[inner] @ made.hidden[0].force[inner] / (rate[inner] @ rate[inner]))
    return read_record(folder / "record.csv"), mass


@pytest.mark.long
def test_a_mass_is_unknown_by_itself_and_the_answer_says_what_could_be_tried(weighted):
    found = diagnose(LAW, weighted[0])
    assert found.verdict == "unknown_effect" and found.selected == ()
    assert found.sentence.endswith(
        "Tried only if asked for, and following the acceleration, too: inertia of the moving mass (--also moving_mass)."
    )
    assert "moving_mass" not in {one.effect for one in found.ranking}


@pytest.mark.long
def test_a_mass_is_named_and_found_where_it_is_asked_for(weighted):
    record, mass = weighted
    found = diagnose(LAW, record, also=("moving_mass",))
    assert found.verdict == "missing_effect" and found.labels == ("moving_mass",)
    assert found.best.values["moving_mass.m"] == pytest.approx(mass, rel=0.02)
    assert found.best.rmse < 1.15 * found.noise_floor and "--also" not in found.sentence


@pytest.mark.long
def test_a_soft_stop_of_the_rig_is_named_with_its_place_and_stiffness(tmp_path):
    law = Model.build("exponential_law")
    made = make_record(Plan(44, law.law.name, unknown=Secret("rub", "end_stop", 3.0)))
    write_case(tmp_path, made)
    found = diagnose(law, read_record(tmp_path / "record.csv"), also=("end_contact",))
    hidden = made.hidden[0]
    assert found.verdict == "missing_effect" and found.labels == ("end_contact",)
    assert found.best.values["end_contact.e_c"] == pytest.approx(hidden.settings["from"], abs=0.002)
    stiffness = hidden.size / 0.01 / made.course.length_mm
    assert found.best.values["end_contact.K"] == pytest.approx(stiffness, rel=0.03)


def lonely_stroke(record):
    """25 N more until the motion first turns."""
    inputs = record.inputs
    first = int(np.argmax(inputs.moving))
    turn = first + int(np.argmax(inputs.direction[first:] != inputs.direction[first]))
    return 25.0 * ((np.arange(len(record)) >= first) & (np.arange(len(record)) < turn))


def minor_loops(record):
    """Three elements of 10 N that yield at 2, 4 and 8 mm, extending at 1 + 5 ε of that, by small steps."""
    x, total = record.steady.displacement_mm, np.zeros(len(record))
    for width in (2.0, 4.0, 8.0):
        z = 0.0
        for k, step in enumerate(np.diff(x), 1):
            z = min(max(z + step / width, -(1.0 + 5.0 * x[k] / record.specimen.initial_length_mm)), 1.0)
            total[k] -= 10.0 * z
    return total


def stiff_rubber(record):
    """Ogden's rubber of α = 7, 60 N at most, as the slope of its energy."""
    e, s = record.inputs.contraction, record.specimen

    def energy(e):
        return (1.0 - e) ** 7 + s.radius_ratio(e) ** 7 + ((1.0 - e) * s.radius_ratio(e)) ** -7.0

    pull = energy(e - 1e-5) - energy(e + 1e-5)
    return 60.0 * pull / np.abs(pull).max()


@pytest.mark.long
@pytest.mark.parametrize(
    ("added", "name", "values"),
    [
        (lonely_stroke, "first_cycle", {"F_1": 25.0}),
        (minor_loops, "nonlocal_hysteresis", {"r": 8.0, "q": 5.0, "W_2": 10.0}),
        (stiff_rubber, "ogden_bladder", {"alpha": 7.0}),
    ],
)
def test_what_was_added_by_hand_is_named_where_it_is_asked_for(tmp_path, added, name, values):
    write_case(tmp_path, make_record(Plan(71, LAW.law.name, protocol="minor_loops")))
    plain = read_record(tmp_path / "record.csv")
    found = diagnose(LAW, replace(plain, force=plain.force + added(plain)), also=(name,), detail=False)
    assert found.verdict == "missing_effect" and found.selected == (name,)
    assert found.best.rmse < 1.05 * found.noise_floor
    for key, value in values.items():
        assert found.best.values[f"{name}.{key}"] == pytest.approx(value, rel=0.1), key


@pytest.mark.long
def test_a_ladder_climbs_to_it(weighted):
    rungs = climb(LAW, thinned(weighted[0], 2000), also=("moving_mass",), detail=False).rungs
    assert rungs[-1].effects == ("moving_mass",)


@pytest.mark.long
def test_what_is_asked_for_leaves_another_answer_as_it_is():
    record = thinned(read_record(dataset_record("hidden_effect")), 1500)
    law = Model.build("exponential_law")
    plain, more = (diagnose(law, record, also=also, detail=False) for also in ((), ("moving_mass", "end_contact")))
    assert plain.labels == more.labels and plain.best.values == pytest.approx(more.best.values, rel=1e-6)


@pytest.mark.long
def test_only_may_name_it_a_form_too_and_a_wrong_name_is_refused(weighted):
    record = thinned(weighted[0], 1500)
    assert {c.effect for c in diagnose(LAW, record, only=("moving_mass",)).ranking} == {"moving_mass"}
    one = diagnose(LAW, record, only=("creep",), also=("end_contact:long",)).ranking
    assert {c.effect for c in one} == {"creep", "end_contact"}
    with pytest.raises(UsageError, match="moving_mas"):
        diagnose(LAW, record, also=("moving_mas",))


def test_the_sentence_takes_the_first_that_the_rest_follows_and_the_record_can_show(weighted):
    others = [e for e in catalogue().values() if not e.candidate]
    base = fit(LAW, thinned(weighted[0], 600))
    shares = [Follows("noise", 0.5, "noise"), Follows("map", 0.3, "the map"), Follows("cycle", 0.2, "the cycle")]
    said = could_be_tried(shares, others, base)
    assert said == (
        " Tried only if asked for, and following the map, too: contact or buckling near an end of the stroke "
        "(--also end_contact), bladder of Ogden's rubber (--also ogden_bladder)."
    )
    assert could_be_tried([Follows("temperature", 0.9, "the temperature")], others, base) == ""
    assert could_be_tried([Follows("map", 0.09, "the map")], others, base) == ""
    clock = [Follows("clock", 0.4, "the clock"), Follows("cycle", 0.2, "the cycle")]
    assert could_be_tried(clock, others, base).startswith(
        " Tried only if asked for, and following the cycle, too: loss of the first stroke ("
    )
    table = fit(Model.build("sarosi"), read_record(dataset_record("dmsp20_300")))
    assert could_be_tried([Follows("acceleration", 0.9, "the acceleration")], others, table) == ""
    held = fit(Model.build(LAW.law.name, ("end_contact",)), base.record)
    assert "end_contact" not in could_be_tried(shares, others, held)
