"""An answer beside the free model: what no file foresaw is unknown, whatever else the catalogue could make of it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pam_ident.diagnosis import adequacy, diagnose
from pam_ident.diagnosis.answer import Selected, likelier_instead
from pam_ident.diagnosis.diagnose import _one_a_driver
from pam_ident.diagnosis.drivers import DRIVERS
from pam_ident.diagnosis.follows import Following
from pam_ident.diagnosis.probability import LITTLE, LITTLE_FREE, by_form_alone
from pam_ident.diagnosis.select import _special_cases
from pam_ident.diagnosis.selection import Selection, stands
from pam_ident.effects import catalogue
from pam_ident.fitting import fit
from pam_ident.model import Model, Term, as_term
from pam_ident.records import read_record
from pam_ident.records.datasets import dataset_record
from pam_ident.rig import Plan, Secret, make_record, write_case
from pam_ident.validation.holdout import effects_left_out, forms_left_out, related

LONG = pytest.mark.long
EXPONENTIAL, CHOU = "exponential_law", "modified_chou_hannaford"


@pytest.fixture(scope="module")
def hidden_effect():
    return read_record(dataset_record("hidden_effect"))


def case(folder, law, name, form, seed=7, ratio=3.0):
    hidden = make_record(Plan(seed, law, (Secret(name, form, ratio),), warming=True))
    write_case(folder, hidden)
    return hidden


@pytest.mark.parametrize(
    ("name", "form", "driver", "doubted"),
    [
        ("force_drift", "settling", "clock", ""),
        ("force_drift", "settling_on", "clock", "Noise that wanders as slowly as the test lasts"),
        ("presliding_hysteresis", "textbook", "way", "How far the braid slides while the pressure alone changes"),
    ],
)
def test_a_name_is_doubtful_that_noise_may_look_like_or_whose_way_nobody_measured(
    hidden_effect, name, form, driver, doubted
):
    record = replace(hidden_effect, said_kind="dynamic")
    term = as_term(f"{name}:{form}")
    selection = Selection(fit(Model.build(EXPONENTIAL), record), [term.effect])
    selection.following.likely = frozenset({driver})
    found = by_form_alone(selection, selection.refit([term]), [term], (), "", True)
    assert bool(found) == bool(doubted)
    for chance, why in found.values():
        assert chance == 0.85 and why.startswith(doubted)


def test_every_candidate_says_what_it_follows():
    words = {driver.what for driver in DRIVERS}
    for effect in catalogue().values():
        assert effect.follows and set(effect.follows) <= words, effect.name


def test_only_what_the_error_follows_is_supported(hidden_effect):
    following = Following.of(fit(Model.build(EXPONENTIAL), hidden_effect))
    assert "direction" in following.needed
    assert following.supports(catalogue()["pressure_friction"].follows)
    assert not following.supports(catalogue()["thermal_softening"].follows)
    assert not following.supports(catalogue()["stribeck_friction"].follows), "one whose first driver is not followed"
    assert following.supports(()), "an effect of the user's own may follow anything"


def test_a_name_is_by_its_form_alone_where_nothing_likely_follows_it_or_it_explains_little_beside_another(
    hidden_effect,
):
    names = ("pressure_friction", "series_compliance", "mullins_softening")
    pressed, soft, worn = (Term(catalogue()[name], catalogue()[name].forms[0]) for name in names)
    selection = Selection(fit(Model.build(EXPONENTIAL), hidden_effect), [t.effect for t in (pressed, soft, worn)])
    alone, both = selection.refit([pressed]), selection.refit([pressed, soft])
    assert by_form_alone(selection, alone, [pressed], (), "", True) == {}, "the error follows the direction"
    ((chance, why),) = by_form_alone(
        selection, selection.refit([worn]), [worn], (), "the direction of motion", True
    ).values()
    assert (chance, why) == (0.5, "The error rather follows the direction of motion; only its form speaks for it.")
    assert selection.part(both, pressed) > 0.9 and selection.part(both, soft) < 0.01
    little = by_form_alone(selection, both, [pressed, soft], (), "", True)
    said = "An unforeseen form of friction that grows with pressure could explain nearly all that it does."
    assert little == {"series_compliance": (0.85, said)}


def test_a_name_whose_driver_another_replaces_at_odds_as_good_rests_on_its_form(hidden_effect, monkeypatch):
    pressed = Term(catalogue()["pressure_friction"], catalogue()["pressure_friction"].forms[0])
    selection = Selection(fit(Model.build(EXPONENTIAL), hidden_effect), [pressed.effect, catalogue()["creep"]])
    fitted, first = selection.refit([pressed]), pressed.effect.follows[0]

    def instead(loss, *others):
        monkeypatch.setitem(selection.following.__dict__, "_instead", {first: (loss, frozenset(others))})
        return by_form_alone(selection, fitted, [pressed], classes, "", True)

    classes = ()
    why = "The error could as well follow rest and relaxation; its form alone tells."
    assert instead(3.0, "rest") == {"pressure_friction": (0.85, why)}
    assert instead(30.0, "rest") == {}, "the other explains less"
    classes = (("pressure_friction", "creep"),)
    assert instead(3.0, "rest") == {}, "the group says so"
    monkeypatch.setitem(selection.following.__dict__, "_instead", {"map": (3.0, frozenset({"cycle"}))})
    assert selection.following.as_good("map") == frozenset(), "what has no history is simpler"


def test_a_small_name_in_its_free_form_is_no_sure_one(hidden_effect):
    pressed, drift = (catalogue()[name] for name in ("pressure_friction", "force_drift"))
    large, free = Term(pressed, pressed.forms[0]), Term(drift, next(form for form in drift.forms if form.free))
    selection = Selection(fit(Model.build(EXPONENTIAL), hidden_effect), [pressed, drift])
    both = selection.refit([large, free])
    assert LITTLE < 0.1 < LITTLE_FREE
    selection.part = lambda fitted, term: 0.1 if term is free else 0.9
    said = "An unforeseen form of friction that grows with pressure could explain nearly all that it does."
    assert by_form_alone(selection, both, [large, free], (), "", True) == {"force_drift": (0.5, said)}


def test_a_name_in_its_free_form_is_less_sure_where_nothing_is_left(hidden_effect):
    pressed = catalogue()["pressure_friction"]
    written, free = pressed.forms[0], next(form for form in pressed.forms if form.free)
    selection = Selection(fit(Model.build(EXPONENTIAL), hidden_effect), [pressed])

    def doubts(form, complete):
        term = Term(pressed, form)
        return by_form_alone(selection, selection.refit([term]), [term], (), "", complete)

    why = "No written form of it fits, and its free form could follow much else."
    assert doubts(free, True) == {"pressure_friction": (0.85, why)}
    assert doubts(free, False) == doubts(written, True) == {}


@pytest.mark.parametrize(("way_mm", "still"), [(60.0, False), (1e4, True)])
def test_a_softening_that_does_not_fade_is_a_static_force_and_no_softening(hidden_effect, way_mm, still):
    values = {"mullins_softening.s_0": way_mm, "mullins_softening.q": 5.0}
    for form in ("free_travelled", "travelled"):
        assert stands(as_term(f"mullins_softening:{form}"), hidden_effect.inputs, values) == still


def test_a_driver_beside_others_at_odds_as_good_is_one_of_them(tmp_path):
    """Once the speed alone was seen here, because its surfaces come near to what the direction does."""
    secrets = (Secret("viscous_damping", "textbook", 1.446), Secret("coulomb_friction", "textbook", 0.8204))
    plan = Plan(220100051, EXPONENTIAL, secrets, protocol="low_stroke", gauges="noisy_length", sigma_N=1.0, tier=2)
    write_case(tmp_path, make_record(plan))
    following = Following.of(fit(Model.build(EXPONENTIAL), read_record(tmp_path / "record.csv")))
    assert {"speed", "direction"} <= following.drivers


def test_a_driver_that_no_effect_follows_is_uncovered(hidden_effect):
    following = Following.of(fit(Model.build(EXPONENTIAL), hidden_effect))
    known = list(catalogue().values())
    assert following.uncovered(known) == ()
    left = [effect for effect in known if "direction" not in effect.follows]
    assert following.uncovered(left) == ("direction",)
    assert following.uncovered(left, ["map", "direction"]) == ("direction",), "of those that are asked for"
    assert following.uncovered([*left, replace(left[0], follows=())]) == ()


@LONG
@pytest.mark.parametrize(
    ("law", "name", "form"),
    [
        (EXPONENTIAL, "viscous_damping", "thinning"),
        (CHOU, "creep", "by_force"),
        (CHOU, "series_compliance", "textbook"),
        (EXPONENTIAL, "mullins_softening", "textbook"),
        (CHOU, "thermal_softening", "elastic_part"),
        (EXPONENTIAL, "force_drift", "settling"),
    ],
)
def test_an_effect_that_the_catalogue_lacks_is_unknown_and_stands_alone(tmp_path, law, name, form):
    hidden = case(tmp_path, law, name, form)
    record = read_record(tmp_path / "record.csv")
    answer = diagnose(Model.build(law), record, without=effects_left_out(tmp_path, hidden))
    assert answer.verdict == "unknown_effect" and answer.selected == ()
    assert all(one.probability < 0.1 for one in answer.ranking)
    known = diagnose(Model.build(law), record)
    assert known.verdict == "missing_effect" and known.selected == (name,)


@LONG
@pytest.mark.parametrize(
    ("name", "form"),
    [
        ("viscous_damping", "thinning"),
        ("threshold_pressure", "textbook"),
        ("bladder_elasticity", "mooney_rivlin"),
        ("series_compliance", "textbook"),
        ("thermal_softening", "elastic_part"),
    ],
)
def test_a_form_that_the_catalogue_lacks_does_not_change_the_name(tmp_path, name, form):
    hidden = case(tmp_path, CHOU, name, form)
    left = forms_left_out(tmp_path, hidden)
    assert left and not any(label.endswith("free") for label in left)
    answer = diagnose(Model.build(CHOU), read_record(tmp_path / "record.csv"), without=left)
    assert answer.selected == (name,) and answer.labels[0] not in left


@LONG
def test_two_static_names_are_never_sure(tmp_path):
    """A fixture that yields as a contact does is threads that stretch and ends that taper, where it is left out."""
    secret = Secret("series_compliance", "contact", 4.643)
    write_case(tmp_path, make_record(Plan(6140200079, CHOU, (secret,), protocol="four_pressures", sigma_N=1.0, tier=2)))
    record, pair = read_record(tmp_path / "record.csv"), ("braid_extensibility", "end_taper")
    answer = diagnose(Model.build(CHOU), record, only=pair)
    assert set(answer.selected) == set(pair) and all(one.probability < 0.5 for one in answer.ranking)
    assert "With tapered ends it could follow nearly any static error." in answer.sentence
    alone = diagnose(Model.build(CHOU), record, only=("series_compliance", "end_taper"))
    assert alone.selected == ("series_compliance",)


@LONG
def test_without_and_only_take_a_form(hidden_effect):
    law = Model.build(EXPONENTIAL)
    label = "pressure_friction:contact_area"
    assert diagnose(law, hidden_effect, only=(label,)).labels == (label,)
    other = diagnose(law, hidden_effect, without=(label,))
    assert other.selected == ("pressure_friction",) and other.labels != (label,)


def test_kin_are_those_of_a_family_and_those_that_follow_the_same_but_the_map():
    assert related("viscous_damping") == ("pressure_lag", "stribeck_friction", "viscous_damping")
    assert related("threshold_pressure") == ("threshold_pressure",)


def test_what_nobody_tried_competes_with_a_name_by_its_driver(tmp_path):
    """The temperature rises as time goes, so that a drift which is left out is nearly a softening by warmth."""
    case(tmp_path, CHOU, "force_drift", "settling")
    following = Following.of(fit(Model.build(CHOU), read_record(tmp_path / "record.csv")))
    known = catalogue()
    softening = known["thermal_softening"]
    assert following.unknown_instead(softening, known.values()) == 0.0
    assert following.unknown_instead(softening, [e for e in known.values() if "clock" not in e.follows]) > 0.05


@LONG
def test_lag_through_an_orifice_is_one_effect(tmp_path):
    """Once damping stood beside it, which follows the speed as well."""
    plan = Plan(910100027, CHOU, (Secret("pressure_lag", "orifice", 2.8),), protocol="sines")
    write_case(tmp_path, make_record(plan))
    assert diagnose(Model.build(CHOU), read_record(tmp_path / "record.csv")).selected == ("pressure_lag",)


@LONG
def test_no_free_form_stands_beside_a_pattern(tmp_path):
    write_case(tmp_path, make_record(Plan(18, CHOU, unknown=Secret("screw_ripple", "harmonics", 3.2))))
    answer = diagnose(Model.build(CHOU), read_record(tmp_path / "record.csv"))
    assert answer.pattern.kind == "periodic" and answer.selected == ()


@LONG
@pytest.mark.parametrize("form", ["moving_mass", "stick_slip"])
def test_what_is_the_rigs_own_is_unknown(tmp_path, form):
    """A driver that the catalogue lacks, and teeth that only repeats of a stroke show."""
    write_case(tmp_path, make_record(Plan(15, EXPONENTIAL, unknown=Secret("dynamics", form, 3.0), sigma_N=1.0)))
    assert diagnose(Model.build(EXPONENTIAL), read_record(tmp_path / "record.csv")).verdict == "unknown_effect"


@LONG
@pytest.mark.parametrize("fault", ["spikes", "clipped", "empty_cells"])
def test_what_a_logger_spoils_changes_no_name(tmp_path, fault):
    secret = Secret("creep", "textbook", 2.0)
    write_case(tmp_path, make_record(Plan(16, EXPONENTIAL, (secret,), fault=fault)))
    record = read_record(tmp_path / "record.csv")
    assert diagnose(Model.build(EXPONENTIAL), record).selected == ("creep",)
    assert any(note.rows for note in record.notes)


def test_noise_of_the_length_sensor_is_followed_by_nothing(tmp_path):
    """Where the law is steep it is far above the load cell's; in a hold all rows share what is left of it."""
    write_case(tmp_path, make_record(Plan(17, EXPONENTIAL, sigma_N=1.0, gauges="noisy_length")))
    found = fit(Model.build(EXPONENTIAL), read_record(tmp_path / "record.csv"))
    assert Following.of(found).chosen == set()


@LONG
@pytest.mark.parametrize("seed", [1, 3])
def test_sticking_and_letting_go_is_more_than_dry_friction(seed, tmp_path):
    """No repeats: the pressure is switched within each stroke. Both were Coulomb friction alone, or refused."""
    plan = Plan(seed, CHOU, unknown=Secret("dynamics", "stick_slip", 3.0), protocol="switched", sigma_N=1.0)
    write_case(tmp_path, make_record(plan))
    found = diagnose(Model.build(CHOU), read_record(tmp_path / "record.csv"))
    assert found.verdict == "unknown_effect"
    assert (found.pattern.kind, found.pattern.coordinate) == ("periodic", "the way since a reversal")


@LONG
@pytest.mark.parametrize(("seed", "noise", "what"), [(2, "slow", "the clock"), (1, "white", "")])
def test_what_is_taken_for_slow_noise_is_said_to_be_that(tmp_path, seed, noise, what):
    """Else nothing is missing, and yet a fifth of the error follows the clock."""
    write_case(tmp_path, make_record(Plan(seed, EXPONENTIAL, noise=noise)))
    found = diagnose(Model.build(EXPONENTIAL), read_record(tmp_path / "record.csv"))
    assert found.verdict == "adequate"
    told = f"% of the squared error follows {what}. Slow noise would, too" in found.sentence
    assert told if what else "follows" not in found.sentence


def test_what_was_not_tried_is_asked_where_it_explains_more_than_what_was(hidden_effect):
    names = ("viscous_damping", "mullins_softening", "pressure_friction")
    damped, worn, pressed = (catalogue()[name] for name in names)
    selection = Selection(fit(Model.build(EXPONENTIAL), hidden_effect), [damped, worn, pressed], tried=names[:2])
    fitted = selection.refit([Term(damped, damped.forms[0])])
    before = dict(selection.cache)
    assert likelier_instead(Selected(selection, fitted, None), [worn, pressed]) == ["pressure_friction"]
    assert selection.cache == before, "it counts for no odds"
    best = selection.refit([Term(pressed, form) for form in pressed.forms if form.name == "contact_area"])
    assert likelier_instead(Selected(selection, best, None), [worn, damped]) == []


def answered(folder, plan):
    write_case(folder, make_record(plan))
    return diagnose(Model.build(plan.law), read_record(folder / "record.csv"), detail=False)


@LONG
def test_two_names_in_free_forms_of_one_driver_are_no_answer(tmp_path):
    """A drag with the square of the speed, alike both ways: it was damping and a lag, with 0.985 each."""
    drag = Secret("dynamics", "windage", 2.9)
    found = answered(tmp_path, Plan(6145000071, EXPONENTIAL, unknown=drag, protocol="fast_first", sigma_N=4.0, tier=2))
    assert found.verdict == "unknown_effect" and not found.selected
    assert found.pattern and "follows the speed" in found.pattern.text


@LONG
def test_a_special_case_that_was_not_tried_is_not_told_apart(tmp_path):
    secrets = (Secret("stribeck_friction", "textbook", 1.0222521531470088),)
    plan = Plan(6147000075, "modified_chou_hannaford", secrets, protocol="crossed_sines", noise="ar1",
                gauges="noisy_length", tier=3)  # fmt: skip
    assert {"coulomb_friction", "stribeck_friction"} in map(set, answered(tmp_path, plan).groups)


@LONG
def test_a_damping_that_grows_with_pressure_is_no_lag(tmp_path):
    secrets = (Secret("viscous_damping", "pressure", 2.9930729731749697),)
    plan = Plan(6147000058, EXPONENTIAL, secrets, protocol="sines", sigma_N=4.0, fault="lost_rows", tier=2)
    assert answered(tmp_path, plan).selected == ("viscous_damping",)


@LONG
def test_a_level_of_a_hold_that_is_a_little_off_is_no_jump(tmp_path):
    """Noise of the position makes six times as much of the force as the load cell's."""
    plan = Plan(1, EXPONENTIAL, protocol="one_cycle", sigma_N=0.25, gauges="noisy_length")
    assert answered(tmp_path, plan).verdict == "adequate"


@LONG
@pytest.mark.parametrize(("step", "noise"), [(4.0, 0.4), (9.0, 0.8)])
def test_what_rounds_is_no_unknown_effect(step, noise):
    """Rounding comes back with every stroke where the noise is far below a step: it was a force in one place."""
    record = read_record(dataset_record("nothing_hidden"))
    law = fit(Model.build("exponential_law"), record)
    calm = law.force + noise * np.random.default_rng(7).standard_normal(len(record))
    read = replace(record, force=step * np.round(calm / step))
    answer = diagnose(Model.build("exponential_law"), read, detail=False)
    assert answer.verdict == "adequate" and f"read in steps of {step:.2f} N" in answer.sentence
    twice = diagnose(Model.build("exponential_law"), replace(read, force=read.force + 0.1 * calm), detail=False)
    assert "rounding" not in twice.sentence


def test_a_special_case_starts_where_the_richer_form_stands(hidden_effect):
    """Friction without growth is Coulomb's, with the travel in which the contact bends that was found for the other."""
    bending = as_term("pressure_friction:bending")
    selection = Selection(fit(Model.build(EXPONENTIAL), hidden_effect), list(catalogue().values()))
    fitted = selection.refit([bending])
    found = {one.labels: one for one in _special_cases(selection, fitted)}
    assert frozenset({"coulomb_friction:stuck"}) in found
    assert frozenset({"presliding_hysteresis:dahl"}) not in found, "it follows the way first"
    assert all(len(term.form.params) < len(bending.form.params) for one in found.values() for term in one.terms)


def test_what_lags_a_driven_pressure_may_relax_in_a_locked_muscle():
    lag, creep, damping = (_one_a_driver(catalogue()[n]) for n in ("pressure_lag", "creep", "viscous_damping"))
    assert "rest" in lag.follows and lag.follows[0] == "speed" == lag.alike == damping.alike
    assert "rest" not in damping.follows and creep.alike == "rest"
    inputs = SimpleNamespace(time=np.arange(3.0))
    relaxing = SimpleNamespace(drivers={"way", "rest"}, possible={"way", "rest"}, record=SimpleNamespace(inputs=inputs))
    seen = [
        e.name for e in (lag, creep, damping, catalogue()["pressure_lag"]) if Following.supports(relaxing, e.follows)
    ]
    assert seen == ["pressure_lag", "creep"], "in another muscle a lag follows the rate"


def test_names_likelier_than_the_free_model_that_leave_no_more_have_nothing_unknown_in_their_place(
    hidden_effect, monkeypatch
):
    """Surfaces over several drivers that no effect follows had outweighed a damping that explained as much."""
    monkeypatch.setattr(Following, "unknown_instead", lambda *_: 1.0)
    found = diagnose(Model.build("exponential_law"), hidden_effect, detail=False)
    assert found.verdict == "missing_effect" and found.selected == ("pressure_friction",)
    monkeypatch.setattr(adequacy, "outdoes_free", lambda *_: False)
    assert not diagnose(Model.build("exponential_law"), hidden_effect, detail=False).selected
