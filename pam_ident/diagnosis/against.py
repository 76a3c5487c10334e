"""Two records beside each other: what differs in parameters, in force, in effects, and in what the error follows."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student_t

from ..core import FitError, Inputs
from ..core.digits import known_to, newtons, percent
from ..effects import named
from ..fitting import Fit, fit
from ..fitting.covariance import student
from ..fitting.solve import jacobian
from ..model import as_term
from .drivers import DRIVERS
from .nouns import Diagnosis

Array = np.ndarray
Untold = tuple[dict[str, str], dict[str, str]]
SURE = 0.01
"""Probability by chance, of all parameters together, below which a difference counts."""
CLEAR = 3.0
"""Standard errors from which a parameter is no zero."""
SHARE = 0.05
"""Difference of a share of the squared error that is told."""
PROPORTIONAL = 0.9
"""Share of the squares of a difference from which it is said to be in proportion to the force."""


@dataclass(frozen=True)
class ParameterDifference:
    """A parameter in both records, each with its standard error; `low` … `high` is the 95 % interval of `difference`,
    B − A, and `p` the probability of one as large by chance, by Holm (1979) for all parameters. NaN where a record does
    not determine it."""

    name: str
    unit: str
    a: float
    a_stderr: float
    b: float
    b_stderr: float
    difference: float
    low: float
    high: float
    p: float = math.nan

    @property
    def differs(self) -> bool:
        """Whether it is no chance."""
        return self.p < SURE


@dataclass(frozen=True)
class EffectDifference:
    """An effect with its probability in each record, None where that record cannot show it; `where` it is named, or
    what that record cannot tell from it: both, a or b."""

    effect: str
    a: float | None
    b: float | None
    where: str


@dataclass(frozen=True)
class ForceDifference:
    """Modelled force of B less that of A in N at the `n` states of A that lie in what both records span: mean with its
    95 % interval, rms, and the largest with its state; and the share of A's force that explains most of it, with the
    share of its squares that this explains."""

    n: int
    mean: float
    low: float
    high: float
    rms: float
    largest: float
    pressure_MPa: float
    contraction: float
    share: float
    explained: float


@dataclass(frozen=True)
class Against:
    """Record A against record B. `a` and `b` are their diagnoses by one law; `fits` those of one model, the law with
    what was named in either, to each record, less what that cannot hold, from which `parameters` and `force` are, of
    what both hold (None where they span nothing in common)."""

    a: Diagnosis
    b: Diagnosis
    fits: tuple[Fit, Fit]
    parameters: tuple[ParameterDifference, ...]
    effects: tuple[EffectDifference, ...]
    force: ForceDifference | None
    sentence: str

    @property
    def names(self) -> tuple[str, str]:
        """What the records are called, where both have one name their muscles, else A and B."""
        return _names(self.a, self.b)


def against(a: Diagnosis, b: Diagnosis) -> Against:
    """What differs between two records that were diagnosed by the same law.

    Args:
        a, b: their diagnoses.

    Raises:
        FitError: where the law cannot be fitted to one of them.

    Intervals take the records as independent, with the degrees of freedom of Welch and Satterthwaite.

    Example:
        >>> from pam_ident.records import read_record
        >>> from pam_ident.tasks.diagnose import diagnose_record
        >>> from pam_ident.tasks.setup import Setup
        >>> setup = Setup("exponential_law")
        >>> a, b = (diagnose_record(read_record(name), setup) for name in ("nothing_hidden", "hidden_effect"))
        >>> print([(one.effect, one.where) for one in against(a, b).effects])
        [('pressure_friction', 'b')]
    """
    untold = _untold(a, b)
    fits = _fits(a, b, untold)
    parameters = _parameters(*fits)
    effects, force = _effects(a, b, untold), _force(*fits)
    return Against(a, b, fits, parameters, effects, force, _sentence(a, b, parameters, effects, force))


def _untold(a: Diagnosis, b: Diagnosis) -> Untold:
    """Names of each record that it cannot tell from one of the other's, and that: it is the same, which only the other
    tells."""

    def found(one: Diagnosis, other: Diagnosis) -> dict[str, str]:
        own = [(first, next((n for n in rest if n in other.selected), None)) for first, *rest in one.groups]
        return {first: named for first, named in own if named and first not in other.selected}

    of_a = found(a, b)
    return of_a, {name: named for name, named in found(b, a).items() if name not in of_a.values()}


def _fits(a: Diagnosis, b: Diagnosis, untold: Untold) -> tuple[Fit, Fit]:
    """One model fitted to both; to each without an effect that it cannot hold."""
    base, extra = a.base.model, tuple(t.effect for t in (*a.best.model.terms, *b.best.model.terms))
    pairs = zip((a, b), untold, strict=True)
    told = [label for one, same in pairs for n, label in zip(one.selected, one.labels, strict=True) if n not in same]
    named = [as_term(label, extra) for label in told]
    terms = list({term.effect.name: term for term in named}.values())
    records = a.base.record, b.base.record
    held = [[term for term in terms if not term.effect.missing(record.inputs)] for record in records]
    for some in (held, [[], []]):
        try:
            first, second = (fit(base.adding(*mine), record) for mine, record in zip(some, records, strict=True))
            return first, second
        except FitError:
            if not any(some):
                raise
    raise AssertionError


def _parameters(a: Fit, b: Fit) -> tuple[ParameterDifference, ...]:
    """Of the parameters that both have. Those of a free form draw a curve together, which others may draw as well: none
    of them is compared by itself."""
    found, chances = [], []
    drawn = tuple(f"{term.effect.name}." for term in a.model.terms if term.form.free)
    others = {one.name: one for one in b.estimates}
    known = [one for one in a.estimates if one.name in others and not one.name.startswith(drawn)]
    for one, other in ((one, others[one.name]) for one in known):
        both = one.identified and other.identified
        spread = math.hypot(one.stderr, other.stderr) if both else math.nan
        apart = other.value - one.value
        freedom = _freedom(one.stderr, one.dof, other.stderr, other.dof) if spread > 0.0 else math.nan
        half = spread * float(student(np.array(freedom))) if spread > 0.0 else math.nan
        chances.append(2.0 * float(student_t.sf(abs(apart) / spread, freedom)) if spread > 0.0 else math.nan)
        found.append(
            ParameterDifference(one.name, one.unit, one.value, one.stderr, other.value, other.stderr, apart,
                                apart - half, apart + half)
        )  # fmt: skip
    return tuple(replace(one, p=p) for one, p in zip(found, _holm(chances), strict=True))


def _freedom(first: float, first_dof: float, second: float, second_dof: float) -> float:
    """Degrees of freedom of a difference (Welch 1947)."""
    return (first**2 + second**2) ** 2 / (first**4 / max(first_dof, 1.0) + second**4 / max(second_dof, 1.0))


def _holm(chances: list[float]) -> list[float]:
    """Probabilities by chance for all that were looked at (Holm 1979); NaN stays."""
    known = sorted((p, k) for k, p in enumerate(chances) if math.isfinite(p))
    found, most = list(chances), 0.0
    for rank, (p, k) in enumerate(known):
        most = max(most, min(p * (len(known) - rank), 1.0))
        found[k] = most
    return found


def _effects(a: Diagnosis, b: Diagnosis, untold: Untold) -> tuple[EffectDifference, ...]:
    chances = [{s.effect: s.probability if s.status == "candidate" else None for s in one.ranking} for one in (a, b)]
    there = [{same.get(n, n) for n in one.selected} for one, same in zip((a, b), untold, strict=True)]
    where = {(True, True): "both", (True, False): "a", (False, True): "b"}
    names = [n for n in dict.fromkeys((*a.selected, *b.selected)) if n in there[0] | there[1]]
    return tuple(
        EffectDifference(n, chances[0].get(n), chances[1].get(n), where[n in there[0], n in there[1]]) for n in names
    )


def _force(a: Fit, b: Fit) -> ForceDifference | None:
    """B's model at A's states, less A's."""
    inputs, other = a.record.inputs, b.record.inputs
    inside = np.ones(len(a.record), bool)
    for mine, theirs in ((inputs.pressure, other.pressure), (inputs.contraction, other.contraction)):
        inside &= (mine >= theirs.min()) & (mine <= theirs.max())
    if not inside.any():
        return None
    moved = replace(inputs, specimen=b.record.specimen)
    shared = {*a.model.labels} & {*b.model.labels}
    mine, theirs = (replace(m, terms=tuple(t for t in m.terms if t.label in shared)) for m in (a.model, b.model))
    own = mine.force(inputs, a.values)[inside]
    apart = theirs.force(moved, b.values)[inside] - own
    half = math.hypot(_half(a, inputs, inside), _half(b, moved, inside))
    mean, at = float(apart.mean()), int(np.abs(apart).argmax())
    share, squares = float(own @ apart) / max(float(own @ own), 1e-300), max(float(apart @ apart), 1e-300)
    return ForceDifference(
        int(inside.sum()), mean, mean - half, mean + half, float(np.sqrt(np.mean(apart**2))), float(apart[at]),
        float(inputs.pressure[inside][at]), float(inputs.contraction[inside][at]), share,
        share**2 * float(own @ own) / squares,
    )  # fmt: skip


def _half(one: Fit, inputs: Inputs, inside: Array) -> float:
    """Half of the 95 % interval of a model's mean force over some states, NaN without a covariance."""
    if one.covariance is None:
        return 0.0 if not one.estimates else math.nan
    force = one.model.force(inputs, one.values)
    slopes = jacobian(one.model, inputs, one.values, force)[inside].mean(axis=0)
    index = [k for k, e in enumerate(one.estimates) if e.name in one.free]
    stderr, dof = one.covariance.error(slopes[None, index])
    return float(student(dof)[0] * stderr[0])


def _sentence(
    a: Diagnosis,
    b: Diagnosis,
    parameters: tuple[ParameterDifference, ...],
    effects: tuple[EffectDifference, ...],
    force: ForceDifference | None,
) -> str:
    names, parts = _names(a, b), []
    if force is not None:
        error = (force.high - force.low) / 4.0
        parts.append(
            f"Where both were measured, {names[1]} pulls {_more(force.mean, error)} than {names[0]} on average "
            f"({_between(force.low, force.high)}); the difference is {newtons(force.rms)} rms"
        )
        if force.explained >= PROPORTIONAL and not force.low <= 0.0 <= force.high:
            more = f"{percent(abs(force.share))} {'more' if force.share > 0.0 else 'less'}"
            parts[-1] += f", {percent(force.explained)} of its squares as a force that is {more} all over"
    known = [one for one in parameters if math.isfinite(one.p)]
    apart = sorted((one for one in known if one.differs), key=lambda one: one.p)
    which = f"({', '.join(one.name for one in apart[:4])}{' …' if len(apart) > 4 else ''})" if apart else "by itself"
    parts.append(
        f"Of {len(known)} parameters {len(apart) or 'none'} differ{'s' * (len(apart) < 2)} beyond chance {which}"
    )
    own = (*a.best.model.own, *b.best.model.own)
    told: dict[str, list[str]] = {}
    for one in effects:
        rivals = _rivals(one, a, b)
        told.setdefault(_missing_in(one, names, known), []).append(
            " or ".join(named(n, own) for n in (one.effect, *rivals))
        )
    parts += [f"Missing in {who}: {', '.join(found)}" for who, found in told.items()]
    shares = [{one.what: one.share for one in each.follows} for each in (a, b)]
    words = {one.what: one.text for each in (a, b) for one in each.follows}
    both = [each.base.record.inputs for each in (a, b)]
    seen = {d.what for d in DRIVERS if d.what in words and all(d.states(inputs) is not None for inputs in both)}
    moved = [(shares[1].get(w, 0.0) - shares[0].get(w, 0.0), w) for w in words if w in seen]
    most = max(moved, key=lambda one: abs(one[0]), default=(0.0, ""))
    if abs(most[0]) >= SHARE:
        first, second = (
            f"{percent(each.get(most[1], 0.0))} in {name}" for each, name in zip(shares, names, strict=True)
        )
        parts.append(f"Of the law's squared error {first} and {second} follow {words[most[1]]}")
    return ". ".join(parts) + "."


def _names(a: Diagnosis, b: Diagnosis) -> tuple[str, str]:
    records = a.base.record, b.base.record
    for first, second in (tuple(r.name for r in records), tuple(r.specimen.name for r in records)):
        if first != second:
            return first, second
    return "A", "B"


def _rivals(one: EffectDifference, a: Diagnosis, b: Diagnosis) -> list[str]:
    """Effects that none of the records in which one was found can tell from it."""
    found = {"a": [a], "b": [b], "both": [a, b]}[one.where]
    name = one.effect.partition(":")[0]
    first, *others = ({first: rest for first, *rest in each.groups}.get(name, []) for each in found)
    return [n for n in first if all(n in rest for rest in others)]


def _missing_in(one: EffectDifference, names: tuple[str, str], known: list[ParameterDifference]) -> str:
    """Where an effect is missing, in words. One that is named in one record alone may be as large in the other, by the
    parameters that are `known` of both."""
    if one.where == "both":
        return "both"
    k = "ab".index(one.where)
    if (one.a, one.b)[1 - k] is None:
        return f"{names[k]}, which {names[1 - k]} could not show"
    own = [each for each in known if each.name.startswith(f"{one.effect.partition(':')[0]}.")]
    there = [abs(each.b) > CLEAR * each.b_stderr if k == 0 else abs(each.a) > CLEAR * each.a_stderr for each in own]
    alike = any(there) and not any(each.differs for each in own)
    return f"{names[k]} alone{f', though about as large in {names[1 - k]}' * alike}"


def _more(force: float, error: float) -> str:
    return f"{known_to(abs(force), error)} N {'more' if force >= 0.0 else 'less'}"


def _between(low: float, high: float) -> str:
    """The 95 % interval of a difference, in words that need no sign."""
    if not math.isfinite(low + high):
        return "its interval is not determined"
    error = (high - low) / 4.0
    if (low >= 0.0) != (high >= 0.0):
        return f"95 %: from {_more(low, error)} to {_more(high, error)}"
    near, far = sorted((low, high), key=abs)
    return f"95 %: {known_to(abs(near), error)} to {_more(far, error)}"
