"""Formulas as laws and effects write them, in Unicode text, turned into LaTeX for MathJax or matplotlib.

They mix mathematics with words ("as dahl, with W + W_p p for W"), which SymPy does not read, and LaTeX declared beside
each of the hundred would be longer and could differ from the text; so their words and signs are told apart here.
"""

import re
import unicodedata

_SPELT = (
    "alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau phi chi psi omega "
    "Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega"
)
GREEK = dict(zip("αβγδεζηθκλμνξπρστφχψωΓΔΘΛΞΠΣΦΨΩ", _SPELT.split(), strict=True))
VARIANT = {"epsilon": r"\varepsilon", "phi": r"\varphi", "Sigma": r"\sum"}
FUNCTIONS = {"exp", "ln", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "max", "min"}
OPERATORS = {"sgn", "sign", "clip", "sat", "erf", "arcsin", "arccos", "arctan"}
SIGNS = {
    "−": "-",
    "·": r"\cdot ",
    "×": r"\times ",
    "±": r"\pm ",
    "→": r"\to ",
    "≤": r"\leq ",
    "≥": r"\geq ",
    "≠": r"\neq ",
    "≈": r"\approx ",
    "∞": r"\infty ",
    "√": r"\surd ",
    "∫": r"\int ",
    "∂": r"\partial ",
    "…": r"\ldots ",
    "\\": r"\backslash ",
    "~": r"\sim ",
    "^": r"\wedge ",
} | {sign: "\\" + sign for sign in "%#&$_{}"}
ACCENTS = {"\u0302": "hat", "\u0304": "bar", "\u0307": "dot", "\u0308": "ddot"}
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻ⁿ", "0123456789-n")
LOWERED = str.maketrans("₀₁₂₃₄₅₆₇₈₉", "0123456789")
_FUNCTION = "|".join(sorted(FUNCTIONS | OPERATORS, key=len, reverse=True))
_GREEK = "|".join(sorted(GREEK.values(), key=len, reverse=True))
_WORD = rf"(?!(?:{_FUNCTION}|{_GREEK})(?![A-Za-z]))(?!d[a-z](?![a-z]))(?![A-Z]+(?![A-Za-z]))[A-Za-z]{{2,}}(?:'s)?(?!\w)"
PART = re.compile(
    rf"(?P<prose>\s*{_WORD}(?:\s+{_WORD})*\s*)"
    rf"|(?P<function>(?:{_FUNCTION})(?![A-Za-z]))"
    r"|(?P<named>(?!(?:" + _GREEK + r")_)[A-Za-z]{2,}(?:_[A-Za-z0-9]+)+)"
    rf"|(?P<symbol>(?:{_GREEK})(?![A-Za-z])|[A-Za-zα-ωΑ-Ω])(?P<accent>[\u0300-\u036f]?)"
    r"(?P<index>[\d₀-₉]*)(?P<below>(?:_[A-Za-z0-9]+)*)"
    r"|√\((?P<root>[^()]*)\)"
    r"|\^(?:\((?P<group>[^()]*)\)|(?P<power>[−-]?\w+))"
    r"|(?P<raised>[⁰¹²³⁴⁵⁶⁷⁸⁹⁻ⁿ]+)"
    r"|(?P<wide>,\s\s+)"
    r"|(?P<space>\s+)"
    r"|(?P<other>.)",
    re.DOTALL,
)


def to_latex(formula: str) -> str:
    """A formula in LaTeX's mathematics, without delimiters; everything that is no formula stands as text.

    Letters take the digits and the `_name` after them as an index, superscripts and `^` raise, Greek letters may be
    spelt out. No sign of the text has a meaning of its own in the answer.
    """
    found = PART.sub(_part, unicodedata.normalize("NFD", formula))
    return re.sub(r"\s+", " ", found).strip()


def _part(match: re.Match[str]) -> str:
    kind, text = match.lastgroup, match.group()
    if match["prose"]:
        return rf"\text{{{text}}}"
    if match["function"]:
        return f"\\{text} " if text in FUNCTIONS else rf"\operatorname{{{text}}}"
    if match["named"]:
        return _upright(text.split("_"))
    if match["symbol"]:
        return _symbol(match)
    for raised in (match["group"], match["power"]):
        if raised is not None:
            return rf"^{{{to_latex(raised)}}}"
    if match["root"] is not None:
        return rf"\sqrt{{{to_latex(match['root'])}}}"
    if match["raised"]:
        return rf"^{{{text.translate(RAISED)}}}"
    if kind == "wide":
        return r",\quad "
    return " " if kind == "space" else SIGNS.get(text, text)


def _symbol(match: re.Match[str]) -> str:
    name = GREEK.get(match["symbol"], match["symbol"])
    base = VARIANT.get(name, f"\\{name}") if name in GREEK.values() else name
    if match["accent"] in ACCENTS:
        base = rf"\{ACCENTS[match['accent']]}{{{base}}}"
    below = [word for word in match["below"].split("_") if word]
    parts = [match["index"].translate(LOWERED)] if match["index"] else []
    parts += [_upright(below) if len("".join(below)) > 1 else below[0]] if below else []
    index = f"_{{{','.join(parts)}}}" if parts else ""
    return f"{base}{index}" if index or not base.startswith("\\") or base.endswith("}") else f"{base} "


def _upright(words: list[str]) -> str:
    return r"\mathrm{" + r"\ ".join(words) + "}"
