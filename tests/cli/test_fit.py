"""`fit` finds what is there, says in words what is not determined, and answers by the contract."""

import json

import numpy as np
import pytest

PAPER = {
    "contraction": {"a0": -197.8, "a1": 2442.0, "b0": 1735.0, "b1": 5464.0, "c0": -9.3, "c1": 688.3, "mu": 45.0},
    "extension": {"a0": -344.5, "a1": 2554.0, "b0": -43.2, "b1": 8430.0, "c0": 43.24, "c1": 899.2, "mu": 45.0},
}
KEYS = {
    "schema", "record", "law", "effects", "specimen", "free_geometry", "range", "branches", "loops", "passive",
    "warnings",
}  # fmt: skip


@pytest.fixture
def paper(root):
    return root / "datasets" / "paper_laws" / "reconstructed.csv"


@pytest.mark.parametrize("method", ["global", "two-stage"])
def test_the_papers_laws_come_back_to_six_digits_with_a_warning_of_the_loop(answer, paper, method):
    result, found = answer("fit", paper, "--law", "exponential_law", "--branch", "separate", "--method", method)
    assert result.exit_code == 0
    for branch, truth in PAPER.items():
        for name, value in truth.items():
            assert found["branches"][branch]["parameters"][name]["value"] == pytest.approx(value, rel=1e-6), name
    assert found["passive"] is False
    assert "gives energy back at 0.1, 0.2, 0.3, 0.4, 0.5 MPa" in result.stdout
    assert "Warning" in result.stdout and "-197.8" in result.stdout


def test_json_of_a_fit_is_the_contracts(answer, clean):
    result, found = answer("fit", clean, "--law", "exponential_law", "--effect", "coulomb_friction")
    assert result.exit_code == 0
    assert set(found) == KEYS and found["schema"] == "pam-ident/fit/1"
    assert found["record"] == str(clean) and found["law"] == "exponential_law"
    assert found["effects"] == ["coulomb_friction"] and list(found["branches"]) == ["together"]
    assert found["free_geometry"] is False and found["specimen"] == {
        "name": "made",
        "initial_length_mm": 200.0,
        "initial_radius_mm": 10.0,
        "braid_angle_deg": 25.4,
        "wall_thickness_mm": 1.5,
    }
    branch = found["branches"]["together"]
    contract = {"parameters", "rmse_N", "max_error_N", "r2", "n"}
    more = {"repeats_N", "repeats_memory_samples", "lack_of_fit", "stand_ins", "covariance", "reading"}
    more |= {"simpler", "shares_N"}
    assert set(branch) == contract | more
    names, matrix = branch["covariance"]["names"], np.array(branch["covariance"]["matrix"])
    errors = [branch["parameters"][name]["stderr"] for name in names]
    assert np.sqrt(np.diag(matrix)) == pytest.approx(errors, rel=1e-6)
    for one in branch["parameters"].values():
        contract = {"value", "stderr", "unit", "at_bound", "identified"}
        assert set(one) == contract | {"interval", "freedom", "verdict", "partners", "possible"}
        assert one["verdict"] == ("at_bound" if one["at_bound"] else "pinned")
        assert one["at_bound"] or one["interval"][0] < one["value"] < one["interval"][1]
        assert (one["stderr"] is None) == one["at_bound"]
    assert branch["n"] == 1200 and 0.9 < branch["rmse_N"] < 1.1


def test_true_parameters_lie_within_four_standard_errors(answer, clean, truth):
    _, found = answer("fit", clean, "--law", "exponential_law")
    for name, value in truth.items():
        one = found["branches"]["together"]["parameters"][name]
        assert abs(one["value"] - value) < 4 * one["stderr"], name


def test_the_record_is_named_as_it_was_given(answer, clean, monkeypatch):
    monkeypatch.chdir(clean.parent)
    _, found = answer("fit", "./record.csv", "--law", "sarosi")
    assert found["record"] == "./record.csv"


@pytest.mark.parametrize(
    ("branch", "names", "passive"),
    [
        ("separate", ["contraction", "extension"], True),
        ("contraction", ["contraction"], None),
        ("extension", ["extension"], None),
        ("together", ["together"], True),
    ],
)
def test_branches_and_whether_their_loop_is_passive(answer, rubbing, branch, names, passive):
    _, found = answer("fit", rubbing, "--law", "exponential_law", "--branch", branch)
    assert list(found["branches"]) == names and found["passive"] is passive


@pytest.mark.parametrize(
    ("law", "branch", "effect", "twice"),
    [
        ("modified_chou_hannaford", "separate", "coulomb_friction", True),
        ("modified_chou_hannaford", "together", "coulomb_friction", False),
        ("modified_chou_hannaford", "separate", "bladder_elasticity", False),
        ("chou_hannaford", "separate", "coulomb_friction", False),
    ],
)
def test_hysteresis_is_modelled_once(answer, rubbing, law, branch, effect, twice):
    _, found = answer("fit", rubbing, "--law", law, "--branch", branch, "--effect", effect)
    assert any("holds the hysteresis already" in one["text"] for one in found["warnings"]) is twice


def test_friction_of_the_wrong_sign_gives_energy_back(answer, write_record):
    backwards = write_record(friction=-12.0)
    result, found = answer("fit", backwards, "--law", "exponential_law", "--branch", "separate")
    assert found["passive"] is False and "gives energy back at 0.2, 0.3, 0.4 MPa" in result.stdout


def test_two_stage_prints_tables_by_isobar_and_correlations(answer, clean):
    result, found = answer("fit", clean, "--law", "exponential_law", "--branch", "separate", "--method", "two-stage")
    assert set(found) == KEYS | {"per_pressure", "correlation"}
    assert [(row["pressure_MPa"], row["branch"]) for row in found["per_pressure"]] == [
        (p, branch) for branch in ("contraction", "extension") for p in (0.2, 0.3, 0.4)
    ]
    for row in found["per_pressure"]:
        assert set(row["parameters"]) == {"a", "b", "c"}
        assert all(set(one) == {"value", "stderr"} for one in row["parameters"].values())
    assert set(found["correlation"]) == {"contraction", "extension"}
    assert found["correlation"]["contraction"]["a"] > 0.999
    assert "correlation with pressure: a 1.0000" in result.stdout
    for name, one in found["branches"]["contraction"]["parameters"].items():
        assert one["stderr"] is not None and one["stderr"] > 0, name


def test_two_stage_of_a_law_without_pairs_still_gives_its_isobars(answer, root):
    record = root / "datasets" / "dmsp20_300" / "record.csv"
    result, found = answer("fit", record, "--law", "modified_chou_hannaford", "--method", "two-stage")
    assert result.exit_code == 0 and found["passive"] is None and found["correlation"] == {}
    assert {row["branch"] for row in found["per_pressure"]} == {"together"}
    assert len(found["per_pressure"]) == 8 and "k1" in found["per_pressure"][0]["parameters"]


def test_what_is_not_identified_is_said_in_words_and_the_exit_code_is_3(answer, clean):
    result, found = answer("fit", clean, "--law", "exponential_law", "--effect", "force_bias")
    assert result.exit_code == 3
    loose = [name for name, one in found["branches"]["together"]["parameters"].items() if not one["identified"]]
    assert "a0" in loose and any(name.startswith("force_bias") for name in loose)
    for name in loose:
        assert found["branches"]["together"]["parameters"][name]["stderr"] is None
        line = next(text for text in result.stdout.splitlines() if text.strip().startswith(f"{name} "))
        assert "not identified" in line and "±" not in line
    assert "does not determine" in result.stderr and len(result.stderr.strip().splitlines()) <= 2


def test_a_parameter_at_its_bound_is_called_so(answer, write_record):
    result, found = answer(
        "fit", write_record(friction=-12.0), "--law", "exponential_law", "--effect", "coulomb_friction"
    )
    one = found["branches"]["together"]["parameters"]["coulomb_friction.F_c"]
    assert one["at_bound"] and one["value"] == 0
    line = next(text for text in result.stdout.splitlines() if "coulomb_friction.F_c" in text)
    assert "at bound" in line and "±" not in line


def test_free_geometry_is_fitted_and_counted(answer, root):
    record = root / "datasets" / "dmsp20_300" / "record.csv"
    _, fixed = answer("fit", record, "--law", "chou_hannaford")
    _, free = answer("fit", record, "--law", "chou_hannaford", "--free-geometry")
    assert fixed["branches"]["together"]["parameters"] == {}
    assert set(free["branches"]["together"]["parameters"]) == {"r0", "theta0"}
    assert free["branches"]["together"]["rmse_N"] < fixed["branches"]["together"]["rmse_N"]


def test_the_printed_bladder_force_brings_its_warning(ask, root):
    record = root / "datasets" / "dmsp20_300" / "record.csv"
    result = ask("fit", record, "--law", "chou_hannaford", "--effect", "bladder_elasticity_printed")
    assert "Warning: Elasticity of the bladder, as printed: " in result.stdout


def test_another_specimen_file_is_used(answer, clean, tmp_path):
    other = tmp_path / "other.toml"
    text = (clean.parent / "specimen.toml").read_text().replace("initial_radius_mm = 10.0", "initial_radius_mm = 20.0")
    other.write_text(text)
    _, thin = answer("fit", clean, "--law", "modified_chou_hannaford")
    _, thick = answer("fit", clean, "--law", "modified_chou_hannaford", "--specimen", other)
    k0 = [one["branches"]["together"]["parameters"]["k0"]["value"] for one in (thin, thick)]
    assert k0[1] == pytest.approx(k0[0] / 4, rel=1e-4)


def test_an_effect_of_the_users_own(answer, clean, tmp_path):
    own = tmp_path / "ripple.py"
    own.write_text(
        "import numpy as np\n"
        "from pam_ident.core import Param\n"
        "from pam_ident.effects import AddsForce, Effect\n"
        "SIZE = Param('A', 'N', 'amplitude', -100.0, 100.0)\n"
        "def ripple(inputs, shape, force):\n"
        "    return np.sin(2 * np.pi * inputs.displacement_mm / 5.0)[:, None]\n"
        "EFFECT = Effect(name='ripple', title='Ripple', source='here', test='look',\n"
        "                forms=(AddsForce('textbook', 'A sin(2π x/5)', (SIZE,), ripple),))\n"
    )
    words = ("--law", "exponential_law", "--effect-file", own, "--effect", "ripple")
    result, found = answer("fit", clean, *words)
    assert result.exit_code == 0 and found["effects"] == ["ripple"]
    assert abs(found["branches"]["together"]["parameters"]["ripple.A"]["value"]) < 0.3
    (tmp_path / "fit.json").write_text(json.dumps(found), encoding="utf-8")
    refused, _ = answer("validate", tmp_path / "fit.json", clean)
    assert refused.exit_code == 2 and "comes by --effect-file FILE.py" in refused.stderr


OWN_LAW = """from pam_ident.core import Param
from pam_ident.laws import Law


def columns(p, e, specimen, values):
    return p.__array_namespace__().stack([p, p * e, e]).T


LAW = Law("plane", "plane of mine", "F = p (f0 + f1 ε) + f2 ε", "mine",
          tuple(Param(f"f{k}", "N/MPa", "mine", scale=1000.0) for k in range(3)), columns=columns)
"""


def test_a_law_of_the_user_s_own_comes_by_its_file(ask, write_record, tmp_path):
    record, own = write_record(seed=5), tmp_path / "plane.py"
    own.write_text(OWN_LAW, encoding="utf-8")
    result = ask("fit", record, "--law", own, "--json", tmp_path / "own.json")
    assert result.exit_code == 0 and "plane: F = p (f0 + f1 ε) + f2 ε" in result.stdout
    assert ask("validate", tmp_path / "own.json", record).exit_code == 0
    found = ask("ladder", record, "--law", own, "--only", "bladder_elasticity", "--heldout", "refit")
    assert found.exit_code == 0 and "plane of mine" in found.stdout
    (tmp_path / "none.py").write_text("EFFECT = 1", encoding="utf-8")
    refused = ask("fit", record, "--law", tmp_path / "none.py")
    assert refused.exit_code == 2 and "defines no law; expected LAW = Law(...)" in refused.stderr


def test_several_records_are_fitted_together_with_what_they_share(ask, write_record, tmp_path):
    paths = [write_record(seed=seed, friction=friction) for seed, friction in ((5, 0.0), (6, 12.0))]
    words = ("--law", "exponential_law", "--effect", "coulomb_friction:held", "--shared", "mu", "--shared", "b1")
    result = ask("fit", *paths, *words, "--json", tmp_path / "both.json")
    assert result.exit_code == 0 and "shared by all 2 records" in result.stdout
    found = [json.loads(line) for line in (tmp_path / "both.json").read_text(encoding="utf-8").splitlines()]
    shared = {"parameters": ["b1", "mu"], "records": [str(path) for path in paths]}
    assert [set(one) for one in found] == [KEYS | {"shared"}] * 2 and all(one["shared"] == shared for one in found)
    mu, friction = (
        [one["branches"]["together"]["parameters"][name]["value"] for one in found]
        for name in ("mu", "coulomb_friction.F_c")
    )
    assert mu[0] == mu[1] and friction == pytest.approx([0.0, 12.0], abs=0.3)
    (tmp_path / "one.json").write_text(json.dumps(found[1]), encoding="utf-8")
    assert ask("validate", tmp_path / "one.json", paths[1]).exit_code == 0
    refused = ask("validate", tmp_path / "both.json", paths[1])
    assert refused.exit_code == 4 and "the fits of 2 records, a line each" in refused.stderr
    whole = ask("fit", *paths, "--law", "exponential_law", "--shared", "all", "--json", tmp_path / "all.json")
    assert "together, shared by all 2 records" in whole.stdout
    assert ask("validate", tmp_path / "all.json", paths[1]).exit_code == 0


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ((), "name it by --law"),
        (("--law", "sarosi", "--shared", "creep"), "--shared creep: no parameter of the model; it has s1"),
        (("--law", "sarosi", "--intervals", "profile"), "--intervals profile is for one record"),
        (("--law", "sarosi", "--figures", "x"), "--figures are for one record"),
    ],
)
def test_what_several_records_cannot_be_asked_is_refused(ask, clean, rubbing, more, words):
    result = ask("fit", clean, rubbing, *more)
    assert result.exit_code == 2 and words in result.stderr


def test_one_record_shares_with_none(ask, clean):
    result = ask("fit", clean, "--law", "sarosi", "--shared", "all")
    assert result.exit_code == 2 and "two or more" in result.stderr
