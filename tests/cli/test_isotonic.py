"""Weights that a muscle of the virtual rig lifts, from the shell: millimetres, one sentence, exit codes."""

import pandas as pd
import pytest

import pam_ident as pam
from pam_ident.rig import Plan, make_record, write_case
from pam_ident.tasks import law_choice
from pam_ident.tasks.gate import TooLittle

LAW = ("--law", "modified_chou_hannaford")


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    folder = tmp_path_factory.mktemp("weights")
    write_case(folder, make_record(Plan(4, "modified_chou_hannaford", protocol="weight_stairs")))
    return folder / "record.csv"


@pytest.mark.long
def test_a_length_is_fitted_compared_and_predicted(ask, weights, tmp_path):
    fitted = ask("fit", weights, *LAW, "--json", tmp_path / "fit.json")
    assert fitted.exit_code == 0 and "length: rmse 0.0" in fitted.stdout and "energy of a cycle" not in fitted.stdout
    compared = ask("compare", weights, *LAW)
    assert compared.exit_code == 0 and "by weight" in compared.stdout and "rms [mm]" in compared.stdout
    chosen = ask("fit", weights)
    assert chosen.exit_code == 0 and " mm on held-out data" in chosen.stdout
    judged = ask("validate", tmp_path / "fit.json", weights)
    assert judged.exit_code == 0 and "predicts the length of" in judged.stdout and "rmse [mm]" in judged.stdout


def test_one_weight_ends_with_3_and_what_to_do(ask, weights, tmp_path, monkeypatch):
    table = pd.read_csv(weights)
    heavy = table["force_N"] > 0.8 * table["force_N"].max()
    (tmp_path / "specimen.toml").write_text(weights.with_name("specimen.toml").read_text(), encoding="utf-8")
    table[heavy].to_csv(tmp_path / "one.csv", index=False)
    result = ask("fit", tmp_path / "one.csv", *LAW)
    assert result.exit_code == 3 and "does not determine k0, k2; hang other weights, or fit" in result.stderr
    assert "all samples carry one weight" in result.stdout
    monkeypatch.setattr(law_choice, "choose_law", None)
    for verb in ("diagnose", "ladder"):  # before any law is compared
        result = ask(verb, tmp_path / "one.csv")
        assert result.exit_code == 3 and "carry one weight" in result.stderr
        with pytest.raises(TooLittle):
            getattr(pam, verb)(tmp_path / "one.csv")


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (("fit", *LAW, "--method", "both"), 2, "the length answers"),
        (("fit", *LAW, "--figures", "figures"), 2, "--figures draws isobars"),
        (("compare", *LAW, "--out", "map.svg"), 2, "--out draws an error of the force"),
        (("fit", *LAW, "--effect", "creep"), 4, "creep remembers the way"),
    ],
)
def test_what_is_not_answered_is_one_sentence(ask, weights, tmp_path, monkeypatch, words, code, text):
    monkeypatch.chdir(tmp_path)
    verb, *more = words
    result = ask(verb, weights, *more)
    assert result.exit_code == code and text in result.stderr and len(result.stderr.strip().splitlines()) == 1
