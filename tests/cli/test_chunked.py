"""`fit --chunked`: the same answer as from memory, or a word on why not; by itself where memory is short."""

import numpy as np
import pytest


@pytest.mark.parametrize("branch", ["together", "separate", "contraction"])
def test_the_answer_is_that_of_the_record_in_memory(answer, rubbing, branch):
    words = ("fit", rubbing, "--law", "exponential_law", "--branch", branch)
    one, other = (answer(*words, *more) for more in (("--chunked",), ()))
    assert one[0].exit_code == other[0].exit_code == 0
    assert "read in chunks" in one[0].stdout and "read in chunks" not in other[0].stdout
    assert set(one[1]) == set(other[1]) and list(one[1]["branches"]) == list(other[1]["branches"])
    for name, mine in one[1]["branches"].items():
        whole = other[1]["branches"][name]
        assert set(mine) == set(whole)
        assert mine["repeats_N"] is None and mine["lack_of_fit"] is None
        for key, rel in (("rmse_N", 1e-9), ("max_error_N", 1e-6), ("r2", 1e-9), ("n", 0.0)):
            assert mine[key] == pytest.approx(whole[key], rel=rel)
        assert mine["stand_ins"] == whole["stand_ins"]
        np.testing.assert_allclose(mine["covariance"]["matrix"], whole["covariance"]["matrix"], rtol=1e-5)
        for key, found in mine["parameters"].items():
            # Both stop within a millionth of a standard error of the minimum.
            near = {"rel": 1e-9, "abs": 1e-6 * (whole["parameters"][key]["stderr"] or 0.0)}
            assert found["value"] == pytest.approx(whole["parameters"][key]["value"], **near)
    assert one[1]["passive"] == other[1]["passive"]
    for mine, whole in zip(one[1]["loops"], other[1]["loops"], strict=True):
        assert mine == {key: v if v is None else pytest.approx(v, rel=1e-6) for key, v in whole.items()}


@pytest.mark.parametrize(
    ("more", "word"),
    [
        (("--method", "two-stage"), "--method two-stage"),
        (("--weights", "sensors"), "--weights sensors"),
        (("--loss", "huber"), "--loss huber"),
        (("--intervals", "bootstrap"), "--intervals bootstrap"),
        (("--effect", "creep"), "creep remembers"),
    ],
)
def test_what_needs_the_whole_record_is_refused(ask, clean, tmp_path, more, word):
    target = tmp_path / "answer.json"
    result = ask("fit", clean, "--law", "exponential_law", "--chunked", "--json", target, *more)
    assert result.exit_code == 2 and word in result.stderr and "read in chunks" in result.stderr
    assert len(result.stderr.splitlines()) <= 2 and not target.exists()


def test_a_record_too_large_for_memory_is_read_in_chunks_by_fit_alone(ask, clean, monkeypatch):
    monkeypatch.setattr("pam_ident.records.files.free_memory", lambda: clean.stat().st_size)
    words = (clean, "--law", "modified_chou_hannaford")
    assert "read in chunks" in ask("fit", *words).stdout
    refused = ask("diagnose", *words)
    assert refused.exit_code == 2 and "only `fit` reads a record in chunks" in refused.stderr


@pytest.mark.long
def test_figures_are_drawn_from_the_sample(ask, clean, tmp_path):
    result = ask("fit", clean, "--law", "exponential_law", "--chunked", "--figures", tmp_path / "figures")
    assert result.exit_code == 0 and list((tmp_path / "figures").glob("*.svg"))
