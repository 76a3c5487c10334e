"""Models as equations: every law and form, in text and in a LaTeX that is parsed."""

import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.mathtext import MathTextParser

from pam_ident.core.formula import to_latex
from pam_ident.effects import catalogue as effects
from pam_ident.export.equation import equation, latex, latex_lines, symbol
from pam_ident.fitting import fit
from pam_ident.laws import catalogue as laws
from pam_ident.model import Model
from pam_ident.records import Specimen, build_record

MODELS = [Model.build(name) for name in laws()]
MODELS += [Model.build("sarosi", (f"{e.name}:{f.name}",)) for e in effects().values() for f in e.forms]
FIRST = [e.forms[0] for e in effects().values()]
EACH_MODEL = pytest.mark.parametrize(
    "model",
    [
        pytest.param(
            m,
            id=m.labels[0] if m.terms else m.law.name,
            marks=() if not m.terms or m.terms[0].form in FIRST else pytest.mark.long,
        )
        for m in MODELS
    ],
)


def parses(line: str) -> None:
    assert MathTextParser("path").parse(f"${line}$").width > 0.0


@EACH_MODEL
def test_every_law_and_form_is_latex_with_all_its_symbols(model):
    lines = latex_lines(model)
    for line in lines:
        parses(line)
        assert line.isascii() or "\\text" in line
    parameters = lines[-len(model.params) :] if model.params else []
    for p, line in zip(model.params, parameters, strict=True):
        assert line.startswith(symbol(p))
    whole = latex(model)
    assert whole.count("{") == whole.count("}") and whole.count("\\begin") == whole.count("\\end") == 1


@EACH_MODEL
def test_a_model_prints_as_its_equation(model):
    text = str(model)
    assert text == equation(model) and model.law.formula in text
    assert all(f"+ {term.label}: {term.form.formula}" in text for term in model.terms)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a0 + a1 p", "a_{0} + a_{1} p"),
        ("exp(−μ ε)", r"\exp (-\mu \varepsilon )"),
        ("a = 3/tan²θ0,  b", r"a = 3/\tan ^{2}\theta_{0},\quad b"),
        ("ε^(2/3)", r"\varepsilon ^{2/3}"),
        ("2√(3a)/3", r"2\sqrt{3a}/3"),
        ("−F_hold sgn(ε̇)", r"-F_{\mathrm{hold}} \operatorname{sgn}(\dot{\varepsilon})"),
        ("|ẋ|^n", r"|\dot{x}|^{n}"),
        ("dz/dx, dI1/dε", r"dz/dx, dI_{1}/d\varepsilon"),
        ("−K ε in holds", r"-K \varepsilon \text{ in holds}"),
        ("EA + C10", "EA + C_{10}"),
        ("tau_h, mu, wall_share", r"\tau_{h}, \mu , \mathrm{wall\ share}"),
        ("Ḟ → Σ q_i/9 ± 1", r"\dot{F} \to \sum q_{i}/9 \pm 1"),
    ],
)
def test_what_a_formula_becomes(text, expected):
    assert to_latex(text) == expected
    parses(to_latex(text))


@pytest.mark.parametrize("text", [r"\href{javascript:x}{y}", "$$<b>", "a_{b}", "100 % # & ~", "}{", r"\input{x}"])
def test_no_sign_of_a_users_formula_has_a_meaning_in_latex(text):
    found = to_latex(text)
    bare = re.sub(r"\\[%#&$_{}]|\\(text|mathrm)\{[^{}]*\}|\\(backslash|sim)|[_^]\{[^{}]*\}", "", found)
    assert not re.search(r"[%#&$_{}\\]", bare)


def test_a_fit_shows_its_numbers():
    """A polynomial law made by itself: the numbers in the equation are those it was made with."""
    rng = np.random.default_rng(3)
    p, e = rng.uniform(0.1, 0.6, 400), rng.uniform(0.0, 0.3, 400)
    force = p * (1500.0 - 6000.0 * e) - 20.0 + 250.0 * e + rng.normal(0.0, 1e-3, 400)
    one = fit(Model.build("polynomial"), build_record("m", Specimen(), p, e, force))
    text = equation(one)
    value = float(re.search(r"\n  a1 = (\S+) ± \S+ N/MPa", text)[1])
    assert value == pytest.approx(-6000.0, rel=1e-5)
    for number, error in re.findall(r" = (\S+) ± (\S+)", text):
        assert len(number.partition(".")[2]) == len(error.partition(".")[2]), "digits are those of the standard error"
    lines = latex_lines(one)
    for line in lines:
        parses(line)
    assert any(
        re.match(r"b_\{1\} = (249|250)\S* \\pm \S+( \\cdot 10\^\{-\d+\})?\\ \\text\{N\}", line) for line in lines
    )


def test_a_small_number_is_a_power_of_ten():
    model = Model.build("wickramatunge_leephakpreeda")
    rng = np.random.default_rng(3)
    p, e = rng.uniform(0.1, 0.6, 400), rng.uniform(0.0, 0.3, 400)
    values = {"c0": 1.0, "c1": 2.5e-6, "c2": 0.1, "c3": 5.0, "e_free": 0.35}
    record = build_record("m", Specimen(), p, e, p * 0.0)
    made = replace(record, force=model.force(record.inputs, values) + rng.normal(0.0, 1e-6, 400))
    line = next(line for line in latex_lines(fit(model, made)) if line.startswith("c_{1} = "))
    assert float(re.match(r"c_\{1\} = (\S+) \\cdot 10\^\{-6\} ", line)[1]) == pytest.approx(2.5, rel=1e-3)
