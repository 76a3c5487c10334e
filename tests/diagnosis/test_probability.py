"""Stated probabilities: weights of fitted sets summed by hand, and reliability of made-up statements."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pam_ident.diagnosis.probability import BESIDE, DOUBTFUL, LAPSE, LOCKED, MISSED, PAIR, TEMPER, THREE, probabilities
from pam_ident.validation.calibration import reliability


def selection(criteria, names=("a", "b", "c", "d"), locked=False, carried=False):
    return SimpleNamespace(
        cache={
            names: SimpleNamespace(names=frozenset(names), candidates=frozenset(names), criterion=criterion, terms=())
            for names, criterion in criteria.items()
        },
        candidates=[SimpleNamespace(name=name) for name in names],
        rivals=[],
        record=SimpleNamespace(inputs=SimpleNamespace(locked=locked), carried=carried),
    )


def test_weights_of_the_sets_that_hold_a_candidate_are_summed():
    step = 2.0 * TEMPER * math.log(2.0)  # halves a weight
    found = probabilities(selection({(): 100.0 + 2 * step, ("a",): 100.0, ("a", "b"): 100.0 + step}), ())
    expected = {"a": 1.5 / 1.75, "b": 0.5 / 1.75, "c": 0.0, "d": 0.0}
    assert found == pytest.approx({k: (1 - LAPSE) * v + MISSED * (1 - v) for k, v in expected.items()})


def test_members_of_a_group_share_their_probability():
    sets = {("a",): 10.0, ("b",): 10.0, ("c",): 10.0, ("a", "d"): 10.0}
    found = probabilities(selection(sets), [("a", "b")])
    assert found["a"] == found["b"] == pytest.approx((1 - LAPSE) * 0.75 + MISSED * 0.25)
    assert found["c"] == found["d"] == pytest.approx((1 - LAPSE) * 0.25 + MISSED * 0.75)


def test_a_name_that_the_answer_has_not_is_not_stated_beside_it():
    sets = selection({("a", "b"): 0.0, ("a", "c"): 10.0, ("a",): 100.0, ("d",): 200.0})
    assert min(probabilities(sets, ())[name] for name in "ab") > 0.6
    found = probabilities(sets, (), {"a"})
    assert found["a"] == pytest.approx(1.0 - LAPSE, abs=1e-4) and max(found[name] for name in "bcd") < 0.01
    assert probabilities(sets, [("b", "c")], {"a", "b"})["c"] == pytest.approx(1.0 - PAIR, abs=1e-4)


def test_nothing_is_ever_certain_nor_ruled_out():
    found = probabilities(selection({(): 5000.0, ("a",): 0.0}), ())
    assert 0.98 < found["a"] < 1.0 and 0.0 < found["b"] < 0.01


def test_the_more_names_and_what_is_unknown_beside_them_the_less_sure_they_are():
    sets = selection({("a", "b", "c"): 0.0})
    kinds = (("a", LAPSE, LAPSE), ("ab", LAPSE, PAIR), ("abc", LAPSE, THREE), ("ab", DOUBTFUL, DOUBTFUL))
    for answer, lapse, misled in kinds:
        found = probabilities(sets, [("a", "b", "c")], set(answer), lapse)
        assert found["a"] == pytest.approx(1.0 - misled)
    assert LAPSE < PAIR < LOCKED < DOUBTFUL < THREE < BESIDE


def test_no_name_is_near_certain_in_a_locked_muscle():
    """Of whose braid nobody measures how far it slides."""
    found = probabilities(selection({(): 5000.0, ("a",): 0.0}, locked=True), ())
    assert found["a"] == pytest.approx(1.0 - LOCKED) and found["a"] < 0.92


def test_reliability_counts_means_and_brier_by_hand():
    found = reliability([0.0, 0.005, 0.2, 0.995, 1.0, 0.95], [False, True, False, True, True, False])
    assert [(b.low, b.high, b.n, b.true) for b in found.bins] == [
        (0.0, 0.01, 2, 1),
        (0.1, 0.3, 1, 0),
        (0.9, 0.99, 1, 0),
        (0.99, 1.0, 2, 2),
    ]
    assert found.bins[0].stated == pytest.approx(0.0025)
    assert found.brier == pytest.approx((0.995**2 + 0.2**2 + 0.005**2 + 0.95**2) / 6)
    assert found.n == 6
    assert math.isnan(reliability([], []).brier)


def test_honest_statements_lie_on_the_diagonal():
    rng = np.random.default_rng(4)
    p = rng.uniform(size=20_000)
    found = reliability(p, rng.uniform(size=len(p)) < p)
    for one in found.bins:
        assert one.true / one.n == pytest.approx(one.stated, abs=4.0 * math.sqrt(0.25 / one.n))
    assert found.brier == pytest.approx(1 / 6, abs=0.005)  # ∫ p (1 − p) dp
