"""What every effect promises, form by form: each check returns what is wrong, in words, and nothing where all is well.

Recovery from data that the same model made shows that a fit can find its own parameters. It is a test of
self-consistency and no proof that the formula is right.
"""

import re
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import islice, product
from pathlib import Path

import numpy as np

from ..core import Array, Param
from ..effects import Effect, Form, catalogue
from ..fitting import fit
from ..fitting.solve import jacobian
from ..laws import get_law
from ..model import Model, Term
from ..records import Record

Values = dict[str, float]
UNITS = {"1", "N", "kN", "MPa", "mm", "s", "m", "min", "K", "deg", "kg"}
FIELDS = {
    "branch": ("direction",),
    "motion": ("velocity", "stroke_speed", "moving"),
    "time": ("time", "segment"),
    "cycle": ("cycle",),
    "temperature": ("temperature",),
}
"""What each need stands for in a record's inputs."""
DRIVEN = "driven pressure"
"""What a form alone may need, beside these."""
LEVERS = {"speed", "pressure", "hold", "reversal", "temperature", "cycles"}
LAW_VALUES = {"a0": -190.0, "a1": 2400.0, "b0": 1600.0, "b1": 5500.0, "c0": -9.0, "c1": 650.0, "mu": 40.0}
LAWS: dict[str, Values] = {"chou_hannaford": {}, "exponential_law": LAW_VALUES}


def model_of(effect: Effect, form: Form, law: str = "chou_hannaford") -> Model:
    """A law with one form of an effect."""
    return Model(get_law(law), (Term(effect, form),))


def plausible(effect: Effect, form: Form, share: float = 1.0) -> Values:
    """Parameters by qualified name: linear ones a typical size off neutral, the others a little off their start."""
    values = {}
    for k, p in enumerate(form.linear):
        values[f"{effect.name}.{p.name}"] = p.clip(p.neutral + share * p.scale * (1.0, 0.7, 0.4)[k % 3])
    for p in form.nonlinear:
        values[f"{effect.name}.{p.name}"] = p.clip(1.15 * p.start if p.start else 0.1 * p.scale)
    return values


def corners(params: tuple[Param, ...], most: int, start: bool = True) -> Iterator[Values]:
    """Values by name at the ends of the bounds (1000 scales out where there is none) and, if asked, at the start."""
    ends = []
    for p in params:
        points = (p.lower, p.start, p.upper) if start else (p.lower, p.upper)
        ends.append([x if np.isfinite(x) else np.sign(x) * 1e3 * p.scale for x in points])
    for corner in islice(product(*ends), most):
        yield dict(zip([p.name for p in params], corner, strict=True))


def showing(record: Record, form: Form) -> Record:
    """The record with what a form needs beyond its effect: waves of the pressure where that must be driven."""
    inputs = record.inputs
    if DRIVEN not in form.needs or inputs.time is None:
        return record
    turn = 2.0 * np.pi / 17.0
    waves, rate = 0.05 * np.sin(turn * inputs.time), 0.05 * turn * np.cos(turn * inputs.time)
    inputs = replace(inputs, pressure=inputs.pressure + waves, pressure_rate=rate)
    return replace(record, inputs=inputs, steady=inputs)


def _unknown(key: str, given: tuple[str, ...], known: set[str]) -> list[str]:
    """What is wrong with words that were `given`, where not all are `known`."""
    unknown = set(given) - known
    return [f"{key}: unknown {', '.join(sorted(unknown))}; expected some of {', '.join(sorted(known))}"] * bool(unknown)


def introduces_itself(effect: Effect, record: Record) -> list[str]:
    """Title, source, test, and needs and levers that exist."""
    found = [f"{key} is empty" for key in ("title", "source", "test") if not getattr(effect, key).strip()]
    found += _unknown("needs", effect.needs, {*FIELDS}) + _unknown("levers", effect.levers, LEVERS)
    if not effect.levers:
        found.append("levers is empty: say what must be varied on the rig to see the effect")
    names = [form.name for form in effect.forms]
    if len(set(names)) < len(names):
        found.append(f"two forms have the same name: {', '.join(names)}")
    if (effect.special_case_of and effect.special_case_of not in catalogue()) or effect.special_case_of == effect.name:
        found.append(f"special_case_of = {effect.special_case_of!r} is no other effect")
    if effect.own and effect.own not in {p.name for form in effect.forms for p in form.linear}:
        found.append(f"own = {effect.own!r} is no size of any form")
    return found


def asks_for_all_it_needs(effect: Effect, record: Record) -> list[str]:
    """With only what `needs` names, every form can be computed."""
    inputs = record.inputs
    optional = [field for need, fields in FIELDS.items() if need != "branch" for field in fields]
    bare = replace(inputs, **dict.fromkeys(optional, None), direction=np.zeros(len(inputs)))
    given = {field: getattr(inputs, field) for need in effect.needs for field in FIELDS[need]}
    enough = replace(bare, **given)
    found = []
    if effect.missing(bare) != list(effect.needs) or effect.missing(enough):
        found.append("needs does not tell a record that holds enough from one that lacks it")
    for form in effect.forms:
        try:
            columns = form.columns(enough, {p.name: p.start for p in form.nonlinear}, np.full(len(enough), 300.0))
        except (TypeError, AttributeError, AssertionError) as error:
            found.append(f"form {form.name} uses what needs = {effect.needs} does not name ({said(error)})")
            continue
        if not np.isfinite(columns).all():
            found.append(f"form {form.name} is not finite on a record with only {', '.join(effect.needs) or 'statics'}")
    return found


def says_what_it_is(effect: Effect, form: Form, record: Record) -> list[str]:
    """A name, a formula, at least one size, names that are unique and documented."""
    names = [p.name for p in form.params]
    checks = {
        f"the form's name {form.name!r} is no Python name": form.name.isidentifier(),
        "formula is empty": bool(form.formula),
        "linear is empty: without a linear parameter nothing can be added": bool(form.linear),
        f"two parameters have the same name: {', '.join(names)}": len(set(names)) == len(names),
    }
    found = [words for words, fine in checks.items() if not fine]
    odd = [n for n in names if not n.isidentifier() or "__" in n]
    found += _unknown("needs", form.needs, {*FIELDS, DRIVEN})
    found += [f"parameter {n!r} is no Python name without a double underscore" for n in odd]
    return found + [f"parameter {p.name} says nothing about itself (doc)" for p in form.params if not p.doc]


def units_can_be_read(effect: Effect, form: Form, record: Record) -> list[str]:
    """Units are products and quotients of the known ones."""
    found = []
    for p in form.params:
        symbols = [s for s in re.split(r"[·/*()]", re.sub(r"⁻¹|\^\d", "", p.unit)) if s]
        if not symbols or set(symbols) - UNITS:
            found.append(f"parameter {p.name} has the unit {p.unit!r}; expected {', '.join(sorted(UNITS))}, · and /")
    return found


def columns_are_finite(effect: Effect, form: Form, record: Record) -> list[str]:
    """A column per linear parameter, a row per sample, finite at the corners of the others' bounds."""
    inputs = record.inputs
    force = get_law("exponential_law").force(inputs.pressure, inputs.contraction, inputs.specimen, LAW_VALUES)
    for corner in corners(form.nonlinear, 64):
        columns = form.columns(inputs, corner, force)
        wrong = _wrong_columns(columns, len(inputs), form)
        if wrong:
            return [f"{wrong} at {_told(corner)}"]
    return []


def edges_are_survived(effect: Effect, form: Form, record: Record) -> list[str]:
    """No pressure, vacuum, a stretched muscle, a wall that is not given, a single sample."""
    inputs = record.inputs
    n = len(inputs)
    odd = replace(
        inputs,
        pressure=np.linspace(-0.02, 1.0, n),
        contraction=np.linspace(-0.05, 0.34, n),
        specimen=replace(inputs.specimen, wall_thickness_mm=None),
    )
    shape = {p.name: p.start for p in form.nonlinear}
    found = []
    for what, at in (("at −0.02 to 1 MPa, −5 to 34 % and no wall", odd), ("with one sample", inputs.take(slice(1)))):
        wrong = _wrong_columns(form.columns(at, shape, np.full(len(at), 500.0)), len(at), form)
        if wrong:
            found.append(f"{wrong} {what}")
    return found


def pieces_make_the_whole(effect: Effect, form: Form, record: Record) -> list[str]:
    """A form that does not say it remembers gives a sample the same columns whatever lies between the first and it."""
    force = 300.0 + 40.0 * record.inputs.displacement_mm
    for corner in corners(form.nonlinear, 9):
        whole = form.columns(record.inputs, corner, force)
        for piece in () if form.remembers else pieces(len(record)):
            near = form.columns(record.inputs.take(piece), corner, force[piece])
            if not np.allclose(near, whole[piece], 1e-9, 1e-12):
                return ["its columns hang on the record's past, which it does not say; add remembers=True to the form"]
    return []


def pieces(n: int) -> Iterator[Array]:
    """Indices (m,) of some of n samples, the first among them: each stretch of 37, and every fifth."""
    for begin in range(1, n, 37):
        yield np.r_[0, begin : min(begin + 37, n)]
    yield np.arange(0, n, 5)


def force_is_finite(effect: Effect, form: Form, record: Record) -> list[str]:
    """At plausible values and at the corners of all bounds."""
    model = model_of(effect, form)
    points = [plausible(effect, form)]
    points += [{f"{effect.name}.{k}": v for k, v in c.items()} for c in corners(form.params, 32, start=False)]
    wrong = [v for v in points if not np.isfinite(model.force(record.inputs, v)).all()]
    return [f"the model's force is not finite at {_told(wrong[0])}; narrow the bounds"] if wrong else []


def neutral_is_the_law_alone(effect: Effect, form: Form, record: Record) -> list[str]:
    """For every shape, and where a pressure sensor reads a little below zero."""
    lowest = record.inputs.pressure - record.inputs.pressure.min() - 0.002
    for inputs, law in product((record.inputs, replace(record.inputs, pressure=lowest)), LAWS):
        model = model_of(effect, form, law)
        alone = Model(model.law).force(inputs, LAWS[law])
        for corner in corners(form.nonlinear, 9):
            others = {f"{effect.name}.{k}": v for k, v in corner.items()}
            off = np.abs(model.force(inputs, model.neutral(inputs) | LAWS[law] | others) - alone)
            if not np.all(off <= 1e-10 + 1e-12 * np.abs(alone)):
                return [f"at its neutral size it still changes the force by {off.max():.3g} N (law {law})"]
    return []


def start_is_inside(effect: Effect, form: Form, record: Record) -> list[str]:
    """Neutral values and the grids lie within the bounds."""
    outside = [p for p in form.linear if p.clip(p.neutral) != p.neutral]
    found = [f"size {p.name}: neutral {p.neutral:g} is out of bounds" for p in outside]
    beyond = [(p.name, x) for p in form.nonlinear for x in p.grid if p.clip(x) != x]
    return found + [f"{name}: {x:g} in its grid is out of bounds" for name, x in beyond]


def it_matters(effect: Effect, form: Form, record: Record) -> list[str]:
    """A plausible size changes the force, by 0.02 N to 5 kN rms on a record that excites everything."""
    inputs = record.inputs
    base = Model(get_law("chou_hannaford"))
    change = model_of(effect, form).force(inputs, plausible(effect, form)) - base.force(inputs, {})
    rms = float(np.sqrt(np.mean(change**2)))
    if 0.02 < rms < 5e3:
        return []
    return [f"linear ones at their scale change the force by {rms:.3g} N rms; set scale to what a 20 mm muscle shows"]


def derivatives_agree(effect: Effect, form: Form, record: Record) -> list[str]:
    """The fit's Jacobian against Richardson's extrapolation of central differences with steps of another size."""
    model = model_of(effect, form, "exponential_law")
    values = LAW_VALUES | plausible(effect, form)
    inputs = record.inputs
    matrix = jacobian(model, inputs, values, model.force(inputs, values))
    found = []
    for column, p in zip(matrix.T, model.params, strict=True):
        step = 2e-4 * max(abs(values[p.name]), 1e-2 * p.scale if p.scale != 1.0 else 1e-2)

        def slope(h: float, name: str = p.name) -> Array:
            up, down = (model.force(inputs, values | {name: values[name] + s}) for s in (h, -h))
            return (up - down) / (2.0 * h)

        expected = (4.0 * slope(step / 2.0) - slope(step)) / 3.0
        off = np.abs(column - expected) / (np.abs(expected).max() + 1e-9)
        kinks = 0.01 if form.remembers else 0.002  # a slipping element or a clipped pressure has a few
        if not np.mean(off > 2e-4) <= kinks:
            found.append(f"the force is not smooth in {p.name}: derivatives differ by {off.max():.2g} of the largest")
    return found


def force_solves_for_itself(effect: Effect, form: Form, record: Record) -> list[str]:
    """A model that depends on its own force agrees with the force it returns."""
    for share in (0.3, 1.0, 3.0) if form.uses_force else ():
        model = model_of(effect, form, "exponential_law")
        values = LAW_VALUES | plausible(effect, form, share)
        force = model.force(record.inputs, values)
        columns, fixed = model.design(record.inputs, values, force)
        off = np.abs(fixed + columns @ [values[p.name] for p in model.linear] - force).max()
        if not off <= 1e-6:
            return [f"at {share:g} of its typical size the force does not settle (off by {off:.2g} N)"]
    return []


def it_can_be_stepped(effect: Effect, form: Form, record: Record) -> list[str]:
    """In a closed loop, a row for each muscle, traced by JAX."""
    from ..leg.loop_check import loop_fault

    return [f"it cannot be stepped through time: {fault}" for fault in [loop_fault(form, record.specimen)] if fault]


def a_fit_finds_it(effect: Effect, form: Form, record: Record) -> list[str]:
    """Clean data made with plausible values on the ideal law, fitted from the start values every fit has."""
    model, truth = model_of(effect, form), plausible(effect, form)
    made = replace(record, force=model.force(record.inputs, truth))
    found = fit(model, made)
    change = made.force - Model(model.law).force(record.inputs, {})
    problems = [] if found.converged else [f"a fit to clean data of its own does not converge ({found.message})"]
    if not found.rmse < 1e-3 * np.sqrt(np.mean(change**2)):
        cure = "give the nonlinear parameters a grid of starts"
        problems.append(f"a fit to clean data of its own leaves {found.rmse:.3g} N; {cure}")
    linear = {f"{effect.name}.{p.name}" for p in form.linear}
    for one in found.estimates:
        if one.identified and abs(one.value - truth[one.name]) > 0.02 * abs(truth[one.name]) + 1e-9:
            problems.append(f"a fit finds {one.name} = {one.value:.4g} where {truth[one.name]:.4g} made the data")
        if one.name in linear and not one.identified:
            problems.append(f"a fit cannot pin the size {one.name}; two columns may be the same")
    return problems


EFFECT_CHECKS = (introduces_itself, asks_for_all_it_needs)
BASIC = (says_what_it_is, columns_are_finite)
"""Without these the others would only repeat what is wrong."""
FORM_CHECKS = (
    *BASIC,
    units_can_be_read,
    edges_are_survived,
    pieces_make_the_whole,
    force_is_finite,
    neutral_is_the_law_alone,
    start_is_inside,
    it_matters,
    derivatives_agree,
    force_solves_for_itself,
    it_can_be_stepped,
    a_fit_finds_it,
)


def said(error: Exception) -> str:
    """An error with the line of the file in which it was raised."""
    places = traceback.extract_tb(error.__traceback__)
    own = [place for place in places if not place.filename.startswith(str(Path(__file__).parents[1]))]
    line = f", line {own[0].lineno} of {Path(own[0].filename).name}" if own else ""
    return f"{type(error).__name__}: {error}{line}"


def _wrong_columns(columns: Array, n: int, form: Form) -> str:
    shape = np.shape(columns)
    if shape != (n, len(form.linear)):
        return f"its columns have the shape {shape}; expected (samples, linear) = {(n, len(form.linear))}"
    return "" if np.isfinite(columns).all() else "its columns are not finite"


def _told(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:.4g}" for name, value in values.items()) or "any shape"
